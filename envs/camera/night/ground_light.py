"""The light of lamps on the road, for each pixel below the horizon."""

import numpy as np

from vpf_sim.envs.camera.light import GAMMA
from vpf_sim.envs.camera.view import View
from vpf_sim.types import Floats

COLUMN_PX = 8  # the light is smooth across: worked out for every eighth column
FARTHEST_M = 260.0
LARGEST = 2.0  # factor that 255 stands for
# Luminance of dry asphalt towards the driver: 15 mcd/m2 for each lx of his headlamps at 30 m (EN 1436, class RW1 of
# paint has 150), 70 mcd/m2 for each lx from above (CIE 144, road class R3).
ASPHALT = 0.015 / 0.07
PAINT = 0.15 / 0.25  # the same for dry white paint
BRIGHTEST = (PAINT / ASPHALT) ** (1.0 / GAMMA)  # gain of paint over asphalt in the beam, compared with the day


def ground_points(view: View, columns: Floats, rows: Floats) -> Floats:
    """(rows, columns, 3) m, world points of the ground at pixels."""
    x, y = np.meshgrid(columns, rows)
    points = np.stack([x, y, np.ones_like(x)], axis=-1) @ view.ground_homography().T
    points[..., :2] /= points[..., 2:]
    points[..., 2] = 0.0
    return np.asarray(points)


def paint_efficiency(wetness: float, beam_share: float) -> Floats:
    """(256,) brightness of the palette's values in the light of lamps, over that by day; 1 on dry paint in the beam.

    Paint returns light to the driver: 150 mcd/m2 for each lx (RW1), of white that returns 250 by day; 35 in the wet
    (EN 1436, class RW1). Grass stands upright in the beam and returns half of what it does by day. `beam_share` is the
    lamps' share of the light.
    """
    paint = PAINT / ASPHALT * (1.0 + (0.035 / 0.15 - 1.0) * wetness)
    grass = 0.5 / ASPHALT
    values = np.interp(np.arange(256), (0, 80, 112, 175, 222), (grass, grass, 1.0, 1.0, paint))
    return np.asarray((1.0 + (values - 1.0) * beam_share) ** (1.0 / GAMMA) / BRIGHTEST)
