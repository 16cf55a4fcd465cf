"""CARLA's driving scores 2.0 and 2.1: route completion reduced by infractions, 0 to 1.

Source: CARLA Autonomous Driving Leaderboard, https://leaderboard.carla.org/evaluation_v2_0/ and evaluation_v2_1. Only
collisions and driving off the road are scored; the other infractions need traffic lights and scripted scenarios.
"""

from collections.abc import Iterable
from math import prod

import numpy as np

from vpf_sim.types import Floats

FACTOR_2_0 = {"pedestrian": 0.50, "vehicle": 0.60, "static": 0.65}
WEIGHT_2_1 = {"pedestrian": 1.00, "vehicle": 0.70, "static": 0.60}
CLASS = {"pedestrian": "pedestrian", **dict.fromkeys(("car", "van", "truck", "cyclist"), "vehicle")}


def driving_score_2_0(completion: float, kinds_hit: Iterable[str], off_lane_share: float) -> float:
    """completion x product of a factor a collision x (1 - off-lane share)."""
    return completion * prod(FACTOR_2_0[_class(kind)] for kind in kinds_hit) * (1.0 - off_lane_share)


def driving_score_2_1(completion: float, kinds_hit: Iterable[str], off_lane_share: float) -> float:
    """completion x (1 - off-lane share) / (1 + sum of a weight a collision)."""
    return completion * (1.0 - off_lane_share) / (1.0 + sum(WEIGHT_2_1[_class(kind)] for kind in kinds_hit))


def off_lane_share(route_m: Floats, outside: Floats) -> float:
    """Share of the driven distance with a corner of the ego off the carriageway, 0 to 1, from (N,) steps.

    All lanes run one way, so a lane change is no infraction.
    """
    driven = np.abs(np.diff(route_m))
    total = float(np.sum(driven))
    return float(np.sum(driven[outside[:-1] > 0.0])) / total if total > 0.0 else 0.0


def _class(kind: str) -> str:
    return CLASS.get(kind, "static")
