"""Lamps of other vehicles and street lamps, as they shine into the camera."""

from dataclasses import dataclass
from math import cos, hypot, sin

import numpy as np

from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.night.glow import Lamp, flux_px
from vpf_sim.envs.camera.night.lamplight import STREET_CD
from vpf_sim.envs.camera.night.low_beam import intensity_cd
from vpf_sim.envs.camera.view import View
from vpf_sim.types import Floats

NEAREST_M, RANGE_M = 1.5, 220.0
TAIL_CD = 8.0  # of a rear position lamp on its axis; UN Regulation 7 asks for 4 to 17
RED, WARM, WHITE = (1.0, 0.07, 0.035), (1.0, 0.78, 0.5), (1.0, 0.92, 0.78)  # linear RGB
TAIL_SIZE_M, HEAD_SIZE_M, STREET_SIZE_M = 0.16, 0.14, 0.3


@dataclass(frozen=True, slots=True)
class Places:
    """Where a kind of vehicle has its lamps: heights, and distances from the middle over the width."""

    tail_m: float
    tail_aside: float
    head_m: float
    head_aside: float


PLACES = {
    "car": Places(0.78, 0.39, 0.65, 0.37),
    "van": Places(0.95, 0.445, 0.85, 0.40),
    "truck": Places(0.75, 0.38, 0.85, 0.40),
}


def vehicle_lamps(view: View, pose: Floats, kind: str, size: tuple[float, float, float], light: Light) -> list[Lamp]:
    """The tail lamps, or the low beams, of a vehicle of `size` (length, width, height) at a pose (x, y, heading)."""
    places = PLACES.get(kind)
    if places is None:
        return []
    x, y, heading = pose.tolist()
    c, s = cos(heading), sin(heading)
    eye_x, eye_y, eye_z = view.centre.tolist()
    behind = c * (eye_x - x) + s * (eye_y - y) < 0.0
    end = -0.5 * size[0] if behind else 0.5 * size[0] - 0.1
    height, aside = (places.tail_m, places.tail_aside) if behind else (places.head_m, places.head_aside)
    found = []
    for right in (-aside * size[1], aside * size[1]):
        place = (x + c * end - s * right, y + s * end + c * right, height)
        ahead = c * (eye_x - place[0]) + s * (eye_y - place[1])
        across = c * (eye_y - place[1]) - s * (eye_x - place[0])
        if behind and ahead < -0.1:
            cd = TAIL_CD * -ahead / hypot(ahead, across)
            found.append(_lamp(view, place, cd, RED, TAIL_SIZE_M, light))
        elif not behind and ahead > 0.1:
            cd = float(intensity_cd(np.array(across / ahead), np.array((eye_z - height) / ahead)))
            found.append(_lamp(view, place, cd, WHITE, HEAD_SIZE_M, light))
    return [one for one in found if one is not None]


def street_lamps(view: View, lamps_m: Floats, light: Light) -> list[Lamp]:
    """The street lamps at world points (n, 3), the farthest first."""
    depths = (lamps_m - view.centre) @ view.axes[2]
    found = []
    for k in np.argsort(-depths, kind="stable").tolist():
        place = tuple(lamps_m[k].tolist())
        apart = hypot(place[0] - view.centre[0], place[1] - view.centre[1])
        drop = place[2] - float(view.centre[2])
        cd = STREET_CD * min(max(4.0 - hypot(apart, drop) / max(drop, 0.1), 0.08), 1.0)
        found.append(_lamp(view, place, cd, WARM, STREET_SIZE_M, light))
    return [one for one in found if one is not None]


def _lamp(
    view: View, place: tuple[float, ...], cd: float, colour: tuple[float, float, float], size_m: float, light: Light
) -> Lamp | None:
    """A lamp of `cd` towards the camera at a world point; None if it does not show."""
    point = view.camera_axes(np.array(place))
    depth = float(point[2])
    distance = float(np.linalg.norm(point))
    if not NEAREST_M < depth < RANGE_M:
        return None
    x, y = view.pixels(point).tolist()
    flux = flux_px(view.camera, cd / distance**2, light.white_lx)
    return Lamp(x, y, depth, flux, colour, view.camera.fx_px * size_m / depth)
