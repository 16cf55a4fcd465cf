"""Speed by what can be seen: the less of the road a low body would be suspected on, the slower.

The rule of the assured clear distance ahead: with D from the bumper to where such a body would be suspected, less what
is kept free, reaction time t and deceleration b, the car can stop from the speed of v t + v^2 / (2 b) = D. How fast to
go where all can be seen is the user's choice, the reference speed: it is kept where it allows the stop. Where even a
good view does not, it is cut by as much as the speed that does is less now than with one. Who asks for far more than a
good view would allow has chosen not to stop for low bodies.
"""

from math import inf, isinf, sqrt

from vpf_sim.planning.lane.speed_config import ClearDistanceConfig, TentativeLimitConfig
from vpf_sim.types import VehicleModel


def safe_speed(sight_m: float, config: ClearDistanceConfig | TentativeLimitConfig, vehicle: VehicleModel) -> float:
    """m/s from which the car stops within a distance from the pose: `stopping_way` the other way round."""
    way = max(sight_m - 0.5 * vehicle.length_m - config.standoff_m, 0.0)
    brake, reaction = config.brake_mps2, config.reaction_s
    return max(brake * (sqrt(reaction**2 + 2.0 * way / brake) - reaction), config.least_mps)


def speed_within_clear_distance(
    sight_m: tuple[float, float], speed_reference_mps: float, config: ClearDistanceConfig, vehicle: VehicleModel
) -> float:
    """m/s at most by what is not seen, inf where that is no reason; `sight_m` as in `Perception.low_range_m`.

    Who wants to go no faster than `least_mps` is never too fast.
    """
    if speed_reference_mps <= config.least_mps:
        return inf
    now_m, good_m = sight_m
    with_good_view = safe_speed(good_m, config, vehicle)
    if isinf(good_m) or with_good_view < config.enough_share * speed_reference_mps:
        return inf
    share = safe_speed(now_m, config, vehicle) / min(with_good_view, speed_reference_mps)
    return max(min(share, 1.0) * speed_reference_mps, config.least_mps)
