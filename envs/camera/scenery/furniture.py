"""Meshes of road furniture: posts, guard rails, lamp posts, gantries.

Fronts face -x, towards approaching drivers; every face has at most four corners.
"""

from functools import lru_cache

from vpf_sim.envs.camera.scenery.mesh import Colour, Mesh, MeshBuilder, Point, box, box_panels
from vpf_sim.envs.camera.scenery.signs import direction_board, lane_arrow

STEEL: Colour = (158, 163, 168)
DARK_STEEL: Colour = (112, 117, 122)
WHITE: Colour = (232, 233, 230)
BLACK: Colour = (34, 34, 36)
ORANGE: Colour = (236, 150, 40)
NEAR_M = 22.0  # range of full detail
FAR_M = 60.0  # range of full detail of gantries
LAMP_HEIGHT_M, LAMP_ARM_M = 9.0, 1.8
LAMP_M = (-LAMP_ARM_M - 0.35, LAMP_HEIGHT_M - 0.08)  # right of the post's foot, and up: the middle of the lamp
CLEARANCE_M = 5.6  # clearance under a gantry's boards
TRUSS_M = (6.3, 7.2)  # heights of its beams


def shade_of(colour: Colour, factor: float) -> Colour:
    """The colour, lighter or darker."""
    return (colour[0] * factor, colour[1] * factor, colour[2] * factor)


def _post() -> Mesh:
    """A delineator: a white post with a slanting black band and a reflector."""
    b = MeshBuilder()
    band = [(0.0, 0.64), (0.0, 0.9), (1.0, 0.84), (1.0, 0.58)]
    b.drawn_m = (0.0, NEAR_M)
    panels = box(b, (-0.05, -0.06, 0.0), (0.05, 0.06, 1.0), WHITE)
    for name in ("rear", "left", "right"):
        b.shape(panels[name], band, BLACK)
    with b.retroreflective():
        b.detail(panels["rear"], (0.3, 0.66), (0.7, 0.82), (216, 206, 176))
    b.drawn_m = (NEAR_M, 1e3)
    b.whole(panels["rear"], WHITE)
    b.shape(panels["rear"], band, BLACK)
    return b.build()


@lru_cache(maxsize=64)
def rail(length: float) -> Mesh:
    """A span of guard rail along x, centred at the origin: a folded band on three posts, visible from both sides."""
    b = MeshBuilder()
    half = 0.5 * length
    for x in (-0.66 * half, 0.0, 0.66 * half):
        b.drawn_m = (0.0, 0.6 * NEAR_M)
        box(b, (x - 0.06, -0.05, 0.0), (x + 0.06, 0.05, 0.68), shade_of(STEEL, 0.7))
        b.drawn_m = (0.6 * NEAR_M, 50.0)
        b.whole([(x, -0.06, 0.0), (x, 0.06, 0.0), (x, 0.06, 0.68), (x, -0.06, 0.68)], shade_of(STEEL, 0.7))
    b.drawn_m = (NEAR_M, 1e3)
    _band(b, half, 0.45, 0.76, shade_of(STEEL, 0.92))
    b.drawn_m = (0.0, NEAR_M)
    _band(b, half, 0.45, 0.76, shade_of(STEEL, 0.82))
    for low, high, factor in ((0.515, 0.575, 1.14), (0.575, 0.635, 0.6), (0.635, 0.695, 1.14)):
        _band(b, half, low, high, shade_of(STEEL, factor))
    for y, turn in ((-0.11, 1.0), (0.11, -1.0)):
        for x0, x1, low, high, colour in (
            (-0.06, 0.06, 0.56, 0.66, ORANGE),
            (0.5 * half - 0.06, 0.5 * half + 0.06, 0.47, 0.74, DARK_STEEL),
        ):
            near, far = (x1, x0) if turn > 0 else (x0, x1)
            b.whole([(near, y, low), (far, y, low), (far, y, high), (near, y, high)], colour)
    return b.build()


def _band(b: MeshBuilder, half: float, low: float, high: float, colour: Colour) -> None:
    for y, near, far in ((-0.1, half, -half), (0.1, -half, half)):
        b.whole([(near, y, low), (far, y, low), (far, y, high), (near, y, high)], colour)


def _lamp_mast() -> Mesh:
    """The mast of a lamp post."""
    b = MeshBuilder()
    b.drawn_m = (0.0, 2.0 * NEAR_M)
    box(b, (-0.14, -0.14, 0.0), (0.14, 0.14, 0.9), shade_of(STEEL, 0.8))
    _mast(b, 0.1, 0.05, LAMP_HEIGHT_M, shade_of(STEEL, 0.95))
    b.drawn_m = (2.0 * NEAR_M, 1e3)
    top = LAMP_HEIGHT_M
    b.whole([(0.0, -0.1, 0.0), (0.0, 0.1, 0.0), (0.0, 0.05, top), (0.0, -0.05, top)], shade_of(STEEL, 0.95))
    return b.build()


