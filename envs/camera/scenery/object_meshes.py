"""Meshes of objects, by kind, size and seed."""

from collections.abc import Callable

import numpy as np

from vpf_sim.envs.camera.scenery.cars import CHROME, LAMP, PAINTS, RUBBER, UNDERSIDE, car, plate, shade, upright
from vpf_sim.envs.camera.scenery.living import cyclist, deer
from vpf_sim.envs.camera.scenery.mesh import Colour, Mesh, MeshBuilder, Point, box, box_panels
from vpf_sim.envs.camera.scenery.people import pedestrian
from vpf_sim.scenarios.kinds import SIZES

HEIGHTS_M: dict[str, float] = {kind: size.height_m for kind, size in SIZES.items()}

Maker = Callable[[float, float, float, np.random.Generator], Mesh]
WOOD: Colour = (150, 118, 78)
ORANGE: Colour = (232, 84, 26)
WHITE: Colour = (236, 236, 232)


def object_mesh(kind: str, size: tuple[float, float, float], rng: np.random.Generator) -> Mesh:
    """The mesh of an object of `size` (length, width, height) m; the seed sets colours and style."""
    return MAKERS[kind](*size, rng)


def van(length: float, width: float, height: float, rng: np.random.Generator) -> Mesh:
    """A panel van: a tall box, a short bonnet, windows in the rear doors."""
    b = MeshBuilder()
    paint = PAINTS[int(rng.integers(5))]
    end, half, front = 0.5 * length, 0.5 * width, 0.5 * length - 0.9
    _running_gear(b, length, width, 0.36)
    panels = box(b, (-end, -half, 0.28), (front, half, height), paint)
    nose = box_panels((front, -half, 0.28), (end, half, 0.5 * height))
    for name in ("left", "right", "top", "front"):
        b.whole(nose[name], paint)
    windscreen = upright(front + 0.55, half - 0.06, 0.5 * height, height - 0.12, "front", front)
    b.whole(windscreen, (40, 48, 56))
    b.detail(nose["front"], (0.2, 0.2), (0.8, 0.55), (28, 28, 30))
    for u in (0.03, 0.8):
        b.detail(nose["front"], (u, 0.6), (u + 0.17, 0.95), (215, 218, 220))
    _van_sides(b, panels, length, half, paint)
    rear = panels["rear"]
    b.detail(rear, (0.0, 0.0), (1.0, 0.1), (44, 44, 46))
    b.detail(rear, (0.495, 0.1), (0.505, 0.97), shade(paint, 0.35))
    for u0, u1 in ((0.12, 0.46), (0.54, 0.88)):
        b.detail(rear, (u0, 0.55), (u1, 0.86), (30, 37, 44))
        b.detail(rear, (u0 + 0.02, 0.74), (u1 - 0.02, 0.84), (84, 98, 114))
        b.detail(rear, (u0, 0.42), (u1, 0.44), shade(paint, 0.7))
    for u in (0.015, 0.905):
        b.detail(rear, (u, 0.22), (u + 0.08, 0.5), LAMP)
        b.detail(rear, (u + 0.015, 0.4), (u + 0.065, 0.47), (214, 104, 34), lit=False)
        b.detail(rear, (u + 0.015, 0.25), (u + 0.065, 0.31), WHITE)
    b.detail(rear, (0.52, 0.36), (0.6, 0.39), (40, 40, 42))
    plate(b, rear, (0.14, 0.18), (0.4, 0.25))
    b.detail(rear, (0.0, 0.95), (1.0, 1.0), shade(paint, 0.75))
    return b.build()


def _van_sides(b: MeshBuilder, panels: dict[str, list[Point]], length: float, half: float, paint: Colour) -> None:
    for name, side in (("left", -1), ("right", 1)):
        panel = panels[name]
        front_first = name == "left"
        window = (0.04, 0.24) if front_first else (0.76, 0.96)
        b.detail(panel, (window[0], 0.55), (window[1], 0.86), (34, 42, 50))
        b.detail(panel, (0.0, 0.0), (1.0, 0.06), shade(paint, 0.35))
        b.detail(panel, (0.0, 0.3), (1.0, 0.34), shade(paint, 0.72))
        for u in (0.28, 0.55, 0.8):
            place = u if front_first else 1.0 - u
            b.detail(panel, (place - 0.004, 0.08), (place + 0.004, 0.92), shade(paint, 0.45))
        _wheels(b, length, half, side, 0.36)


