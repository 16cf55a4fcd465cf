"""Standing pedestrians: rounded limbs, a coat, a head with hair."""

from itertools import pairwise

import numpy as np

from vpf_sim.envs.camera.scenery.cars import PAINTS, shade
from vpf_sim.envs.camera.scenery.mesh import Colour, Mesh, MeshBuilder, Point, box

SIDES = 10
SHOE: Colour = (32, 28, 26)
TROUSERS: tuple[Colour, ...] = ((40, 48, 72), (44, 42, 40), (96, 88, 74), (70, 74, 82))
SKINS: tuple[Colour, ...] = ((214, 168, 140), (150, 104, 78), (96, 66, 50))
HAIR: Colour = (60, 44, 32)
Ring = tuple[float, float, float, float, float]  # height, middle x and y, radii along x and y


def pedestrian(length: float, width: float, height: float, rng: np.random.Generator) -> Mesh:
    """A standing pedestrian that fills its box."""
    b = MeshBuilder()
    coat, trousers, skin = (colours[int(rng.integers(len(colours)))] for colours in (PAINTS, TROUSERS, SKINS))
    hair = shade(HAIR, float(rng.uniform(0.4, 1.6)))
    step = float(rng.uniform(0.0, 0.16)) * length
    skirted, packed = rng.random() < 0.4, rng.random() < 0.3
    for side in (-1.0, 1.0):
        _leg(b, side * 0.2 * width, side * step, length, height, trousers)
        b.next_part()
    _torso(b, length, width, height, coat, long=bool(skirted))
    if packed:
        b.next_part()
        deep = 0.2 * length
        box(b, (-0.45 * length, -0.2 * width, 0.56 * height), (-deep, 0.2 * width, 0.8 * height), shade(trousers, 0.8))
    for side in (-1.0, 1.0):
        b.next_part()
        _arm(b, side, length, width, height, coat, skin)
    b.next_part()
    _head(b, length, width, height, skin, hair)
    return b.build()


def _leg(b: MeshBuilder, y: float, x: float, length: float, height: float, colour: Colour) -> None:
    shoe = 0.3 * length
    box(b, (x - 0.5 * shoe, y - 0.055, 0.0), (x + shoe, y + 0.055, 0.05 * height), SHOE)
    rings = ((0.04, x, 0.055), (0.27, 0.6 * x, 0.065), (0.4, 0.3 * x, 0.08), (0.5, 0.0, 0.095))
    limb(b, [(share * height, middle, y, 1.1 * radius, radius) for share, middle, radius in rings], colour)


def _torso(b: MeshBuilder, length: float, width: float, height: float, colour: Colour, *, long: bool) -> None:
    deep, wide = 0.26 * length, 0.33 * width
    hem = 0.36 if long else 0.45
    rings: list[Ring] = [
        (share * height, 0.0, 0.0, along * deep, across * wide)
        for share, along, across in (
            (hem, 1.0, 0.96),
            (0.56, 0.92, 0.86),
            (0.7, 1.0, 1.0),
            (0.8, 0.92, 1.02),
            (0.835, 0.6, 0.62),
        )
    ]
    limb(b, rings, colour)
    limb(b, [(0.505 * height, 0.0, 0.0, 1.0 * deep, 0.94 * wide), (0.525 * height, 0.0, 0.0, deep, 0.94 * wide)], SHOE)


def _arm(b: MeshBuilder, side: float, length: float, width: float, height: float, colour: Colour, skin: Colour) -> None:
    shoulder, hand, bend = side * 0.36 * width, side * 0.43 * width, 0.12 * length
    limb(
        b,
        [
            (0.45 * height, bend, hand, 0.05, 0.045),
            (0.62 * height, 0.0, hand, 0.055, 0.07 * width),
            (0.79 * height, 0.0, shoulder, 0.075, 0.09),
            (0.825 * height, 0.0, 0.8 * shoulder, 0.04, 0.05),
        ],
        shade(colour, 0.92),
    )
    rings = ((0.405, 0.02), (0.43, 0.045), (0.455, 0.04))
    limb(b, [(share * height, bend, hand, radius, 0.8 * radius) for share, radius in rings], skin)


def _head(b: MeshBuilder, length: float, width: float, height: float, skin: Colour, hair: Colour) -> None:
    deep, wide = min(0.2 * length, 0.1), min(0.16 * width, 0.085)
    limb(b, [(0.82 * height, 0.0, 0.0, 0.06, 0.06), (0.88 * height, 0.01, 0.0, 0.055, 0.055)], skin)
    face: list[Ring] = [
        (share * height, 0.01, 0.0, size * deep, size * wide)
        for share, size in ((0.865, 0.55), (0.89, 0.86), (0.93, 1.0), (0.965, 0.94))
    ]
    limb(b, face, skin)
    crown: list[Ring] = [
        (share * height, -0.015, 0.0, size * deep, size * wide)
        for share, size in ((0.945, 1.06), (0.975, 0.92), (0.992, 0.62), (1.0, 0.1))
    ]
    limb(b, crown, hair)
    limb(
        b, [(0.885 * height, -0.03, 0.0, 0.8 * deep, 0.9 * wide), (0.95 * height, -0.025, 0.0, deep, 1.04 * wide)], hair
    )


def limb(b: MeshBuilder, rings: list[Ring], colour: Colour) -> None:
    """A closed tube through elliptic rings, from the lowest up."""
    angle = 2.0 * np.pi * np.arange(SIDES + 1) / SIDES
    cosine, sine = np.cos(angle), np.sin(angle)
    for low, high in pairwise(rings):
        for i in range(SIDES):
            corners = ((low, i + 1), (low, i), (high, i), (high, i + 1))
            quad: list[Point] = [
                (x + along * float(cosine[k]), y + across * float(sine[k]), z)
                for (z, x, y, along, across), k in corners
            ]
            b.whole(quad, colour)
