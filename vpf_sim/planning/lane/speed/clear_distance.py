"""Speed limit by the assured clear distance: the less of the road is seen, the slower.

With D from the bumper to where a low obstacle would be detected, less the standoff, reaction time t and deceleration b,
the car can stop from the speed of v t + v^2 / (2 b) = D. The reference speed is kept where it allows the stop. Where
even a good view does not allow it, it is reduced in the ratio of both views. A reference speed far above what a good
view allows is not limited: its user has chosen not to stop for low obstacles.
"""

from math import inf, isinf, sqrt

from vpf_sim.planning.lane.speed_config import ClearDistanceConfig, TentativeLimitConfig
from vpf_sim.types import VehicleModel


def safe_speed(sight_m: float, config: ClearDistanceConfig | TentativeLimitConfig, vehicle: VehicleModel) -> float:
    """m/s from which the car stops within a distance from the pose: the inverse of `stopping_way`."""
    way = max(sight_m - 0.5 * vehicle.length_m - config.standoff_m, 0.0)
    brake, reaction = config.brake_mps2, config.reaction_s
    return max(brake * (sqrt(reaction**2 + 2.0 * way / brake) - reaction), config.least_mps)


def speed_within_clear_distance(
    sight_m: tuple[float, float], speed_reference_mps: float, config: ClearDistanceConfig, vehicle: VehicleModel
) -> float:
    """m/s at most by the assured clear distance; inf where it sets no limit.

    `sight_m` as in `Perception.low_range_m`. A reference speed below `least_mps` is never limited.
    """
    if speed_reference_mps <= config.least_mps:
        return inf
    now_m, good_m = sight_m
    with_good_view = safe_speed(good_m, config, vehicle)
    if isinf(good_m) or with_good_view < config.enough_share * speed_reference_mps:
        return inf
    share = safe_speed(now_m, config, vehicle) / min(with_good_view, speed_reference_mps)
    return max(min(share, 1.0) * speed_reference_mps, config.least_mps)
