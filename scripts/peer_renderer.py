"""Frames a second of a software renderer on a road like ours, as a yardstick: pybullet's TinyRenderer.

    pip install pybullet
    python scripts/peer_renderer.py [--sizes 84x84 640x480] [--seconds 4]

The scene is plain: a grey road on a green plane, 12 cars of a body and a cabin, 24 lane stripes and 30 trees of a trunk
and a crown, with shadows off. It has no texture, haze, sky or rain, which our frames have. The camera drives on between
frames, one thread.
"""

import argparse
import os
from math import atan, degrees, radians, tan
from time import perf_counter

import pybullet

CARS, STRIPES, TREES = 12, 24, 30
FAR_M, NEAR_M, HEIGHT_M, FOV_DEG = 260.0, 0.3, 1.4, 90.0
SPEED_MPS, RATE_HZ = 5.55, 20.0


def box(half: tuple[float, float, float], place: tuple[float, float, float], colour: tuple[float, ...]) -> None:
    """A box with half extents at the place of its centre."""
    shape = pybullet.createVisualShape(pybullet.GEOM_BOX, halfExtents=half, rgbaColor=colour)
    pybullet.createMultiBody(baseVisualShapeIndex=shape, basePosition=place)


def build() -> None:
    """The scene along x."""
    box((300.0, 100.0, 0.01), (250.0, 0.0, -0.02), (0.35, 0.45, 0.2, 1.0))
    box((300.0, 7.0, 0.01), (250.0, 0.0, 0.0), (0.4, 0.4, 0.4, 1.0))
    for number in range(STRIPES):
        box((1.5, 0.08, 0.005), (9.0 * (number // 2) + 5.0, -1.75 + 3.5 * (number % 2), 0.02), (0.9, 0.9, 0.9, 1.0))
    for number in range(CARS):
        x, y = 15.0 + 14.0 * number, (-5.25, -1.75, 1.75, 5.25)[number % 4]
        box((2.2, 0.9, 0.35), (x, y, 0.6), (0.2, 0.2, 0.6, 1.0))
        box((1.2, 0.8, 0.3), (x, y, 1.2), (0.1, 0.1, 0.12, 1.0))
    trunk = pybullet.createVisualShape(pybullet.GEOM_CYLINDER, radius=0.2, length=4.0, rgbaColor=(0.3, 0.25, 0.2, 1.0))
    crown = pybullet.createVisualShape(pybullet.GEOM_SPHERE, radius=2.5, rgbaColor=(0.25, 0.4, 0.15, 1.0))
    for number in range(TREES):
        x, y = 10.0 + 7.0 * number, (-14.0, 15.0, -22.0)[number % 3]
        pybullet.createMultiBody(baseVisualShapeIndex=trunk, basePosition=(x, y, 2.0))
        pybullet.createMultiBody(baseVisualShapeIndex=crown, basePosition=(x, y, 5.5))


def rate(width: int, height: int, seconds: float) -> float:
    """Frames a second."""
    fov_down_deg = 2.0 * degrees(atan(tan(0.5 * radians(FOV_DEG)) * height / width))
    lens = pybullet.computeProjectionMatrixFOV(fov_down_deg, width / height, NEAR_M, FAR_M)
    frames, x, started_s = 0, 0.0, perf_counter()
    while perf_counter() - started_s < seconds:
        view = pybullet.computeViewMatrix((x, -1.75, HEIGHT_M), (x + 10.0, -1.75, HEIGHT_M), (0.0, 0.0, 1.0))
        pybullet.getCameraImage(width, height, view, lens, shadow=0, renderer=pybullet.ER_TINY_RENDERER)
        frames, x = frames + 1, (x + SPEED_MPS / RATE_HZ) % 60.0
    return frames / (perf_counter() - started_s)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", nargs="+", default=["84x84", "160x120", "640x480"])
    parser.add_argument("--seconds", type=float, default=4.0)
    asked = parser.parse_args()
    pybullet.connect(pybullet.DIRECT)
    build()
    for size in asked.sizes:
        width, height = (int(part) for part in size.split("x"))
        print(f"{size}: {rate(width, height, asked.seconds):.0f} frames a second", flush=True)
    print(f"load average {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