def truck(length: float, width: float, height: float, rng: np.random.Generator) -> Mesh:
    """A lorry: a cab and a box body with rear doors, underrun bar and lamps."""
    b = MeshBuilder()
    paint, cargo = (
        PAINTS[int(rng.integers(len(PAINTS)))],
        ((226, 226, 222), (190, 196, 204), (196, 180, 148))[int(rng.integers(3))],
    )
    end, half, wall = 0.5 * length, 0.5 * width, 0.5 * length - 2.1
    _running_gear(b, length, width, 0.5)
    cab = box(b, (wall + 0.15, -half + 0.05, 0.5), (end, half - 0.05, 0.85 * height), paint)
    b.detail(cab["front"], (0.06, 0.5), (0.94, 0.88), (36, 44, 52))
    b.detail(cab["front"], (0.2, 0.12), (0.8, 0.38), (28, 28, 30))
    for name in ("left", "right"):
        b.detail(cab[name], (0.2, 0.5), (0.8, 0.86), (36, 44, 52))
        _wheels(b, length, half, -1 if name == "left" else 1, 0.5)
    b.next_part()
    body = box(b, (-end, -half, 0.95), (wall, half, height), cargo)
    stripe = PAINTS[5 + int(rng.integers(5))]
    for name in ("left", "right"):
        b.detail(body[name], (0.0, 0.0), (1.0, 0.05), (70, 72, 76))
        b.detail(body[name], (0.1, 0.3), (0.9, 0.62), shade(stripe, 1.2))
        for u in np.linspace(0.14, 0.86, 7):
            b.detail(body[name], (u - 0.03, 0.38), (u + 0.02, 0.54), WHITE)
    _truck_doors(b, body["rear"], cargo)
    chassis = upright(-end, half - 0.1, 0.45, 0.95, "rear")
    b.whole(chassis, (30, 30, 32))
    b.detail(chassis, (0.0, 0.0), (1.0, 0.32), (96, 98, 102))
    for u in (0.02, 0.84):
        b.detail(chassis, (u, 0.4), (u + 0.14, 0.8), LAMP)
        b.detail(chassis, (u + 0.04, 0.5), (u + 0.1, 0.7), (222, 70, 48), lit=False)
    plate(b, chassis, (0.39, 0.42), (0.61, 0.8))
    return b.build()


def _truck_doors(b: MeshBuilder, rear: list[Point], cargo: Colour) -> None:
    frame = shade(cargo, 0.55)
    for low, high in (((0, 0), (1, 0.035)), ((0, 0.95), (1, 1)), ((0, 0), (0.03, 1)), ((0.97, 0), (1, 1))):
        b.detail(rear, low, high, frame)
    b.detail(rear, (0.494, 0.03), (0.506, 0.96), shade(cargo, 0.3))
    for u in (0.16, 0.38, 0.62, 0.84):
        b.detail(rear, (u - 0.01, 0.04), (u + 0.01, 0.95), shade(cargo, 0.68))
        b.detail(rear, (u - 0.03, 0.3), (u + 0.03, 0.34), (70, 72, 76))
    for i in range(8):
        colour = (200, 40, 36) if i % 2 == 0 else WHITE
        b.detail(rear, (0.03 + 0.1175 * i, 0.05), (0.03 + 0.1175 * (i + 1), 0.09), colour)


def cone(length: float, width: float, height: float, rng: np.random.Generator) -> Mesh:  # noqa: ARG001
    """A traffic cone: a rubber foot, an orange cone with two white bands."""
    b = MeshBuilder()
    foot, top = 0.06 * height, 0.12
    box(b, (-0.5 * length, -0.5 * width, 0.0), (0.5 * length, 0.5 * width, foot), (44, 40, 38))
    radius, sides = 0.42 * min(length, width), 12
    bands = ((0.0, 0.34, ORANGE), (0.34, 0.5, WHITE), (0.5, 0.66, ORANGE), (0.66, 0.82, WHITE), (0.82, 1.0, ORANGE))
    for i in range(sides):
        a0, a1 = 2.0 * np.pi * i / sides, 2.0 * np.pi * (i + 1) / sides
        for low, high, colour in bands:
            r0, r1 = (radius * (1 - v * (1 - top)) for v in (low, high))
            z0, z1 = (foot + v * (height - foot) for v in (low, high))
            ring = [(r0, a1, z0), (r0, a0, z0), (r1, a0, z1), (r1, a1, z1)]
            with b.retroreflective(colour == WHITE):
                b.whole([(float(r * np.cos(a)), float(r * np.sin(a)), z) for r, a, z in ring], colour)
    return b.build()


