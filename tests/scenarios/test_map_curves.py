"""Roads of OpenDRIVE maps follow the map's curves to a centimetre: each geometry, offsets, widths and rough digits."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import open_drive as xodr
import pytest

from vpf_sim.envs.centre_line import CentreLine
from vpf_sim.scenarios import Scenario
from vpf_sim.types import Floats

POSE = (-20.0, 35.0, 0.7)
TWO_WAY = xodr.section(*(xodr.lane(number) for number in (2, 1, 0, -1, -2)))
Made = tuple[str, float, xodr.Curve]  # shape, length, where it runs


def clothoid(first: float, last: float, length_m: float) -> Made:
    """A line, an arc or a spiral, from one curvature to another; to the left is positive."""
    shape = f'<spiral curvStart="{first}" curvEnd="{last}"/>'
    if first == last:
        shape = f'<arc curvature="{first}"/>' if first else "<line/>"
    return shape, length_m, xodr.of_curvature(lambda s: first + (last - first) * s / length_m, length_m, POSE)


def poly3() -> Made:
    """v(u), as long as the geometry says."""
    a, b, c, d, length_m = 0.0, 0.1, 0.004, -5e-5, 70.0
    u = np.linspace(0.0, length_m, 200_001)
    shape = f'<poly3 a="{a}" b="{b}" c="{c}" d="{d}"/>'
    return shape, length_m, xodr.of_points(u, a + u * (b + u * (c + u * d)), length_m, POSE)


def param_poly3(range_: str) -> Made:
    """u(p) and v(p), of p in [0, 1] or in metres up to the length."""
    p = np.linspace(0.0, 1.0, 200_001)
    along, left = 60.0 * p + 8.0 * p**2 - 6.0 * p**3, 12.0 * p**2 + 9.0 * p**3
    length_m = float(np.hypot(np.diff(along), np.diff(left)).sum())
    scale = 1.0 if range_ == "normalized" else length_m
    numbers = {"bU": 60.0 / scale, "cU": 8.0 / scale**2, "dU": -6.0 / scale**3, "aU": 0.0}
    numbers |= {"aV": 0.0, "bV": 0.0, "cV": 12.0 / scale**2, "dV": 9.0 / scale**3}
    text = " ".join(f'{key}="{value!r}"' for key, value in numbers.items())
    return f'<paramPoly3 pRange="{range_}" {text}/>', length_m, xodr.of_points(along, left, length_m, POSE)


SHAPES = {
    "line": clothoid(0.0, 0.0, 80.0),
    "arc": clothoid(-0.02, -0.02, 90.0),
    "spiral": clothoid(0.0, 0.02, 80.0),
    "spiral that begins in a bend": clothoid(0.025, -0.015, 80.0),
    "poly3": poly3(),
    "normalized paramPoly3": param_poly3("normalized"),
    "arcLength paramPoly3": param_poly3("arcLength"),
}


def assert_on(scenario: Scenario, lane: int, truth: Floats, ends_m: float = 0.01) -> None:
    """A lane's centre runs through all points of the truth, in order, and is as long."""
    line, points = CentreLine(scenario.road), truth[:: max(1, len(truth) // 300)]
    along, right = line.local(points)
    assert np.abs(right - scenario.road.lane_offset_m(lane)).max() < 0.01
    assert (np.diff(along) > 0.0).all()
    ends = line.local(truth[[0, -1]])[0]
    assert np.abs(ends - [0.0, line.length_m]).max() < ends_m


@pytest.mark.parametrize("direction", ["forward", "backward"])
@pytest.mark.parametrize("name", SHAPES)
def test_lanes_follow_each_kind_of_geometry(name: str, direction: str, tmp_path: Path) -> None:
    shape, length_m, curve = SHAPES[name]
    road = xodr.road("7", xodr.geometry(shape, length_m, pose=POSE), TWO_WAY)
    scenario = xodr.loaded(tmp_path, f'route = ["7"]\ndirection = "{direction}"', road)
    assert (scenario.road.lanes, scenario.road.lane_width_m) == (2, 3.5)
    for lane, t in ((1, 5.25), (2, 1.75)):
        side = -1.0 if direction == "forward" else 1.0
        truth = curve.shifted(lambda s, t=side * t: np.full(s.shape, t))  # type: ignore[misc]
        assert_on(scenario, lane, truth if direction == "forward" else truth[::-1])


def test_lines_and_arcs_stay_lines_and_arcs(tmp_path: Path) -> None:
    """An arc of 50 m radius to the left, driven 3.5 m to the right of it, has 53.5 m and is longer by as much."""
    road = xodr.road("7", xodr.geometry('<arc curvature="0.02"/>', 60.0, pose=POSE), TWO_WAY)
    (segment,) = xodr.loaded(tmp_path, 'route = ["7"]\ndirection = "forward"', road).road.segments
    assert segment.model_dump() == pytest.approx({"kind": "arc", "radius_m": -53.5, "length_m": 60.0 * 53.5 / 50.0})


def smooth(height: float, length_m: float) -> tuple[str, Callable[[Floats], Floats]]:
    """A cubic from 0 to a height without a slope at its ends: text and function."""
    c, d = 3.0 * height / length_m**2, -2.0 * height / length_m**3
    return f'a="0" b="0" c="{c!r}" d="{d!r}"', lambda s: s**2 * (c + d * s)


@pytest.mark.parametrize("name", ["line", "arc", "poly3"])
def test_lanes_follow_the_lane_offset(name: str, tmp_path: Path) -> None:
    shape, length_m, curve = SHAPES[name]
    text, offset = smooth(3.0, length_m)
    lanes = f'<laneOffset s="0" {text}/>{TWO_WAY}'
    scenario = xodr.loaded(
        tmp_path,
        'route = ["7"]\ndirection = "forward"',
        xodr.road("7", xodr.geometry(shape, length_m, pose=POSE), lanes),
    )
    assert_on(scenario, 1, curve.shifted(lambda s: offset(s) - 5.25))


def test_lanes_follow_the_widths_of_lanes_between_them_and_the_reference_line(tmp_path: Path) -> None:
    shape, length_m, curve = SHAPES["arc"]
    text, width = smooth(2.0, length_m)
    lanes = xodr.section(xodr.lane(-1, "shoulder", text), xodr.lane(-2), xodr.lane(-3))
    scenario = xodr.loaded(tmp_path, 'route = ["7"]', xodr.road("7", xodr.geometry(shape, length_m, pose=POSE), lanes))
    assert_on(scenario, 2, curve.shifted(lambda s: -width(s) - 1.75))


def test_a_slight_corner_of_the_offset_is_rounded(tmp_path: Path) -> None:
    """A taper with a slope of 1 %. The road's end is square to the reference line, so 1.75 cm askew to the lanes."""
    shape, length_m, curve = clothoid(0.0, 0.0, 100.0)
    lanes = f'<laneOffset s="0" a="0"/><laneOffset s="50" a="0" b="0.01"/>{TWO_WAY}'
    road = xodr.road("7", xodr.geometry(shape, length_m, pose=POSE), lanes)
    scenario = xodr.loaded(tmp_path, 'route = ["7"]\ndirection = "forward"', road)
    assert_on(scenario, 2, curve.shifted(lambda s: 0.01 * np.maximum(s - 50.0, 0.0) - 1.75), ends_m=0.02)


def test_spirals_that_begin_with_another_curvature_turn_as_the_map_does(tmp_path: Path) -> None:
    """Thirty spirals of 4 m, from a bend to the right to one to the left: the curvature jumps by 0.16 1/m between."""
    pose, text, truth = POSE, "", []
    for i in range(30):
        curve = xodr.of_curvature(lambda s: 0.04 * s - 0.08, 4.0, pose)
        text += xodr.geometry('<spiral curvStart="-0.08" curvEnd="0.08"/>', 4.0, 4.0 * i, pose)
        truth.append(curve.shifted(lambda s: np.full(s.shape, -1.75))[100:-100:2000])
        pose = curve.end
    scenario = xodr.loaded(tmp_path, 'route = ["7"]\ndirection = "forward"', xodr.road("7", text, TWO_WAY))
    _, right = CentreLine(scenario.road).local(np.concatenate(truth))
    assert np.abs(right - scenario.road.lane_offset_m(2)).max() < 0.01


def test_errors_of_rounded_digits_do_not_add_up(tmp_path: Path) -> None:
    """Twenty arcs and lines whose curvature has three digits: each ends 5 mm and 0.2 mrad off, to the same side."""
    pose, text, truth = POSE, "", []
    for i in range(20):
        rounded = (0.004, 0.0, -0.006)[i % 3]
        curve = xodr.of_curvature(lambda s, k=rounded + 4e-6: np.full(s.shape, k), 50.0, pose)  # type: ignore[misc]
        text += xodr.geometry(f'<arc curvature="{rounded}"/>', 50.0, 50.0 * i, pose)
        truth.append(curve.shifted(lambda s: np.full(s.shape, -1.75))[100:-100:400])
        pose = curve.end
    scenario = xodr.loaded(tmp_path, 'route = ["7"]', xodr.road("7", text, xodr.section(xodr.lane(-1))))
    _, right = CentreLine(scenario.road).local(np.concatenate(truth))
    assert np.abs(right).max() < 0.01


def test_a_map_far_from_its_origin_begins_at_ours(tmp_path: Path) -> None:
    road = xodr.road(
        "7", xodr.geometry("<line/>", 60.0, pose=(690_000.0, 5_330_000.0, 0.0)), xodr.section(xodr.lane(-1))
    )
    assert xodr.loaded(tmp_path, 'route = ["7"]', road).road.start_m == (0.0, 0.0)
