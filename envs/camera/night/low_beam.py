"""Luminous intensity of one low beam (dipped headlamp) for traffic on the right."""

import numpy as np

from vpf_sim.types import Floats

PEAK_CD = 16_000.0
ABOVE_CD = 220.0  # stray light, also above the cut-off: on signs and into the eyes of others
ABOVE_WIDE, ABOVE_TALL = 0.9, 0.5  # its extents
DIP = 0.010  # slope of the cut-off: 1 % down
RISE, HIGHEST = 0.268, 0.012  # the cut-off rises at 15 deg on the right, up to this slope
SOFT, OFFSET = 0.0012, 0.0015  # half width of the cut-off, and the middle of its edge below it
NARROW, WIDE = (0.5, 0.13), (0.5, 0.6)  # share and width of the bright centre, and of the wide light, across
STEEP, SHALLOW = (0.85, 0.035), (0.15, 0.22)  # share and depth of both, below the cut-off


def intensity_cd(across: Floats, up: Floats) -> Floats:
    """cd towards directions with the slopes `across` (right over ahead) and `up` (up over ahead); ahead only.

    A bright centre below the cut-off and a wide, shallow light. The parameters meet the limits of UN Regulation 112,
    class B (01 series, paragraph 6.2.4), at each of its test points.
    """
    below = np.minimum(RISE * np.maximum(across, 0.0) - DIP, HIGHEST) - up
    cut = 1.0 / (1.0 + np.exp(np.clip((OFFSET - below) / SOFT, -60.0, 60.0)))
    depth = np.maximum(below, 0.0)
    wide = sum(share * np.exp(-((across / width) ** 2)) for share, width in (NARROW, WIDE))
    deep = sum(share * np.exp(-depth / scale) for share, scale in (STEEP, SHALLOW))
    stray = ABOVE_CD * np.exp(-((across / ABOVE_WIDE) ** 2) - (np.maximum(up, 0.0) / ABOVE_TALL) ** 2)
    return np.asarray(stray + PEAK_CD * cut * wide * deep)
