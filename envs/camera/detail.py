"""Level of detail: the smaller the camera's image, the nearer and the more rarely its details are worked out."""

from vpf_sim.types import Camera

FULL_PX = 320.0  # focal length for which the distances of details are given: 640 px over 90 deg


def detail(camera: Camera) -> float:
    """The share of those distances at which this camera shows as much, at most 1."""
    return min(1.0, camera.fx_px / FULL_PX)
