"""Meshes of traffic signs: discs, triangles, boards with text lines, gantry boards."""

from collections.abc import Sequence

import numpy as np

from vpf_sim.envs.camera.scenery.mesh import Colour, Mesh, MeshBuilder, Point, box

WHITE: Colour = (236, 236, 232)
BLACK: Colour = (30, 30, 32)
RED: Colour = (196, 26, 32)
BLUE: Colour = (24, 72, 160)
GREEN: Colour = (18, 104, 66)
YELLOW: Colour = (240, 200, 40)
POLE: Colour = (132, 136, 140)
BACK: Colour = (120, 124, 128)
POLES_M = 30.0  # range of poles with sides
FAR_M = 45.0  # range of a sign's details

# The seven strokes of a digit: top, upper left, upper right, middle, lower left, lower right, bottom.
STROKES = (
    (0, 0.84, 1, 1),
    (0, 0.5, 0.28, 1),
    (0.72, 0.5, 1, 1),
    (0, 0.42, 1, 0.58),
    (0, 0, 0.28, 0.5),
    (0.72, 0, 1, 0.5),
)
BOTTOM = (0, 0, 1, 0.16)
DIGITS = {0: "0124 56", 3: "02356", 5: "01356", 6: "013456", 7: "025", 8: "0123456", 1: "25", 2: "02346"}


def ring(sides: int, radius: float, turn: float = 0.0) -> list[tuple[float, float]]:
    """A regular polygon around the middle of a panel, in shares of it, clockwise."""
    angle = turn - 2.0 * np.pi * np.arange(sides) / sides
    return [(0.5 + radius * float(np.cos(a)), 0.5 + radius * float(np.sin(a))) for a in angle]


def fan(b: MeshBuilder, panel: list[Point], outline: Sequence[tuple[float, float]], colour: Colour) -> None:
    """Add a convex polygon on a panel as faces of at most four corners."""
    for i in range(1, len(outline) - 1, 2):
        b.shape(panel, [outline[0], *outline[i : i + 3]], colour)


def _facing(y: float, half: float, low: float, height: float, x: float = -0.02) -> list[Point]:
    return [(x, y - half, low), (x, y + half, low), (x, y + half, low + height), (x, y - half, low + height)]


def _pole(b: MeshBuilder, height: float, y: float = 0.0) -> None:
    kept = b.drawn_m
    b.drawn_m = (0.0, POLES_M)
    panels = box(b, (0.0, y - 0.035, 0.0), (0.07, y + 0.035, height), POLE)
    b.drawn_m = (POLES_M, kept[1])
    for name in ("rear", "front"):
        b.whole(panels[name], POLE)
    b.drawn_m = kept


def _number(b: MeshBuilder, panel: list[Point], digits: Sequence[int], colour: Colour) -> None:
    wide, tall = 0.2, 0.4
    left = 0.5 - 0.5 * (len(digits) * wide + (len(digits) - 1) * 0.07)
    for k, digit in enumerate(digits):
        u = left + k * (wide + 0.07)
        for stroke in DIGITS[digit].replace(" ", ""):
            u0, v0, u1, v1 = (*STROKES, BOTTOM)[int(stroke)]
            low, high = (u + wide * u0, 0.3 + tall * v0), (u + wide * u1, 0.3 + tall * v1)
            b.detail(panel, low, high, colour)


def limit(tens: int) -> Mesh:
    """A speed limit: a red ring round a number."""
    b = MeshBuilder()
    _pole(b, 2.5)
    panel = _facing(0.0, 0.42, 2.0, 0.84)
    with b.retroreflective():
        fan(b, panel, ring(12, 0.5), RED)
        fan(b, panel, ring(12, 0.39), WHITE)
        b.drawn_m = (0.0, FAR_M)
        _number(b, panel, [tens, 0], BLACK)
    return b.build()


def warning() -> Mesh:
    """A triangle with an exclamation mark."""
    b = MeshBuilder()
    _pole(b, 2.5)
    panel = _facing(0.0, 0.5, 1.9, 0.9)
    with b.retroreflective():
        b.shape(panel, [(0.0, 0.0), (0.5, 1.0), (1.0, 0.0)], RED)
        b.shape(panel, [(0.16, 0.09), (0.5, 0.78), (0.84, 0.09)], WHITE)
        b.drawn_m = (0.0, FAR_M)
        b.detail(panel, (0.46, 0.3), (0.54, 0.6), BLACK)
        b.detail(panel, (0.46, 0.16), (0.54, 0.24), BLACK)
    return b.build()


