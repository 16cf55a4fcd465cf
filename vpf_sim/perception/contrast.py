"""An image with high contrast between obstacles and road.

Asphalt and the sky that it mirrors are grey. Wood, rust and warning colours are redder than blue.
"""

import cv2
import numpy as np

from vpf_sim.types import Image


def contrast(image_rgb: Image, luma: Image) -> Image:
    """(H, W) uint8 of an (H, W, 3) RGB image and its luma (H, W): luma + R - B, so that grey stays as it is."""
    red, _, blue = cv2.split(image_rgb)
    warm = cv2.add(luma, cv2.subtract(red, blue))  # saturated differences: one of the two is 0 in each pixel
    return cv2.subtract(warm, cv2.subtract(blue, red)).astype(np.uint8, copy=False)
