"""Cyclists and deer: rounded limbs on thin wheels or legs."""

from itertools import pairwise
from math import cos, pi, sin

import numpy as np

from vpf_sim.envs.camera.scenery.cars import PAINTS, RUBBER, shade
from vpf_sim.envs.camera.scenery.mesh import Colour, Mesh, MeshBuilder
from vpf_sim.envs.camera.scenery.people import HAIR, SKINS, TROUSERS, limb

HELMETS: tuple[Colour, ...] = ((236, 236, 232), (30, 31, 34), (200, 40, 36))
COATS: tuple[Colour, ...] = ((134, 98, 66), (116, 88, 64), (150, 112, 74))
RUMP: Colour = (222, 210, 190)
HOOF: Colour = (44, 36, 30)
WHEEL_M, TYRE_M, SPOKES = 0.34, 0.035, 12  # radius of a wheel and half of its width


def cyclist(length: float, width: float, height: float, rng: np.random.Generator) -> Mesh:
    """A rider on a bicycle that fills its box, leaning forward, one foot down."""
    b = MeshBuilder()
    colours = [kinds[int(rng.integers(len(kinds)))] for kinds in (PAINTS, PAINTS, TROUSERS, SKINS, HELMETS)]
    frame, coat, trousers, skin, helmet = colours
    axle = 0.5 * length - WHEEL_M
    for x in (-axle, axle):
        _wheel(b, x)
        b.next_part()
    seat = (-0.16 * length, 0.57 * height)
    bars = (0.2 * length, 0.6 * height)
    for low, high in (((-axle, WHEEL_M), seat), ((axle, WHEEL_M), bars), (seat, bars), ((0.0, WHEEL_M), seat)):
        _tube(b, (low[0], 0.0, low[1]), (high[0], 0.0, high[1]), 0.03, frame)
    b.next_part()
    for side in (-1.0, 1.0):
        knee = (0.12 * length, side * 0.2 * width, (0.5 if side > 0 else 0.38) * height)
        foot = (0.02 * length, side * 0.18 * width, (0.3 if side > 0 else 0.12) * height)
        _tube(b, (seat[0], side * 0.15 * width, seat[1]), knee, 0.08, trousers)
        _tube(b, foot, knee, 0.06, trousers)
        b.next_part()
    neck = (0.08 * length, 0.83 * height)
    rings = [
        (seat[1], seat[0], 0.0, 0.13, 0.3 * width),
        (0.5 * (seat[1] + neck[1]), 0.5 * (seat[0] + neck[0]), 0.0, 0.14, 0.33 * width),
        (neck[1], neck[0], 0.0, 0.1, 0.3 * width),
    ]
    limb(b, rings, coat)
    for side in (-1.0, 1.0):
        b.next_part()
        _tube(b, (bars[0], side * 0.4 * width, bars[1]), (neck[0], side * 0.33 * width, neck[1]), 0.05, coat)
    b.next_part()
    head = neck[0] + 0.05
    limb(b, [(0.83 * height, neck[0], 0.0, 0.06, 0.06), (0.93 * height, head, 0.0, 0.1, 0.085)], skin)
    limb(
        b,
        [(0.92 * height, head, 0.0, 0.12, 0.1), (0.97 * height, head, 0.0, 0.1, 0.085), (height, head, 0, 0.03, 0.03)],
        helmet,
    )
    return b.build()


def deer(length: float, width: float, height: float, rng: np.random.Generator) -> Mesh:
    """A roe deer that fills its box, in a trot."""
    b = MeshBuilder()
    coat = COATS[int(rng.integers(len(COATS)))]
    belly, back, chest, rump = 0.45 * height, 0.72 * height, 0.28 * length, -0.4 * length
    stride = float(rng.uniform(0.05, 0.14)) * length
    for number, (x, side) in enumerate(((rump, -1.0), (rump, 1.0), (chest, -1.0), (chest, 1.0))):
        foot = x + (stride if number in (0, 3) else -stride)
        y = side * 0.24 * width
        _tube(b, (foot, y, 0.06), (x, y, belly + 0.05), 0.04, shade(coat, 0.8))
        _tube(b, (foot, y, 0.0), (foot, y, 0.06), 0.04, HOOF)
        b.next_part()
    middle = 0.5 * (belly + back)
    tall, wide = 0.5 * (back - belly), 0.36 * width
    _trunk(
        b,
        [(rump - 0.09 * length, 0.4), (rump, 0.9), (0.0, 1.0), (chest, 1.0), (chest + 0.06 * length, 0.6)],
        middle,
        tall,
        wide,
        coat,
    )
    _tube(b, (rump - 0.09 * length, 0.0, middle), (rump - 0.06 * length, 0.0, back - 0.03), 0.08, RUMP)
    b.next_part()
    head = (0.42 * length, 0.0, 0.86 * height)
    _tube(b, (chest, 0.0, middle + 0.04), head, 0.085, coat)
    _tube(b, (0.5 * length, 0.0, 0.8 * height), head, 0.06, shade(coat, 0.9))
    for side in (-1.0, 1.0):
        _tube(b, (0.4 * length, side * 0.04, 0.88 * height), (0.36 * length, side * 0.4 * width, height), 0.03, HAIR)
    return b.build()


def _wheel(b: MeshBuilder, x: float) -> None:
    """An upright wheel along x: a thin ring of both sides and the tread."""
    for i in range(SPOKES):
        a0, a1 = 2.0 * pi * i / SPOKES, 2.0 * pi * (i + 1) / SPOKES
        for inner, outer, y in ((0.84, 1.0, TYRE_M), (0.84, 1.0, -TYRE_M)):
            points = [(share * WHEEL_M, angle) for share, angle in ((inner, a0), (inner, a1), (outer, a1), (outer, a0))]
            quad = [(x + r * cos(angle), y, WHEEL_M + r * sin(angle)) for r, angle in points]
            b.whole(quad if y < 0.0 else quad[::-1], RUBBER)
        quad = [
            (x + WHEEL_M * cos(angle), y, WHEEL_M + WHEEL_M * sin(angle))
            for angle, y in ((a0, -TYRE_M), (a0, TYRE_M), (a1, TYRE_M), (a1, -TYRE_M))
        ]
        b.whole(quad, RUBBER)


def _tube(
    b: MeshBuilder, low: tuple[float, float, float], high: tuple[float, float, float], radius: float, colour: Colour
) -> None:
    """A round bar between two points; the rings are level, so it must not be."""
    if low[2] > high[2]:
        low, high = high, low
    top = max(high[2], low[2] + 0.01)
    limb(b, [(low[2], low[0], low[1], radius, radius), (top, high[0], high[1], radius, radius)], colour)


def _trunk(
    b: MeshBuilder, rings: list[tuple[float, float]], middle: float, tall: float, wide: float, colour: Colour
) -> None:
    """A lying body along x through upright ellipses (x, share of the full size)."""
    sides = 10
    for (x0, s0), (x1, s1) in pairwise(rings):
        for i in range(sides):
            a0, a1 = 2.0 * pi * i / sides, 2.0 * pi * (i + 1) / sides
            corners = ((x0, s0, a1), (x0, s0, a0), (x1, s1, a0), (x1, s1, a1))
            b.whole([(x, s * wide * cos(a), middle + s * tall * sin(a)) for x, s, a in corners], colour)
