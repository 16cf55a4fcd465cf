"""Cars: a lower body with bonnet and boot, a cabin with windows, lights, plates, wheels."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from vpf_sim.envs.camera.scenery.mesh import Colour, Mesh, MeshBuilder, Point

PAINTS: tuple[Colour, ...] = (
    (214, 216, 218),
    (236, 236, 234),
    (58, 60, 64),
    (30, 31, 34),
    (150, 154, 158),
    (112, 20, 24),
    (26, 52, 104),
    (52, 80, 66),
    (168, 120, 60),
    (96, 104, 118),
)
RUBBER: Colour = (26, 26, 27)
UNDERSIDE: Colour = (14, 14, 15)
GLASS: Colour = (34, 42, 50)
SKY_IN_GLASS: Colour = (88, 104, 122)
LAMP: Colour = (150, 14, 18)
LAMP_BRIGHT: Colour = (222, 62, 50)  # emissive
PLATE: Colour = (238, 238, 230)
CHROME: Colour = (176, 178, 182)
SILL_M = 0.24


@dataclass(frozen=True, slots=True)
class Style:
    """A car body style: place of the cabin, in lengths from the middle, and lean of its sides."""

    base_rear: float
    roof_rear: float
    roof_front: float
    base_front: float
    lean_m: float
    belt: float  # height of the windows' lower edge over the car's height


STYLES = (
    Style(-0.36, -0.20, 0.03, 0.19, 0.24, 0.63),  # saloon
    Style(-0.475, -0.36, 0.02, 0.20, 0.22, 0.62),  # hatchback
    Style(-0.48, -0.42, 0.03, 0.20, 0.20, 0.62),  # estate
    Style(-0.475, -0.40, 0.06, 0.22, 0.16, 0.58),  # sport utility
)


def car(length: float, width: float, height: float, rng: np.random.Generator) -> Mesh:
    """A car that fills its box; the seed sets style and paint."""
    return _built(length, width, height, STYLES[int(rng.integers(len(STYLES)))], PAINTS[int(rng.integers(len(PAINTS)))])


@lru_cache(maxsize=len(STYLES) * len(PAINTS))
def _built(length: float, width: float, height: float, style: Style, paint: Colour) -> Mesh:
    """Cached: most cars have one size."""
    builder = MeshBuilder()
    _underside(builder, length, width)
    _lower_body(builder, length, width, style.belt * height, style, paint)
    _cabin(builder, length, width, height, style, paint)
    return builder.build()


def shade(colour: Colour, factor: float) -> Colour:
    """The colour, lighter or darker."""
    return (min(255.0, colour[0] * factor), min(255.0, colour[1] * factor), min(255.0, colour[2] * factor))


def _underside(builder: MeshBuilder, length: float, width: float) -> None:
    half = 0.5 * width - 0.08
    for sign, name in ((-1.0, "rear"), (1.0, "front")):
        x = sign * (0.5 * length - 0.35)
        builder.whole(upright(x, half, 0.09, 0.4, name), UNDERSIDE)
        for y in (-half + 0.1, half - 0.1):
            wheel = upright(sign * (0.29 * length + 0.3), 0.1, 0.0, 0.4, name)
            builder.whole([(px, py + y, pz) for px, py, pz in wheel], RUBBER)


def upright(x: float, half_width: float, low: float, high: float, name: str, x_top: float | None = None) -> list[Point]:
    """A panel across the vehicle that faces rear or front; it leans if its top is at another x."""
    left, right = (-half_width, half_width) if name == "rear" else (half_width, -half_width)
    top = x if x_top is None else x_top
    return [(x, left, low), (x, right, low), (top, right, high), (top, left, high)]


def _lower_body(b: MeshBuilder, length: float, width: float, belt: float, style: Style, paint: Colour) -> None:
    end, half, bumper = 0.5 * length, 0.5 * width, 0.5
    bonnet = 0.5 * (belt + bumper) + 0.04
    outline = [
        (-end + 0.07, SILL_M),
        (-end, bumper),
        (-end + 0.09, belt),
        (style.base_front * length, belt),
        (end - 0.16, bonnet),
        (end, bumper),
        (end - 0.06, SILL_M),
    ]
    for side in (-1, 1):
        _side(b, outline, side * half, length, belt, paint)
    b.whole([(-end + 0.09, -half, belt), (-end + 0.09, half, belt), (0, half, belt), (0, -half, belt)], paint)
    front = style.base_front * length
    b.whole([(end - 0.16, half, bonnet), (end - 0.16, -half, bonnet), (front, -half, belt), (front, half, belt)], paint)
    _rear(b, end, half, bumper, belt, paint)
    _front(b, end, half, bumper, bonnet, paint)


def _side(
    b: MeshBuilder, outline: list[tuple[float, float]], y: float, length: float, belt: float, paint: Colour
) -> None:
    side = 1 if y > 0 else -1
    low, high = (-0.5 * length, y, 0.0), (0.5 * length, y, 1.0)
    panel: list[Point] = [low, (high[0], y, 0.0), high, (low[0], y, 1.0)]
    if side < 0:
        panel = [panel[1], panel[0], panel[3], panel[2]]

    def place(x: float, z: float) -> tuple[float, float]:
        return ((x / length + 0.5) if side > 0 else (0.5 - x / length), z)

    def strip(x0: float, x1: float, z0: float, z1: float, colour: Colour) -> None:
        b.shape(panel, [place(x0, z0), place(x0, z1), place(x1, z1), place(x1, z0)], colour)

    b.shape(panel, [place(x, z) for x, z in outline], paint)
    strip(-0.42 * length, 0.43 * length, SILL_M, SILL_M + 0.09, shade(paint, 0.35))
    strip(-0.47 * length, 0.30 * length, belt - 0.12, belt - 0.06, shade(paint, 1.18))
    strip(-0.30 * length, 0.28 * length, 0.47, 0.5, shade(paint, 0.7))
    for x in (-0.17, 0.02, 0.19):
        strip(x * length - 0.012, x * length + 0.012, 0.33, belt, shade(paint, 0.45))
    for x in (-0.12, 0.07):
        strip(x * length - 0.1, x * length + 0.08, belt - 0.2, belt - 0.16, shade(paint, 0.6))
    strip(-0.5 * length + 0.05, -0.5 * length + 0.35, belt - 0.26, belt - 0.1, LAMP)
    for x in (-0.29 * length, 0.30 * length):
        for radius, colour in ((0.38, UNDERSIDE), (0.33, RUBBER), (0.22, CHROME), (0.17, (70, 71, 74)), (0.06, CHROME)):
            b.disc((x, y + 0.004 * side, 0.33), radius, side, colour)


def _rear(b: MeshBuilder, end: float, half: float, bumper: float, belt: float, paint: Colour) -> None:
    lower = upright(-end + 0.07, half, SILL_M, bumper, "rear", -end)
    upper = upright(-end, half, bumper, belt, "rear", -end + 0.09)
    b.whole(lower, shade(paint, 0.86))
    b.detail(lower, (0.08, 0.0), (0.92, 0.38), (38, 38, 40))
    b.detail(lower, (0.0, 0.9), (1.0, 1.0), shade(paint, 1.1))
    for u in (0.06, 0.84):
        b.detail(lower, (u, 0.5), (u + 0.1, 0.64), LAMP)
    b.detail(lower, (0.2, 0.06), (0.27, 0.24), (92, 92, 94))
    b.whole(upper, paint)
    b.detail(upper, (0.0, 0.86), (1.0, 1.0), shade(paint, 1.16))
    b.detail(upper, (0.16, 0.06), (0.165, 0.97), shade(paint, 0.4))
    b.detail(upper, (0.835, 0.06), (0.84, 0.97), shade(paint, 0.4))
    b.detail(upper, (0.16, 0.04), (0.84, 0.08), shade(paint, 0.4))
    for u0, u1, inner in ((0.02, 0.2, 0.15), (0.8, 0.98, 0.8)):
        b.detail(upper, (u0, 0.42), (u1, 0.86), LAMP)
        b.detail(upper, (u0 + 0.02, 0.62), (u1 - 0.02, 0.78), LAMP_BRIGHT, lit=False)
        b.detail(upper, (inner, 0.46), (inner + 0.05, 0.58), (232, 228, 220))
    b.detail(upper, (0.36, 0.16), (0.64, 0.5), shade(paint, 0.6))
    plate(b, upper, (0.375, 0.2), (0.625, 0.46))
    b.detail(upper, (0.46, 0.62), (0.54, 0.78), CHROME)


def plate(b: MeshBuilder, panel: list[Point], low: tuple[float, float], high: tuple[float, float]) -> None:
    """A number plate with its characters."""
    with b.retroreflective():
        b.detail(panel, low, high, PLATE)
    step = (high[0] - low[0]) / 8.0
    for i in (0, 1, 3, 4, 5, 6):
        u = low[0] + (i + 0.7) * step
        v0, v1 = low[1] + 0.22 * (high[1] - low[1]), low[1] + 0.78 * (high[1] - low[1])
        b.detail(panel, (u, v0), (u + 0.6 * step, v1), (40, 42, 60))


def _front(b: MeshBuilder, end: float, half: float, bumper: float, bonnet: float, paint: Colour) -> None:
    lower = upright(end - 0.06, half, SILL_M, bumper, "front", end)
    upper = upright(end, half, bumper, bonnet, "front", end - 0.16)
    b.whole(lower, shade(paint, 0.9))
    b.detail(lower, (0.15, 0.08), (0.85, 0.55), (30, 30, 32))
    plate(b, lower, (0.38, 0.6), (0.62, 0.95))
    b.whole(upper, paint)
    b.detail(upper, (0.28, 0.15), (0.72, 0.75), (26, 27, 30))
    b.detail(upper, (0.46, 0.3), (0.54, 0.6), CHROME)
    for u in (0.02, 0.76):
        b.detail(upper, (u, 0.2), (u + 0.22, 0.8), (206, 212, 218))
        b.detail(upper, (u + 0.07, 0.3), (u + 0.15, 0.7), (250, 250, 244))


def _cabin(b: MeshBuilder, length: float, width: float, height: float, style: Style, paint: Colour) -> None:
    belt, half = style.belt * height, 0.5 * width - 0.03
    top = half - style.lean_m
    rear, front = style.base_rear * length, style.base_front * length
    roof_rear, roof_front = style.roof_rear * length, style.roof_front * length

    def lean(x0: float, x1: float, name: str) -> list[Point]:
        low, high = upright(x0, half, belt, belt, name), upright(x1, top, height, height, name)
        return [low[0], low[1], high[2], high[3]]

    for y, y_top in ((-half, -top), (half, top)):
        ends = ((rear, roof_rear), (front, roof_front)) if y > 0 else ((front, roof_front), (rear, roof_rear))
        (x0, t0), (x1, t1) = ends
        side: list[Point] = [(x0, y, belt), (x1, y, belt), (t1, y_top, height), (t0, y_top, height)]
        b.whole(side, shade(paint, 0.9))
        for u0, u1 in ((0.09, 0.47), (0.51, 0.9)):
            b.detail(side, (u0, 0.08), (u1, 0.84), GLASS)
            b.detail(side, (u0, 0.62), (u1, 0.84), SKY_IN_GLASS)
    b.whole(
        [(roof_rear, -top, height), (roof_rear, top, height), (roof_front, top, height), (roof_front, -top, height)],
        shade(paint, 1.05),
    )
    for x0, x1, name in ((rear, roof_rear, "rear"), (front, roof_front, "front")):
        window = lean(x0, x1, name)
        b.whole(window, paint)
        b.detail(window, (0.07, 0.08), (0.93, 0.86), GLASS)
        for u in (0.24, 0.62):
            b.detail(window, (u, 0.08), (u + 0.14, 0.42), (20, 22, 25))
        b.detail(window, (0.09, 0.66), (0.91, 0.84), SKY_IN_GLASS)
        b.detail(window, (0.11, 0.58), (0.89, 0.66), (58, 70, 82))
        if name == "rear":
            b.detail(window, (0.42, 0.89), (0.58, 0.95), LAMP)
            b.detail(window, (0.45, 0.08), (0.75, 0.13), (16, 16, 17))
