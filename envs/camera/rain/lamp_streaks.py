"""Lamps mirrored in a wet road: bright streaks towards the camera."""

import numpy as np

from vpf_sim.envs.camera.light import GAMMA
from vpf_sim.envs.camera.night.glow import Glow, Lamp
from vpf_sim.envs.camera.rain.mirror import REFINEMENT
from vpf_sim.envs.camera.truth import Drawn
from vpf_sim.geometry import road_row_px
from vpf_sim.types import Camera, Floats, Image

NARROW_PX = 0.9  # least standard deviation across, canvas pixels
ACROSS, ALONG = 3.0, 9.0  # extents that are drawn, in standard deviations across and smears along


def lamp_streaks(camera: Camera, drawn: list[Drawn], share: Image, top: int, smear_px: float) -> Image | None:
    """(rows, columns, 3) light of the lamps among `drawn` on the canvas of a wet road, None without any.

    A lamp's mirror image is as far below the road as the lamp is above. Tilted facets spread its light by `smear_px`
    rows, with long tails, and hardly across. Light adds up before the gamma: 255 (share x flux x spread)^(1 / 2.2),
    with the reflected `share` (rows, columns) of 255 and the flux in pixels of full brightness.
    """
    lamps = [item.drawing.lamp for item in drawn if isinstance(item.drawing, Glow)]
    if not lamps:
        return None
    light = np.zeros((*share.shape, 3), np.float32)
    for lamp in lamps:
        _add(light, camera, lamp, top, smear_px)
    light *= share[..., None] * np.float32(1.0 / 255.0)
    np.minimum(light, np.float32(1.0), out=light)
    return np.asarray(255.0 * light ** np.float32(1.0 / GAMMA), np.uint8)


def _add(light: Floats, camera: Camera, lamp: Lamp, top: int, smear_px: float) -> None:
    """Add one lamp's streak, in place."""
    foot = road_row_px(camera, lamp.depth_m)
    x, y = lamp.x_px / REFINEMENT, (2.0 * foot - lamp.y_px - top) / REFINEMENT
    wide = NARROW_PX + 0.25 * lamp.size_px / REFINEMENT
    x0, x1 = (int(np.clip(x + side * ACROSS * wide, 0, light.shape[1])) for side in (-1.0, 1.0))
    y0, y1 = (int(np.clip(y + side * ALONG * smear_px, 0, light.shape[0])) for side in (-1.0, 1.0))
    if x0 >= x1 or y0 >= y1:
        return
    across = np.exp(-0.5 * ((np.arange(x0, x1) - x) / wide) ** 2)
    rows = (np.arange(y0, y1) - y) / smear_px
    along = (1.0 + rows**2) ** -2.0 * np.maximum(1.0 - (rows / ALONG) ** 2, 0.0)  # few facets are steep
    flux = lamp.flux / (np.sqrt(2.0 * np.pi) * wide * 0.5 * np.pi * smear_px * REFINEMENT**2)
    light[y0:y1, x0:x1] += (flux * along[:, None] * across)[..., None].astype(np.float32) * np.array(
        lamp.colour, np.float32
    )
