"""Ranges of hills at the horizon as a panorama."""

from math import floor, log2

import cv2
import numpy as np

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.sky.sky_dome import ZENITH_SLOPE
from vpf_sim.envs.camera.texture import noise
from vpf_sim.types import Floats, Image

COLUMNS, ROWS_PER_SLOPE = 2560, 400  # columns at full detail
HILLS = (  # (distance in m, tangent of the height, RGB), from far to near; the nearest is a line of trees
    (5500.0, 0.060, (58, 82, 96)),
    (2600.0, 0.036, (62, 84, 70)),
    (950.0, 0.021, (46, 66, 36)),
)
VALLEY_HAZE = 0.25  # extra extinction at the foot of a hill
LEAST_SHOWN = 0.012  # least contrast of the nearest hills, about a grey level


def hills_show(atmosphere: Atmosphere) -> bool:
    """Whether any hills are visible through the haze."""
    return bool(np.exp(-atmosphere.extinction_per_m * HILLS[-1][0]) > LEAST_SHOWN)


def outlines(rng: np.random.Generator, share: float) -> Floats:
    """(ranges, columns) tangents of the elevation of the tops, for a share of the full detail."""
    averaged = 2 ** floor(log2(1.0 / share))
    trees = len(HILLS) - 1
    fields = [noise((1, COLUMNS), rng, *((3.0, 0.9) if i == trees else (8.0, 1.4)))[0] for i in range(trees + 1)]
    heights = np.array([[height] for _, height, _ in HILLS])
    tops = heights * np.clip(0.62 + 0.30 * np.array(fields), 0.12, 1.4)
    return np.asarray(tops.reshape(len(HILLS), -1, averaged).mean(axis=2))


def hills(
    sky: Image, tops: Floats, tall: float, light: Light, atmosphere: Atmosphere, rng: np.random.Generator
) -> Image:
    """(rows, columns, 3) RGB panorama of hazy hills before the sky.

    Column i is the azimuth 2 pi i / columns; rows are linear in the tangent of the elevation, from `tall` down to 0.
    """
    columns = tops.shape[1]
    rows = int(tall * ROWS_PER_SLOPE)
    slope = np.linspace(tall, 0.0, rows)[:, None]
    picture = _magnified(sky, slope[:, 0], columns)
    airlight = picture[-1]
    for (distance_m, _, colour), top in zip(HILLS, tops, strict=True):
        texture = noise((rows, columns), rng, 3.5, 0.8)[..., None] * 13.0
        first = int(np.argmax(slope[:, 0] < top.max()))  # the rows above show nothing of this range
        below, part = slope[first:], picture[first:]
        up = np.clip(below / top, 0.0, 1.0)
        transmission = np.exp(-atmosphere.extinction_per_m * distance_m * (1.0 + VALLEY_HAZE * (1.0 - up)))[..., None]
        cover = np.clip((top - below) / (tall / rows), 0.0, 1.0)[..., None]
        tone = (np.array(colour, float) + texture[first:]) * light.ground
        part += cover * (airlight + (tone - airlight) * transmission - part)
    if columns < COLUMNS:
        picture = np.asarray(cv2.blur(picture, (1, 2 * COLUMNS // columns + 1)))  # a pixel is taller than a row
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def _magnified(sky: Image, slope: Floats, width: int) -> Floats:
    """(rows, width, 3) the sky at tangents of the elevation."""
    turn = np.concatenate([sky, sky[:, :1]], axis=1)
    columns = np.arange(width, dtype=np.float32) * np.float32(sky.shape[1] / width)
    rows = ((len(sky) - 1) * (1.0 - slope / ZENITH_SLOPE)).astype(np.float32)
    across, down = (np.ascontiguousarray(of) for of in np.broadcast_arrays(columns, rows[:, None]))
    return np.asarray(cv2.remap(turn, across, down, cv2.INTER_LINEAR), np.float64)
