"""Speed limits by what the camera sees: of low obstacles, and of the road.

Assured clear distance: the less of the road is seen, the slower. The reference speed is kept where it allows a stop
before a low obstacle that comes into sight. Where even a good view does not allow it, it is reduced in the ratio of
both views. A reference speed far above what a good view allows is not limited: its user has chosen not to stop for low
obstacles.
"""

from math import inf, isinf, sqrt

from vpf_sim.configuration import setting, settings
from vpf_sim.driver_interface import DriverSetup
from vpf_sim.types import LowObstacleRange, Perception


@settings
class ClearDistanceConfig:
    """The stop that must be possible within what is seen."""

    brake_mps2: float = setting("Deceleration of the stop.", gt=0.0)
    reaction_s: float = setting("Time until the brake takes effect.", ge=0.0)
    standoff_m: float = setting("Distance from the obstacle at which the car stops.", gt=0.0)
    enough_share: float = setting("Share of the reference speed that a good view allows.", gt=0.0)
    cautious_mps: float = setting("Least speed where little of the road is visible.", gt=0.0)


@settings
class VisibilityConfig:
    """Speed where little is seen."""

    lost_road_mps: float = setting("Speed where the road is not visible.", gt=0.0)
    lost_road_m: float = setting("Distance without a visible road after which the car stops.", gt=0.0)
    clear_distance: ClearDistanceConfig = setting("Slows where little of the road is seen.")


class SpeedInSight:
    """The speed limit during one episode."""

    def __init__(self, config: VisibilityConfig, setup: DriverSetup) -> None:
        self._config, self._setup = config, setup
        self._lost_m = 0.0  # way since the road was seen

    def limit(self, perception: Perception, way_m: float) -> float:
        """m/s at most after the car has come `way_m` since the last step; inf where all is seen."""
        config, road = self._config, perception.road
        allowed = speed_within_clear_distance(perception.low_range_m, config.clear_distance, self._setup)
        if max(road.confidence, road.lane_confidence) > 0.0:
            self._lost_m = 0.0
            return allowed
        self._lost_m += way_m
        return min(allowed, config.lost_road_mps if self._lost_m < config.lost_road_m else 0.0)


def speed_within_clear_distance(seen_m: LowObstacleRange, config: ClearDistanceConfig, setup: DriverSetup) -> float:
    """m/s at most by the assured clear distance; inf where it sets no limit.

    A reference speed below `cautious_mps` is never limited.
    """
    reference_mps = setup.speed_reference_mps
    if reference_mps <= config.cautious_mps:
        return inf

    def safe(range_m: float) -> float:
        way = range_m - 0.5 * setup.vehicle.length_m - config.standoff_m
        return max(stopping_speed(way, config.brake_mps2, config.reaction_s), config.cautious_mps)

    with_good_view = safe(seen_m.best_m)
    if isinf(seen_m.best_m) or with_good_view < config.enough_share * reference_mps:
        return inf
    share = safe(seen_m.now_m) / min(with_good_view, reference_mps)
    return max(min(share, 1.0) * reference_mps, config.cautious_mps)


def stopping_speed(way_m: float, brake_mps2: float, reaction_s: float) -> float:
    """m/s from which the car stands after a way v t + v^2 / (2 b); 0 where there is none."""
    return brake_mps2 * (sqrt(reaction_s**2 + 2.0 * max(way_m, 0.0) / brake_mps2) - reaction_s)
