"""What a drop on the glass does to the picture: how much of it it covers, and which part of the scene it shows.

A drop on the glass is far out of focus. The image of a spot of width w px, spread over the lens's disc of b px, is
level over |w - b| and fades out at w + b; where the spot is smaller than the lens's pupil it covers only (w / b)^2 of
the light. A cap of water is a lens of a few mm focal length: it shows the whole scene small, upside down and left for
right; its rim, where the light comes in from far off the scene, is darker.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from vpf_sim.types import Image

VARIANTS = 4  # outlines of larger drops
FILM, BODY, RIM = 0, 1, 2  # the pictures that `source` looks into, one above the other
REACH = 0.65  # share of the scene to either side of its middle that one drop shows
RIM_FROM = 0.72  # of the radius


@dataclass(frozen=True, slots=True)
class Stamp:
    """One drop on the half-size planes."""

    alpha: Image  # (h, w) 0..255, what it covers
    source: NDArray[np.int16]  # (h, w, 2) x, y where in the small picture of the scene it looks, from its anchor


@lru_cache(maxsize=4096)
def stamp(width: int, height: int, blur: int, variant: int, scene: tuple[int, int]) -> Stamp:
    """The stamp of a spot of `width` x `height` with a disc of `blur`, all in 1/8 px of the planes; `scene` is the
    (height, width) of the small picture."""
    w, h, b = width / 8.0, height / 8.0, blur / 8.0
    rx, ry = int(np.ceil((w + b) / 2)), int(np.ceil((h + b) / 2))
    y, x = np.mgrid[-ry : ry + 1, -rx : rx + 1].astype(float)
    rough = _outline(x / (w + b), y / (h + b), variant) if w > 2.0 * b else 1.0
    outer = np.hypot(2.0 * x / (w + b), 2.0 * y / (h + b)) / rough
    level = (abs(w - b) + abs(h - b)) / (w + h + 2.0 * b)
    cover = min(1.0, w / b) * min(1.0, h / b) * np.clip((1.0 - outer) / (1.0 - level), 0.0, 1.0)
    rim = (outer > RIM_FROM) & (w > 2.0 * b)
    bank = np.where(rim, RIM, BODY) * scene[0]
    u, v = (np.clip(2.0 * offset / size, -1.0, 1.0) for offset, size in ((x, w + b), (y, h + b)))
    source = np.stack([-u * REACH * (scene[1] / 2 - 1), -v * REACH * (scene[0] / 2 - 1) + bank], axis=-1)
    return Stamp(np.rint(255.0 * cover).astype(np.uint8), np.rint(source).astype(np.int16))


def _outline(x: NDArray[np.float64], y: NDArray[np.float64], variant: int) -> NDArray[np.float64]:
    """Radius of the outline in the direction of each pixel, 0.8 to 1."""
    angle = np.arctan2(y, x)
    turn = 1.7 * variant
    outline: NDArray[np.float64] = 0.9 + 0.06 * np.cos(2.0 * angle + turn) + 0.04 * np.cos(3.0 * angle - 2.3 * turn)
    return outline
