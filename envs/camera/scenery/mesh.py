"""Meshes of flat convex faces with flat details (windows, lights, plates) on them.

Object axes: x forward, y right, z up from the road, origin under the object's middle.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from vpf_sim.types import Bools, Floats

Point = tuple[float, float, float]
Colour = tuple[float, float, float]
# panel, outline, colour, whether it is lit and retroreflective, part, distance range
Face = tuple[list[Point], list[tuple[float, float]], Colour, bool, bool, int, tuple[float, float]]

VERTICES = 12  # every face has this many; the last one is repeated
_ANGLES = np.linspace(0.0, 2.0 * np.pi, VERTICES, endpoint=False)
CIRCLE = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)])
WHOLE = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)]  # the outline of a whole panel
UNIT: list[Point] = [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 1.0, 1.0), (0.0, 0.0, 1.0)]


@dataclass(frozen=True)
class Mesh:
    """F faces in painter's order: later faces cover earlier ones."""

    faces_m: Floats  # (F, VERTICES, 3)
    normals: Floats  # (F, 3) unit, outward
    colours: Floats  # (F, 3) RGB 0..255 in full light
    lit: Bools  # (F,) whether light shades it; lamps are emissive
    retro: Bools  # (F,) whether it is retroreflective: signs, reflectors, number plates
    parts: NDArray[np.int64]  # (F,) index of the convex part; the farthest part is drawn first
    thickness_m: Floats  # (F,) extent across the longest side
    from_m: Floats  # (F,) nearest distance at which it is drawn: coarse faces for far objects
    until_m: Floats  # (F,) largest distance
    centres_m: Floats  # (parts, 3) centres of the parts

    @property
    def height_m(self) -> float:
        return float(self.faces_m[..., 2].max())

    @cached_property
    def reach_m(self) -> float:
        """The largest distance of a vertex from the origin."""
        return float(np.linalg.norm(self.faces_m, axis=2).max())


@dataclass(slots=True)
class MeshBuilder:
    """Collects faces and computes all vertices at once, in `build`: a road has thousands."""

    faces: list[Face] = field(default_factory=list)
    discs: dict[int, tuple[Floats, Floats]] = field(default_factory=dict)  # by face index: points and normal
    part: int = 0
    drawn_m: tuple[float, float] = (0.0, np.inf)  # distance range of the following faces
    _reflects: bool = field(default=False, init=False)  # whether the following faces are retroreflective

    def next_part(self) -> None:
        """Start a new convex part."""
        self.part += 1

    @contextmanager
    def retroreflective(self, reflects: bool = True) -> Iterator[None]:
        """Faces added in this context throw light back to where it comes from."""
        before, self._reflects = self._reflects, reflects
        try:
            yield
        finally:
            self._reflects = before

    def detail(
        self, panel: list[Point], low: tuple[float, float], high: tuple[float, float], colour: Colour, lit: bool = True
    ) -> None:
        """Add a rectangle on a panel; `low` and `high` are opposite corners as shares (right, up) of it.

        Panels are bottom left, bottom right, top right, top left, from outside.
        """
        (u0, v0), (u1, v1) = low, high
        self.shape(panel, [(u0, v0), (u0, v1), (u1, v1), (u1, v0)], colour, lit)

    def shape(self, panel: list[Point], outline: list[tuple[float, float]], colour: Colour, lit: bool = True) -> None:
        """Add a polygon on a panel, given in shares (right, up) of it."""
        padded = outline + outline[-1:] * (VERTICES - len(outline))
        self.faces.append((panel, padded, colour, lit, self._reflects, self.part, self.drawn_m))

    def whole(self, panel: list[Point], colour: Colour, lit: bool = True) -> None:
        """Add a whole panel."""
        self.shape(panel, WHOLE, colour, lit)

    def disc(self, centre: Point, radius: float, side: int, colour: Colour) -> None:
        """Add an upright disc facing left (side -1) or right (+1)."""
        x, z = centre[0] + radius * CIRCLE[0], np.maximum(0.0, centre[2] + radius * CIRCLE[1])
        points = np.stack([x, np.full(VERTICES, centre[1]), z], axis=1)
        self.discs[len(self.faces)] = points, np.array([0.0, float(side), 0.0])
        self.shape(UNIT, WHOLE, colour)

    def build(self) -> Mesh:
        panels, outlines, colours, lit, retro, part, drawn_m = zip(*self.faces, strict=True)
        faces, normals = _on_panels(np.array(panels, float), np.array(outlines, float))
        for index, (points, normal) in self.discs.items():
            faces[index], normals[index] = points, normal
        parts, distances = np.array(part), np.array(drawn_m)
        centres = [faces[parts == part].mean(axis=(0, 1)) for part in range(self.part + 1)]
        return Mesh(
            faces_m=faces,
            normals=normals,
            colours=np.array(colours, float),
            lit=np.array(lit),
            retro=np.array(retro),
            parts=parts,
            thickness_m=_thickness(faces),
            from_m=distances[:, 0],
            until_m=distances[:, 1],
            centres_m=np.array(centres),
        )


