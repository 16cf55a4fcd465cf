"""OpenDRIVE maps for tests: short texts, and where their curves run by fine steps, without the converter's formulas."""

import os
import xml.etree.ElementTree as ET
from collections.abc import Callable
from math import cos, sin
from pathlib import Path

import numpy as np
import pytest

from vpf_sim import scenarios
from vpf_sim.scenarios import Scenario
from vpf_sim.types import Floats

STEPS = 40_000  # of a curve's integral


def town04() -> Path:
    """CARLA's map; skips the test without the folder of shared data."""
    shared = os.environ.get("VPF_SIM_SHARED")
    if shared is None:
        pytest.skip("VPF_SIM_SHARED is not set: Town04.xodr is not at hand")
    return Path(shared) / "maps" / "Town04.xodr"


def point_on_lines_and_arcs(road: ET.Element, s: float, t: float) -> Floats:
    """(2,) m in our axes, OpenDRIVE's (s, t) on a road of lines and arcs: their y is to the left."""
    piece = [geometry for geometry in road.findall("planView/geometry") if float(geometry.get("s", 0)) <= s][-1]
    x, y, heading, start = (float(piece.get(key, 0)) for key in ("x", "y", "hdg", "s"))
    arc = piece.find("arc")
    curvature = 0.0 if arc is None else float(arc.get("curvature", 0))
    u = s - start
    if curvature == 0.0:
        x, y = x + u * cos(heading), y + u * sin(heading)
    else:
        x += (sin(heading + curvature * u) - sin(heading)) / curvature
        y -= (cos(heading + curvature * u) - cos(heading)) / curvature
    heading += curvature * u
    return np.array([x - t * sin(heading), -(y + t * cos(heading))])


class Curve:
    """A reference line in fine steps, from a pose (x, y, heading) in OpenDRIVE's axes."""

    def __init__(self, s: Floats, points: Floats, pose: tuple[float, float, float]) -> None:
        x, y, heading = pose
        turn = np.array([[cos(heading), sin(heading)], [-sin(heading), cos(heading)]])
        self.s, self.points = s, np.array([x, y]) + points @ turn

    def shifted(self, t: Callable[[Floats], Floats]) -> Floats:
        """(N, 2) m in our axes: the curve t(s) to its left."""
        step = np.gradient(self.points, self.s, axis=0)
        left = np.stack([-step[:, 1], step[:, 0]], axis=1) / np.hypot(*step.T)[:, None]
        return (self.points + t(self.s)[:, None] * left) * [1.0, -1.0]

    @property
    def end(self) -> tuple[float, float, float]:
        """The pose at its end."""
        (x, y), ahead = self.points[-1], 2.0 * (self.points[-1] - self.points[-2])
        ahead -= 0.5 * (self.points[-1] - self.points[-3])  # a difference of second order
        return float(x), float(y), float(np.arctan2(ahead[1], ahead[0]))


def of_curvature(curvature: Callable[[Floats], Floats], length_m: float, pose: tuple[float, float, float]) -> Curve:
    """A line, arc or spiral, integrated by the midpoint rule."""
    s = np.linspace(0.0, length_m, STEPS + 1)
    step = length_m / STEPS
    heading = np.concatenate([[0.0], np.cumsum(step * curvature(s[:-1] + step / 2.0))])
    middle = 0.5 * (heading[1:] + heading[:-1])
    moved = step * np.stack([np.cos(middle), np.sin(middle)], axis=1)
    return Curve(s, np.concatenate([np.zeros((1, 2)), np.cumsum(moved, axis=0)]), pose)


def of_points(along: Floats, left: Floats, length_m: float, pose: tuple[float, float, float]) -> Curve:
    """A polynomial's fine points up to a length, at equal steps of it."""
    points = np.stack([along, left], axis=1)
    distance = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    s = np.linspace(0.0, length_m, STEPS // 4 + 1)
    return Curve(s, np.stack([np.interp(s, distance, one) for one in points.T], axis=1), pose)


def geometry(shape: str, length_m: float, s: float = 0.0, pose: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> str:
    """A `<geometry>`; the shape is the element in it."""
    x, y, heading = pose
    return f'<geometry s="{s!r}" x="{x!r}" y="{y!r}" hdg="{heading!r}" length="{length_m!r}">{shape}</geometry>'


def lane(number: int, kind: str = "driving", width: str = 'a="3.5"', inside: str = "") -> str:
    """A `<lane>`; `inside` has its links and marks."""
    widths = "" if number == 0 else f"<width {width}/>"
    return f'<lane id="{number}" type="{kind}">{inside}{widths}</lane>'


def section(*lanes: str, s: float = 0.0) -> str:
    """A `<laneSection>` of lanes, sorted to their sides."""
    number = {one: int(ET.fromstring(one).get("id", 0)) for one in lanes}
    sides = {
        "left": [one for one in lanes if number[one] > 0],
        "center": ['<lane id="0" type="none"/>', *[one for one in lanes if number[one] == 0]][-1:],
        "right": [one for one in lanes if number[one] < 0],
    }
    inside = "".join(f"<{side}>{''.join(them)}</{side}>" for side, them in sides.items() if them)
    return f'<laneSection s="{s!r}">{inside}</laneSection>'


def road(name: str, geometries: str, lanes: str, links: str = "", more: str = "") -> str:
    """A `<road>`; `lanes` has offsets and sections, `links` its neighbours, `more` further attributes."""
    return (
        f'<road id="{name}" {more}><link>{links}</link><planView>{geometries}</planView><lanes>{lanes}</lanes></road>'
    )


def linked(way: str, name: str, contact: str = "start", kind: str = "road") -> str:
    """A link to a road or junction; `way` is predecessor or successor."""
    return f'<{way} elementType="{kind}" elementId="{name}" contactPoint="{contact}"/>'


def write_map(folder: Path, *elements: str) -> Path:
    """A map of roads and junctions."""
    path = folder / "map.xodr"
    path.write_text(f"<?xml version='1.0'?><OpenDRIVE><header/>{''.join(elements)}</OpenDRIVE>", "utf-8")
    return path


def write_scenario(folder: Path, keys: str, goal_m: float = 20.0, ego: str = "lane = 1") -> Path:
    """A scenario on the map of the folder, or of another path in `keys`."""
    file = "" if "opendrive" in keys else 'opendrive = "map.xodr"\n'
    path = folder / "scenario.toml"
    path.write_text(f"schema = 1\n[road]\n{file}{keys}\n[ego]\n{ego}\n[goal]\ns_m = {goal_m}\n", "utf-8")
    return path


def loaded(folder: Path, keys: str, *elements: str) -> Scenario:
    """The scenario with these keys of its road on a map of roads and junctions."""
    write_map(folder, *elements)
    scenario = scenarios.load(str(write_scenario(folder, keys)))
    assert isinstance(scenario, Scenario)
    return scenario
