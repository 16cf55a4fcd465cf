"""Speed limit by the assured clear distance: the less of the road is seen, the slower.

The reference speed is kept where it allows a stop before a low obstacle that comes into sight. Where even a good view
does not allow it, it is reduced in the ratio of both views. A reference speed far above what a good view allows is not
limited: its user has chosen not to stop for low obstacles.
"""

from math import inf, isinf

from vpf_sim.driver_interface import DriverSetup
from vpf_sim.planning.lane.lane_settings import BrakingConfig, ClearDistanceConfig
from vpf_sim.planning.lane.stopping_distance import stopping_speed
from vpf_sim.types import LowObstacleRange


def speed_within_clear_distance(
    sight_m: LowObstacleRange, config: ClearDistanceConfig, braking: BrakingConfig, setup: DriverSetup
) -> float:
    """m/s at most by the assured clear distance; inf where it sets no limit.

    A reference speed below `cautious_mps` is never limited.
    """
    reference_mps = setup.speed_reference_mps
    if reference_mps <= braking.cautious_mps:
        return inf

    def safe(range_m: float) -> float:
        way = range_m - 0.5 * setup.vehicle.length_m - config.standoff_m
        return max(stopping_speed(way, config.brake_mps2, braking.reaction_s), braking.cautious_mps)

    with_good_view = safe(sight_m.best_m)
    if isinf(sight_m.best_m) or with_good_view < config.enough_share * reference_mps:
        return inf
    share = safe(sight_m.now_m) / min(with_good_view, reference_mps)
    return max(min(share, 1.0) * reference_mps, braking.cautious_mps)