def pallet(length: float, width: float, height: float, rng: np.random.Generator) -> Mesh:
    """A wooden pallet: three runners, boards across the top."""
    b = MeshBuilder()
    panels = box(b, (-0.5 * length, -0.5 * width, 0.0), (0.5 * length, 0.5 * width, height), (52, 40, 28))
    for name in ("rear", "front", "left", "right"):
        b.detail(panels[name], (0.0, 0.72), (1.0, 1.0), WOOD)
        b.detail(panels[name], (0.0, 0.0), (1.0, 0.14), shade(WOOD, 0.85))
        for u in (0.0, 0.43, 0.86):
            b.detail(panels[name], (u, 0.0), (u + 0.14, 1.0), shade(WOOD, float(rng.uniform(0.8, 1.0))))
    for i in range(7):
        v = i / 6.5
        b.detail(panels["top"], (0.0, v), (1.0, min(1.0, v + 0.115)), shade(WOOD, float(rng.uniform(0.85, 1.2))))
    return b.build()


def barrier(length: float, width: float, height: float, rng: np.random.Generator) -> Mesh:  # noqa: ARG001
    """A work-site barrier across the road: red and white boards on feet, lamps on top."""
    b = MeshBuilder()
    half, thin = 0.5 * width, 0.5 * min(length, 0.3)
    for y in (-0.8 * half, 0.8 * half):
        box(b, (-0.5 * length, y - 0.12, 0.0), (0.5 * length, y + 0.12, 0.12 * height), (48, 46, 45))
    with b.retroreflective():
        panels = box(b, (-thin, -half, 0.12 * height), (thin, half, height), (226, 226, 222))
        count = max(2, round(width / 0.35))
        for name in ("rear", "front"):
            for i in range(count):
                u, step = i / count, 1.0 / count
                for v0, v1 in ((0.52, 0.95), (0.08, 0.4)):
                    outline = [(u, v0), (u + 0.5 * step, v1), (u + step, v1), (u + 0.5 * step, v0)]
                    b.shape(panels[name], outline, (206, 32, 28))
            b.detail(panels[name], (0.0, 0.42), (1.0, 0.5), (120, 122, 124))
            for u in (0.06, 0.5, 0.94):
                b.detail(panels[name], (u - 0.015, 0.0), (u + 0.015, 1.0), (150, 152, 154))
        for name in ("left", "right"):
            b.detail(panels[name], (0.2, 0.55), (0.8, 0.9), (206, 32, 28))
    return b.build()


def door(length: float, width: float, height: float, rng: np.random.Generator) -> Mesh:
    """A car's door: a panel with a window above and the lining on its inner side."""
    b = MeshBuilder()
    paint = PAINTS[int(rng.integers(len(PAINTS)))]
    panels = box(b, (-0.5 * length, -0.5 * width, 0.25), (0.5 * length, 0.5 * width, height), paint)
    for name, lining in (("left", paint), ("right", (52, 52, 54))):
        b.detail(panels[name], (0.0, 0.0), (1.0, 0.58), lining)
        b.detail(panels[name], (0.06, 0.62), (0.94, 0.95), (70, 82, 92))
    return b.build()


def _running_gear(b: MeshBuilder, length: float, width: float, radius: float) -> None:
    """Underside and wheels as visible from behind and from the front."""
    half = 0.5 * width - 0.1
    for sign, name in ((-1.0, "rear"), (1.0, "front")):
        b.whole(upright(sign * (0.5 * length - 0.4), half, 0.16, 2.2 * radius, name), UNDERSIDE)
        for y in (-half + 0.14, half - 0.14):
            wheel = upright(sign * (0.29 * length + radius), 0.14, 0.0, 1.6 * radius, name)
            b.whole([(px, py + y, pz) for px, py, pz in wheel], RUBBER)


def _wheels(b: MeshBuilder, length: float, half: float, side: int, radius: float) -> None:
    for x in (-0.29 * length, 0.34 * length):
        for part, colour in ((1.1, UNDERSIDE), (1.0, RUBBER), (0.6, CHROME), (0.45, (70, 71, 74))):
            b.disc((x, side * (half + 0.004), radius), part * radius, side, colour)


MAKERS: dict[str, Maker] = {
    "car": car,
    "van": van,
    "truck": truck,
    "cone": cone,
    "pallet": pallet,
    "barrier": barrier,
    "pedestrian": pedestrian,
    "cyclist": cyclist,
    "deer": deer,
    "door": door,
}