def _on_panels(panels: Floats, outlines: Floats) -> tuple[Floats, Floats]:
    """(F, V, 3) points and (F, 3) unit normals of polygons with outlines (F, V, 2) on panels (F, 4, 3)."""
    bottom_left, bottom_right, top_right, top_left = (panels[:, None, i] for i in range(4))
    u, v = outlines[..., :1], outlines[..., 1:]
    points = (1 - v) * ((1 - u) * bottom_left + u * bottom_right) + v * ((1 - u) * top_left + u * top_right)
    normals = _cross((top_left - bottom_left)[:, 0], (bottom_right - bottom_left)[:, 0])
    return points, normals / np.sqrt(np.vecdot(normals, normals))[:, None]


def _thickness(faces: Floats) -> Floats:
    """(F,) m, area over longest extent of convex faces (F, VERTICES, 3); most of them have four corners."""
    found = np.empty(len(faces))
    has_four = (faces[:, 4:] == faces[:, 3:4]).all(axis=(1, 2))
    found[has_four], found[~has_four] = _thickness_of(faces[has_four, :4]), _thickness_of(faces[~has_four])
    return found


def _thickness_of(faces: Floats) -> Floats:
    """(F,) m, of convex faces (F, V, 3)."""
    spokes = faces - faces[:, :1]
    area = 0.5 * _lengths(_cross(spokes[:, 1:-1], spokes[:, 2:])).sum(axis=1)
    longest = _lengths(faces[:, :, None] - faces[:, None, :]).max(axis=(1, 2))
    return np.asarray(area / longest)


def _cross(a: Floats, b: Floats) -> Floats:
    """`numpy.cross` of (..., 3), without its overhead for small arrays."""
    found = np.empty_like(a)
    for axis in range(3):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        found[..., axis] = a[..., one] * b[..., other] - a[..., other] * b[..., one]
    return found


def _lengths(vectors: Floats) -> Floats:
    """(...) of (..., 3)."""
    return np.asarray(np.sqrt((vectors * vectors).sum(axis=-1)))


def box(builder: MeshBuilder, low: Point, high: Point, colour: Colour) -> dict[str, list[Point]]:
    """Add an upright box without its bottom and return its panels by name."""
    panels = box_panels(low, high)
    for panel in panels.values():
        builder.whole(panel, colour)
    return panels


def box_panels(low: Point, high: Point) -> dict[str, list[Point]]:
    """The panels of a box by name: bottom left, bottom right, top right, top left, from outside."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    return {
        "rear": [(x0, y0, z0), (x0, y1, z0), (x0, y1, z1), (x0, y0, z1)],
        "front": [(x1, y1, z0), (x1, y0, z0), (x1, y0, z1), (x1, y1, z1)],
        "right": [(x0, y1, z0), (x1, y1, z0), (x1, y1, z1), (x0, y1, z1)],
        "left": [(x1, y0, z0), (x0, y0, z0), (x0, y0, z1), (x1, y0, z1)],
        "top": [(x0, y0, z1), (x0, y1, z1), (x1, y1, z1), (x1, y0, z1)],
    }
