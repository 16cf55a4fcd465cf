"""Speed by what can be seen: the car can always stop on the way on which a low body would be known by now.

The rule of the assured clear distance ahead. With D from the bumper to where such a body would be known, less what is
kept free, reaction time t and deceleration b, the speed is that of v t + v^2 / (2 b) = D.
"""

from dataclasses import dataclass, replace
from math import inf, isinf, sqrt

from vpf_sim.types import Reference, VehicleModel


@dataclass(frozen=True, slots=True)
class SightConfig:
    """The stop that must be possible."""

    brake_mps2: float
    reaction_s: float
    standoff_m: float
    least_mps: float  # however little is seen: as near as the car then comes, its other ways of seeing tell a body

    def __post_init__(self) -> None:
        for name in self.__slots__:
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name}: expected > 0, got {getattr(self, name)}")


def safe_speed(sight_m: float, config: SightConfig, vehicle: VehicleModel) -> float:
    """m/s from which the car stops within the distance seen, from the pose; inf where that is not known."""
    if isinf(sight_m):
        return inf
    way = max(sight_m - 0.5 * vehicle.length_m - config.standoff_m, 0.0)
    brake, reaction = config.brake_mps2, config.reaction_s
    return max(brake * (sqrt(reaction**2 + 2.0 * way / brake) - reaction), config.least_mps)


def within_sight(reference: Reference, sight_m: float, config: SightConfig, vehicle: VehicleModel) -> Reference:
    """The reference, no faster than is safe."""
    return replace(reference, speed_mps=min(reference.speed_mps, safe_speed(sight_m, config, vehicle)))
