"""The state vector of learned policies: nothing in world coordinates, every value in [-1, 1]."""

import numpy as np

from vpf_sim.geometry import vehicle_from_world
from vpf_sim.types import Floats, Singles

STATE = ("speed", "yaw_rate", "goal_forward", "goal_right", "throttle", "steering")
SPEED_SCALE_MPS = 60.0  # the ego's limit
YAW_RATE_SCALE_RADPS = 4.0  # the sensor's limit
GOAL_SCALE_M = 100.0  # the distance to the goal at which its normalised coordinates are cut off


def policy_state(
    pose: Floats, speed_mps: float, yaw_rate_radps: float, goal_m: Floats | tuple[float, float], action: Floats
) -> Singles:
    """(6,) the values of `STATE`: of a pose (x m, y m, yaw rad), and of the last action, (2,) throttle and steering."""
    goal = vehicle_from_world(np.asarray(goal_m), pose) / GOAL_SCALE_M
    values = [speed_mps / SPEED_SCALE_MPS, yaw_rate_radps / YAW_RATE_SCALE_RADPS, *goal, *action]
    state: Singles = np.clip(values, -1.0, 1.0).astype(np.float32)
    return state
