"""A windscreen in front of the default camera, and its geometry derived anew."""

from math import radians, sin, tan

import numpy as np

from vpf_sim.envs.camera import weather
from vpf_sim.envs.camera.glass import Drop, Glass
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.snapshot import Snapshot
from vpf_sim.envs.camera.view import View
from vpf_sim.types import Camera, Floats, Image

CAMERA = Camera()
SPEED_MPS, RATE_HZ = 5.5, 60.0
NO_RAIN = 0.01  # droplets: next to none
RAKE_RAD, DISTANCE_M = radians(55.0), 0.1
PIVOT_M = np.array([-0.45, 0.62])
BLADE_M = (0.25, 0.84)


def glass(name: str = "HardRainNoon", seed: int = 0, camera: Camera = CAMERA, **factors: float) -> Glass:
    chosen = weather.load(name).model_copy(update=factors)
    return Glass(camera, chosen, Light.of(chosen), seed)


def snapshot(time_s: float, camera: Camera = CAMERA, speed_mps: float = SPEED_MPS) -> Snapshot:
    return Snapshot(View.at(camera, np.array([speed_mps * time_s, 0.0]), 0.0), time_s, [], {})


def go(
    water: Glass, until_s: float, speed_mps: float = SPEED_MPS, camera: Camera = CAMERA, gap_s: float = 0.05
) -> None:
    """Go to a time from a moment before."""
    water.skip(snapshot(until_s, camera, speed_mps), snapshot(until_s - gap_s, camera, speed_mps))


def draw(water: Glass, frame: Image, k: int, camera: Camera = CAMERA) -> Image:
    """Frame k of a drive."""
    drawn = frame.copy()
    water.draw(drawn, snapshot(k / RATE_HZ, camera), snapshot((k - 1) / RATE_HZ, camera))
    return drawn


def with_drops(*drops: Drop, wiper_period_s: float = 0.0) -> Glass:
    """A windscreen with these drops at the time 0, almost without rain."""
    water = glass(droplets=NO_RAIN, wiper_period_s=wiper_period_s)
    go(water, 0.0)
    for drop in drops:
        water.put(drop)
    return water


def depth_m(y_px: Floats) -> Floats:
    """Of the glass along the optical axis: the ray y / z = t meets it at z0 / (1 - t cot r)."""
    t = (np.asarray(y_px) - CAMERA.cy_px) / CAMERA.fy_px
    return DISTANCE_M / (1.0 - t / tan(RAKE_RAD))


def px_per_mm(y_px: float) -> float:
    """Along a row."""
    return 1e-3 * CAMERA.fx_px / float(depth_m(np.array(y_px)))


def area_m2() -> Floats:
    """(H,) of the glass by image row: a pixel at depth z sees z^3 / (f^2 z0 sin r)."""
    z = depth_m(np.arange(CAMERA.height_px))
    return np.asarray(CAMERA.width_px * z**3 / (CAMERA.fx_px * CAMERA.fy_px * DISTANCE_M * sin(RAKE_RAD)))


def polar(x_px: Floats, y_px: Floats) -> tuple[Floats, Floats]:
    """Distance from the wiper's pivot, m, and the blade's angle, rad, at pixels."""
    z = depth_m(y_px)
    u = (x_px - CAMERA.cx_px) / CAMERA.fx_px * z - PIVOT_M[0]
    up = PIVOT_M[1] - (y_px - CAMERA.cy_px) / CAMERA.fy_px * z / sin(RAKE_RAD)
    return np.hypot(u, up), np.arctan2(up, u)
