"""What stands along a road and never moves, as meshes: posts, guard rails, signs."""

from functools import lru_cache

from vpf_sim.envs.camera.mesh import Colour, Mesh, MeshBuilder, Point, box

STEEL: Colour = (158, 163, 168)
WHITE: Colour = (232, 233, 230)
BLACK: Colour = (34, 34, 36)


def post() -> Mesh:
    """A delineator: a white post with a black band and a reflector."""
    b = MeshBuilder()
    panels = box(b, (-0.05, -0.06, 0.0), (0.05, 0.06, 1.0), WHITE)
    for panel in panels.values():
        b.detail(panel, (0.0, 0.66), (1.0, 0.9), BLACK)
        b.detail(panel, (0.3, 0.7), (0.7, 0.86), (210, 200, 170))
    return b.build()


@lru_cache(maxsize=256)
def rail(length: float) -> Mesh:
    """One span of a guard rail along x: a folded band on a post; both sides."""
    b = MeshBuilder()
    box(b, (-0.06, -0.05, 0.0), (0.06, 0.05, 0.68), shade_of(STEEL, 0.7))
    bands = (
        (0.45, 0.76, 0.85),
        (0.45, 0.52, 0.8),
        (0.52, 0.58, 1.12),
        (0.58, 0.63, 0.62),
        (0.63, 0.69, 1.12),
        (0.69, 0.76, 0.85),
    )
    for low, high, factor in bands:
        for y, ends in ((-0.1, (length, 0.0)), (0.1, (0.0, length))):
            near, far = ends
            panel: list[Point] = [(near, y, low), (far, y, low), (far, y, high), (near, y, high)]
            b.whole(panel, shade_of(STEEL, factor))
    for y, (near, far) in ((-0.11, (0.18, 0.06)), (0.11, (0.06, 0.18))):
        b.whole([(near, y, 0.56), (far, y, 0.56), (far, y, 0.66), (near, y, 0.66)], (236, 150, 40))
        b.whole(
            [
                (near + length / 2, y, 0.47),
                (far + length / 2, y, 0.47),
                (far + length / 2, y, 0.74),
                (near + length / 2, y, 0.74),
            ],
            (96, 99, 102),
        )
    return b.build()


def shade_of(colour: Colour, factor: float) -> Colour:
    """The colour, lighter or darker."""
    return (colour[0] * factor, colour[1] * factor, colour[2] * factor)


def sign(colour: Colour, border: Colour, width: float, height: float, low: float) -> Mesh:
    """A sign on a pole that faces back along x, with bars for its writing."""
    b = MeshBuilder()
    box(b, (0.02, -0.04, 0.0), (0.1, 0.04, low + 0.5 * height), shade_of(STEEL, 0.8))
    panels = box(b, (-0.03, -0.5 * width, low), (0.0, 0.5 * width, low + height), border)
    b.detail(panels["rear"], (0.04, 0.05), (0.96, 0.95), colour)
    for i, span in enumerate(((0.15, 0.7), (0.15, 0.85), (0.15, 0.55))):
        v = 0.72 - 0.24 * i
        b.detail(panels["rear"], (span[0], v), (span[1], v + 0.11), border)
    b.whole(panels["front"], shade_of(STEEL, 0.75))
    return b.build()


POST = post()
SIGNS = (
    sign((24, 76, 168), WHITE, 1.6, 1.1, 1.6),
    sign(WHITE, (190, 30, 34), 0.8, 0.8, 1.9),
    sign((18, 104, 66), WHITE, 2.4, 1.5, 1.8),
    sign((238, 200, 40), BLACK, 0.9, 0.9, 1.8),
)
