"""Colour ramps for other verges and road surfaces, and for worn paint."""

import numpy as np

from vpf_sim.envs.camera.ground.paint import LINE
from vpf_sim.envs.camera.ground.palette import RAMP
from vpf_sim.scenarios.parts import RoadAppearance
from vpf_sim.types import Floats

# Colours at noon, RGB, at the ramp's values: the verge from dark to bright and the gravel, then the road.
VERGE_VALUES, ROAD_VALUES, PAINT_FROM = (0, 25, 45, 60, 80, 98, 124), (138, 150), 200
VERGES: dict[str, list[tuple[int, int, int]]] = {
    "sand": [
        (118, 98, 70),
        (146, 124, 90),
        (178, 154, 114),
        (198, 176, 136),
        (188, 168, 132),
        (160, 146, 122),
        (112, 108, 102),
    ],
    "snow": [
        (168, 173, 182),
        (200, 204, 211),
        (224, 227, 232),
        (236, 238, 241),
        (220, 222, 226),
        (186, 188, 191),
        (128, 129, 131),
    ],
    "paved": [
        (84, 83, 82),
        (98, 97, 95),
        (108, 107, 105),
        (118, 117, 114),
        (114, 113, 110),
        (108, 107, 105),
        (102, 101, 99),
    ],
}
SURFACES = {"concrete": [(146, 144, 137), (162, 160, 152)], "dark": [(44, 45, 48), (56, 57, 60)]}
YELLOW = np.array([1.0, 0.82, 0.32])  # of white paint
WORN = 0.6  # loss of contrast of worn paint


def ramp(look: RoadAppearance) -> Floats:
    """(n, 4) value, red, green, blue; `palette.RAMP` is grass and asphalt with fresh paint."""
    found = RAMP.copy()
    for values, colours in ((VERGE_VALUES, VERGES.get(look.verge)), (ROAD_VALUES, SURFACES.get(look.surface))):
        if colours is not None:
            found[np.isin(found[:, 0], values), 1:] = colours
    if look.lines == "yellow":
        found[found[:, 0] >= LINE, 1:] *= YELLOW
    if look.worn:
        paint, road = found[:, 0] >= PAINT_FROM, found[found[:, 0] == ROAD_VALUES[-1], 1:]
        found[paint, 1:] += WORN * (road - found[paint, 1:])
    return found