def board(colour: Colour, width: float, height: float, low: float, lines: Sequence[tuple[float, float]]) -> Mesh:
    """A board on two poles with a border and text lines, given as (start, end) shares of the width."""
    b = MeshBuilder()
    for y in (-0.35 * width, 0.35 * width):
        _pole(b, low + 0.6 * height, y)
    panel = _facing(0.0, 0.5 * width, low, height)
    b.whole([panel[1], panel[0], panel[3], panel[2]], BACK)
    with b.retroreflective():
        b.whole(panel, WHITE if colour != WHITE else BLACK)
        margin = 0.05
        b.detail(panel, (margin * height / width, margin), (1.0 - margin * height / width, 1.0 - margin), colour)
        _writing(b, panel, lines, BLACK if colour in (WHITE, YELLOW) else WHITE)
    return b.build()


def _writing(b: MeshBuilder, panel: list[Point], lines: Sequence[tuple[float, float]], colour: Colour) -> None:
    """Text lines as rows of bars."""
    b.drawn_m, kept = (0.0, FAR_M), b.drawn_m
    step = 0.8 / len(lines)
    for i, (start, end) in enumerate(lines):
        v, u = 0.9 - step * (i + 0.8), start
        for word in (0.16, 0.24, 0.12, 0.2):
            if u >= end:
                break
            b.detail(panel, (u, v), (min(u + word, end), v + 0.5 * step), colour)
            u += word + 0.04
    b.drawn_m = kept


def chevron(count: int, to_right: bool) -> Mesh:
    """A board with arrowheads that marks a bend."""
    b = MeshBuilder()
    width = 0.55 * count
    _pole(b, 1.4)
    panel = _facing(0.0, 0.5 * width, 0.8, 0.6)
    with b.retroreflective():
        b.whole(panel, WHITE)
        for k in range(count):
            tip, tail = (1.0, 0.0) if to_right else (0.0, 1.0)
            for low, high in ((0.06, 0.5), (0.94, 0.5)):
                outline = [
                    (tail * 0.5 + 0.05, low),
                    (tip * 0.5 + 0.1, high),
                    (tip * 0.5 + 0.38, high),
                    (tail * 0.5 + 0.33, low),
                ]
                if (low > high) != to_right:
                    outline.reverse()
                b.shape(panel, [((k + u) / count, v) for u, v in outline], RED)
    return b.build()


def direction_board(b: MeshBuilder, y: float, low: float, seed: int) -> None:
    """Hang a direction board over a lane."""
    colour = (BLUE, GREEN, BLUE)[seed % 3]
    panel = _facing(y, 1.6, low, 2.3, x=-0.24)
    b.whole([panel[1], panel[0], panel[3], panel[2]], BACK)
    with b.retroreflective():
        b.whole(panel, WHITE)
        b.detail(panel, (0.02, 0.03), (0.98, 0.97), colour)
        _writing(b, panel, ((0.1, 0.6 + 0.1 * (seed % 3)), (0.1, 0.85), (0.1, 0.5)), WHITE)
        b.shape(panel, [(0.74, 0.34), (0.82, 0.1), (0.82, 0.1), (0.9, 0.34)], WHITE)
        b.detail(panel, (0.79, 0.3), (0.85, 0.5), WHITE)


def lane_arrow(b: MeshBuilder, y: float, low: float) -> None:
    """Hang a lane signal over a lane: a green arrow on black."""
    panel = _facing(y, 0.6, low, 1.2, x=-0.24)
    b.whole([panel[1], panel[0], panel[3], panel[2]], BACK)
    b.whole(panel, BLACK)
    glow: Colour = (70, 225, 120)
    b.shape(panel, [(0.2, 0.5), (0.8, 0.5), (0.5, 0.15)], glow, lit=False)
    b.detail(panel, (0.42, 0.5), (0.58, 0.85), glow, lit=False)


SIGNS = (
    limit(6),
    limit(8),
    limit(5),
    warning(),
    board(BLUE, 2.2, 1.3, 1.7, ((0.1, 0.7), (0.1, 0.85))),
    board(GREEN, 2.8, 1.7, 1.8, ((0.1, 0.8), (0.1, 0.6), (0.1, 0.7))),
    board(WHITE, 1.6, 0.9, 1.7, ((0.1, 0.9), (0.1, 0.7))),
    board(YELLOW, 1.5, 1.0, 1.6, ((0.1, 0.9), (0.1, 0.6))),
)