def _lamp_arm() -> Mesh:
    """The arm of a lamp post to the left, over the road, with the lamp."""
    b = MeshBuilder()
    top, arm = LAMP_HEIGHT_M, LAMP_ARM_M
    b.drawn_m = (2.0 * NEAR_M, 1e3)
    for y0, y1, z0, z1 in ((-arm, 0.05, top - 0.06, top + 0.06), (-arm - 0.75, -arm + 0.05, top - 0.05, top + 0.1)):
        b.whole([(0.0, y0, z0), (0.0, y1, z0), (0.0, y1, z1), (0.0, y0, z1)], shade_of(STEEL, 0.8))
    b.drawn_m = (0.0, 2.0 * NEAR_M)
    box(b, (-0.05, -arm, top - 0.06), (0.05, 0.05, top + 0.06), shade_of(STEEL, 0.9))
    left, right, low = -arm - 0.75, -arm + 0.05, top - 0.05
    b.whole([(-0.16, right, low), (-0.16, left, low), (0.16, left, low), (0.16, right, low)], (214, 216, 210))
    box(b, (-0.16, left, low), (0.16, right, top + 0.1), shade_of(STEEL, 0.72))
    return b.build()


def _mast(b: MeshBuilder, low_radius: float, high_radius: float, height: float, colour: Colour) -> None:
    """A tapered square mast."""
    corners = ((-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0))
    for (x0, y0), (x1, y1) in zip(corners, (*corners[1:], corners[0]), strict=True):
        low, high = low_radius, high_radius
        foot: list[Point] = [(low * x0, low * y0, 0.0), (low * x1, low * y1, 0.0)]
        tip: list[Point] = [(high * x1, high * y1, height), (high * x0, high * y0, height)]
        b.whole([*foot, *tip], colour)


@lru_cache(maxsize=64)
def gantry(width: float, lane_middles_m: tuple[float, ...], seed: int) -> tuple[Mesh, ...]:
    """The legs and the truss of a gantry over a road, with a board or a signal over each lane.

    The legs are `width` m apart; y = 0 is in the middle.
    """
    legs = tuple(_gantry_leg(y) for y in (-0.5 * width, 0.5 * width))
    b = MeshBuilder()
    _truss(b, 0.5 * width)
    for k, y in enumerate(lane_middles_m):
        if (k + seed) % 3 == 0:
            lane_arrow(b, y, CLEARANCE_M + 0.4)
        else:
            direction_board(b, y, CLEARANCE_M + 0.1, k + seed)
    return (*legs, b.build())


@lru_cache(maxsize=64)
def _gantry_leg(y: float) -> Mesh:
    b = MeshBuilder()
    foot = ((-0.3, y - 0.35, 0.0), (0.3, y + 0.35, 0.8), (150.0, 149.0, 146.0))
    leg = ((-0.18, y - 0.18, 0.8), (0.18, y + 0.18, TRUSS_M[1]), DARK_STEEL)
    for low, high, colour in (foot, leg):
        b.drawn_m = (0.0, FAR_M)
        panels = box(b, low, high, colour)
        b.drawn_m = (FAR_M, 1e3)
        b.whole(panels["rear"], colour)
        b.whole(panels["front"], colour)
    return b.build()


def _truss(b: MeshBuilder, half: float) -> None:
    """Two beams and the bars between them."""
    low, high = TRUSS_M
    for bottom, top, factor in ((low, low + 0.16, 0.9), (high - 0.16, high, 1.0)):
        b.drawn_m = (FAR_M, 1e3)
        panels = box_panels((-0.14, -half, bottom), (0.14, half, top))
        for name in ("rear", "front"):
            b.whole(panels[name], shade_of(STEEL, factor))
        b.drawn_m = (0.0, FAR_M)
        box(b, (-0.14, -half, bottom), (0.14, half, top), shade_of(STEEL, factor))
        under: list[Point] = [
            (-0.14, half, bottom),
            (-0.14, -half, bottom),
            (0.14, -half, bottom),
            (0.14, half, bottom),
        ]
        b.whole(under, shade_of(STEEL, 0.5))
    b.drawn_m = (0.0, 0.9 * FAR_M)
    count = max(2, round(half / 0.9))
    for i in range(count):
        y0, y1 = (-half + 2.0 * half * (i + k) / count for k in (0.0, 1.0))
        z0, z1 = (low + 0.16, high - 0.16) if i % 2 else (high - 0.16, low + 0.16)
        b.whole([(-0.1, y0, z0), (-0.1, y0 + 0.12, z0), (-0.1, y1, z1), (-0.1, y1 - 0.12, z1)], shade_of(STEEL, 0.85))
    b.drawn_m = (0.0, 1e3)


POST = _post()
LAMP_POST = (_lamp_mast(), _lamp_arm())
