"""A frame in which what stands on a road stands out from it.

Asphalt is grey, wet or dry, and so is the sky that it mirrors: most of what is bright or dark on it in rain has no
colour. Wood, rust and warning colours have: they are redder than they are blue.
"""

import cv2
import numpy as np

from vpf_sim.types import Image


def contrast(image_rgb: Image, luma: Image) -> Image:
    """(H, W) uint8 of an (H, W, 3) RGB image and its luma (H, W): luma + R - B, so that grey stays as it is."""
    red, _, blue = cv2.split(image_rgb)
    warm = cv2.add(luma, cv2.subtract(red, blue))  # saturated differences: one of the two is 0 in each pixel
    return cv2.subtract(warm, cv2.subtract(blue, red)).astype(np.uint8, copy=False)
