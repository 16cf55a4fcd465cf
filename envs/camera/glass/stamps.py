"""The image of one drop: its opacity and the part of the scene that it shows.

A drop on the glass is far out of focus. A spot of width w px with a blur disc of b px is constant over |w - b| and
fades out at w + b; a spot smaller than the pupil covers only (w / b)^2 of the light. A drop is a lens of a few mm focal
length: it shows the whole scene small and upside down, with a darker rim.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from vpf_sim.types import Image

VARIANTS = 4  # outline shapes of larger drops
SHADES = (1.0, 0.9, 0.78, 0.64)  # brightness from a drop's centre to its rim
REACH = 0.85  # share of the scene shown to either side of its middle
RIM_FROM = 0.4  # radius from which shading starts, of the drop's


@dataclass(frozen=True, slots=True)
class Stamp:
    """One drop on the planes."""

    alpha: Image  # (h, w) opacity, 0..255
    source: NDArray[np.int32]  # (h, w) shown pixel of the small images, relative to the anchor


@lru_cache(maxsize=4096)
def stamp(size: tuple[int, int], blur: tuple[int, int], variant: int, scene: tuple[int, int], stride: int) -> Stamp:
    """The stamp of a spot of `size` (width, height) with the blur disc `blur`, in 1/8 px of the planes.

    `scene` is the (height, width) of the small image. Images of all `SHADES` are stacked in rows of `stride` pixels.

    """
    (w, h), (bx, by) = (tuple(extent / 8.0 for extent in pair) for pair in (size, blur))
    rx, ry = int(np.ceil((w + bx) / 2)), int(np.ceil((h + by) / 2))
    u = 2.0 * np.arange(-rx, rx + 1.0) / (w + bx)
    v = 2.0 * np.arange(-ry, ry + 1.0)[:, None] / (h + by)
    thick = w > 2.0 * bx
    outer = np.hypot(u, v) / (_outline(u, v, variant) if thick else 1.0)
    level = (abs(w - bx) + abs(h - by)) / (w + h + bx + by)
    cover = min(1.0, w / bx) * min(1.0, h / by) * np.clip((1.0 - outer) / (1.0 - level), 0.0, 1.0)
    shade = np.clip((outer - RIM_FROM) / (1.0 - RIM_FROM), 0.0, 0.999) * len(SHADES) // 1 if thick else 0.0
    shown_x = -np.clip(u, -1.0, 1.0) * REACH * (scene[1] / 2 - 1)
    shown_y = -np.clip(v, -1.0, 1.0) * REACH * (scene[0] / 2 - 1) + shade * scene[0]
    source = np.broadcast_to(np.rint(shown_x) + stride * np.rint(shown_y), outer.shape)
    return Stamp(np.rint(255.0 * cover).astype(np.uint8), source.astype(np.int32))


def _outline(x: NDArray[np.float64], y: NDArray[np.float64], variant: int) -> NDArray[np.float64]:
    """Outline radius in the direction of each pixel, 0.8 to 1."""
    angle = np.arctan2(y, x)
    turn = 1.7 * variant
    outline: NDArray[np.float64] = 0.9 + 0.06 * np.cos(2.0 * angle + turn) + 0.04 * np.cos(3.0 * angle - 2.3 * turn)
    return outline
