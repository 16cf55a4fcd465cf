"""The obstacles' repulsion from the image (paper, section IV-B).

    F_rep = (F_x, F_y) = gamma / |R| (integral over A of g dx, sum over A of TTC_i),    g = grad (G * O_t)

A is the region of interest that the obstacle map keeps points of (`vpf_sim.perception.paper.obstacle_region`); the
printed "A as in eq. (A)" points at the matrix of the least squares. G spreads beyond A, so the integral
goes over the frame. g points TO the obstacle, so that F_T = F_att - F_rep leads away from it.
"""

from typing import Literal

import numpy as np

from vpf_sim.configuration import setting, settings
from vpf_sim.types import Camera, Floats, ObstacleMap

NEVER_S = 1e9  # longest time to contact, so that the sum stays finite


@settings
class ObstacleFieldConfig:
    """F_y grows with safety and always has one sign, so it can be left out."""

    gamma: float = setting("Weight gamma of the obstacle field.", ge=0.0)
    terms: Literal["printed", "lateral"] = setting(
        "Terms of the field: `printed`, F_x and F_y, or `lateral`, F_x alone."
    )
    area: Literal["frame", "obstacles"] = setting(
        "Area |R| of the field: the pixels of the `frame`, or those of the `obstacles`."
    )


def force(obstacle_map: ObstacleMap, ttc_s: Floats, camera: Camera, config: ObstacleFieldConfig) -> Floats:
    """(2,) (F_x, F_y) in image axes, x right. TTC in s of each point, (N,); points without one do not count.

    The mean of a derivative over the frame is the difference of G * O between its right and left edge, divided by
    its width: zero for an obstacle in the middle, growing towards the side.
    """
    pixels = float(camera.width_px * camera.height_px)
    lateral = config.gamma * float(obstacle_map.gradient[0].mean())
    if config.area == "obstacles":
        share = float(obstacle_map.plane.mean())
        if share == 0.0:
            return np.zeros(2)
        lateral, pixels = lateral / share, pixels * share
    if config.terms == "lateral":
        return np.array([lateral, 0.0])
    known = np.clip(ttc_s[np.isfinite(ttc_s)], -NEVER_S, NEVER_S)
    return np.array([lateral, config.gamma * float(known.sum()) / pixels])
