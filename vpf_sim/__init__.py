"""Closed-loop harness for vision-based driving: camera frames in, throttle and steering out."""

from typing import Any

from gymnasium.envs.registration import register

__version__ = "0.1.0"
__all__ = ["CameraObservation", "__version__"]

register(id="vpf_sim/FourLane-v0", entry_point="vpf_sim.envs.four_lane:FourLane")


def __getattr__(name: str) -> Any:
    """Load the camera wrapper, and with it highway-env and OpenCV, only when it is asked for."""
    if name == "CameraObservation":
        from vpf_sim.envs.observation import CameraObservation

        return CameraObservation
    raise AttributeError(f"module 'vpf_sim' has no attribute '{name}'")
