"""Where the surface of a road ends: found beside its lines, and followed where these end."""

from dataclasses import replace

import numpy as np
import pytest
from driver_settings import ROBUST, unwrap
from made_obstacles import obstacles
from road_picture import SPEED_MPS, RoadPicture, follow

from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.perception.road.birds_eye import BirdsEye
from vpf_sim.perception.road.edge_tracker import RoadEdgeTracker
from vpf_sim.perception.road.markings import RidgeMap, comb
from vpf_sim.perception.road.model import VERGE, state_of
from vpf_sim.perception.road.road_settings import VergeConfig
from vpf_sim.perception.road.state_filter import LaneFilter, Sightings, initial_covariance
from vpf_sim.perception.road.verges import VergeMatcher, step
from vpf_sim.types import Camera, Floats, RoadEdges

RATE_HZ = 10.0
VERGES = unwrap(ROBUST.verges)
PAINTED_M, UNPAINTED_M = 15.0, 40.0


def beyond_the_paint(picture: RoadPicture, verges: VergeConfig | None) -> RoadEdges:
    """What is seen in the lane right of the centre, long after the last paint has passed."""
    frames = round((PAINTED_M + UNPAINTED_M) / SPEED_MPS * RATE_HZ)
    *_, (last, _) = follow(replace(picture, paint_ends_m=PAINTED_M), 1.75, 0.0, frames, RATE_HZ, verges)
    return last


@pytest.mark.parametrize(("curvature", "verge"), [(0.0, (88, 100, 52)), (0.015, (150, 130, 90)), (-0.01, (60, 60, 62))])
def test_where_the_paint_ends_the_verges_show_the_road(curvature: float, verge: tuple[int, int, int]) -> None:
    edges = beyond_the_paint(RoadPicture(Camera(), curvature, verge), VERGES)
    assert (edges.left_m, edges.right_m) == pytest.approx((-8.75, 5.25), abs=0.3)
    assert edges.curvature_per_m == pytest.approx(curvature / (1.0 - 1.75 * curvature), abs=0.002)
    assert edges.lane_confidence > 0.5


def test_the_verges_are_followed_while_paint_is_searched_in_every_frame() -> None:
    """At two frames a second."""
    picture = RoadPicture(Camera(), paint_ends_m=PAINTED_M)
    *_, (last, _) = follow(picture, 1.75, 0.0, 120, 2.0, VERGES)
    assert (last.left_m, last.right_m) == pytest.approx((-8.75, 5.25), abs=0.3)
    assert last.lane_confidence > 0.5


def test_without_them_the_road_is_lost_there() -> None:
    assert beyond_the_paint(RoadPicture(Camera(), 0.015), None).lane_confidence == 0.0


def test_a_verge_that_looks_like_the_road_is_none() -> None:
    assert beyond_the_paint(RoadPicture(Camera(), 0.0, verge=(106, 106, 107)), VERGES).lane_confidence == 0.0


def test_where_an_obstacle_hides_all_of_the_road_there_is_no_step() -> None:
    """The body of a vehicle just ahead."""
    tracker = RoadEdgeTracker(Camera(), ROBUST.road_edges, RATE_HZ, VERGES)
    frame = RoadPicture(Camera()).draw(np.zeros(3))
    wall = obstacles((2.5, -20.0, 20.0), sigma_m=0.1)
    edges = tracker.update(frame, grey(frame), np.zeros(3), SPEED_MPS, 0.0, wall)
    assert edges.lane_confidence == 0.0
    matcher = VergeMatcher(Camera(), ROBUST.road_edges, VERGES)
    assert matcher.steps(frame, None, 0.0).visible.any()
    assert not matcher.steps(frame, wall, 0.0).visible.any()


def test_verges_without_paint_start_no_road() -> None:
    """Two verges leave open in which lane the car is."""
    *_, (last, _) = follow(RoadPicture(Camera(), paint_ends_m=-np.inf), 1.75, 0.0, 30, RATE_HZ, VERGES)
    assert last.lane_confidence == 0.0


def test_paint_that_lies_elsewhere_after_a_road_without_paint_is_found() -> None:
    picture = RoadPicture(Camera(), paint_ends_m=PAINTED_M)
    moved = RoadPicture(Camera(), paint_aside_m=1.2)
    tracker = RoadEdgeTracker(picture.camera, ROBUST.road_edges, RATE_HZ, VERGES)
    for i in range(100):
        pose = picture.pose(i * SPEED_MPS / RATE_HZ, 1.75, 0.0)
        frame = (picture if i < 60 else moved).draw(pose, i)
        edges = tracker.update(frame, grey(frame), pose, SPEED_MPS, 0.0, None)
        if i == 59:
            assert edges.lane_m == pytest.approx(0.0, abs=0.2)
    assert edges.lane_m % 3.5 == pytest.approx(1.2, abs=0.1)


def tracked_road(place_sigma_m: float) -> LaneFilter:
    """A straight road, the pose in the middle of the lane right of line 0."""
    config = ROBUST.road_edges.filter
    return LaneFilter(
        state_of(1.75, 0.0, 0.0, 3.5), initial_covariance(place_sigma_m, 0.01, 0.05, 0.001, config), Camera(), config
    )


def lines_seen(aside_m: float) -> Sightings:
    """The two lines beside the pose, `aside_m` right of where the tracked road has them."""
    forward_m: Floats = np.arange(4.0, 20.0, 0.5)
    right_m = np.repeat([[-1.75], [1.75]], len(forward_m), axis=1) + aside_m
    return Sightings(np.array([0.0, 1.0]), forward_m, right_m, np.full(right_m.shape, 1e-4), right_m < np.inf)


def test_a_verge_keeps_its_distance_from_the_car_when_lines_correct_the_place() -> None:
    tracked = tracked_road(0.3)
    tracked.add_verge(np.inf, 6.0, 0.05, 1.0)
    tracked.correct(lines_seen(0.2))
    assert tracked.state[0] == pytest.approx(1.55, abs=0.03)
    assert tracked.state[VERGE[np.inf]] == pytest.approx(5.8, abs=0.03)


def test_a_verge_that_is_dropped_is_known_no_more() -> None:
    tracked = tracked_road(0.3)
    tracked.add_verge(np.inf, 6.0, 0.05, 1.0)
    tracked.drop_verge(np.inf)
    tracked.correct(lines_seen(0.2))
    assert not tracked.verges
    assert tracked.state[VERGE[np.inf]] == pytest.approx(6.0)


@pytest.mark.parametrize(("asphalt", "kept"), [((88, 100, 52), True), ((106, 106, 107), False)], ids=["grass", "none"])
def test_a_verge_is_forgotten_where_the_surface_goes_on(asphalt: tuple[int, int, int], kept: bool) -> None:
    matcher = VergeMatcher(Camera(), ROBUST.road_edges, VERGES)
    picture = RoadPicture(Camera(), verge=asphalt)
    tracked = tracked_road(0.05)
    tracked.add_verge(np.inf, 7.5, 0.05, 1.0)
    for i in range(8):
        matcher.judge(tracked, matcher.steps(picture.draw(picture.pose(2.0 * i, 1.75, 0.0), i), None, 0.0))
    assert (tracked.verges.get(np.inf, 0.0) > VERGES.clear_share) is kept
    assert (np.inf in tracked.verges) is kept


def test_the_verges_outweigh_a_mirror_image_that_lies_askew() -> None:
    """The only thing bright is an image at 11 degrees; the surface ends left and right of a straight road."""
    road = ROBUST.road_edges
    lines, sides = BirdsEye(Camera(), road.patch), BirdsEye(Camera(), road.verge_patch(VERGES.column_m))
    askew_m = 1.0 + np.tan(np.radians(11.0)) * lines.forward_m[:, None]
    image = np.where(np.abs(lines.right_m - askew_m) < 0.08, 200, 0).astype(np.uint8)
    steps = np.repeat((np.abs(np.abs(sides.right_m) - 5.0) < 0.15)[None], len(sides.forward_m), axis=0) * np.uint8(200)
    ridges, verges = (RidgeMap(v, r, 10.0, v.visible, 0.15) for v, r in ((lines, image), (sides, steps)))
    alone = comb(ridges, np.array([3.5]), 3.5, road.comb)
    found = comb(ridges, np.array([3.5]), 3.5, road.comb, steps=verges, beside_m=VERGES.beside_m)
    assert np.degrees(alone.heading) > 5.0
    assert np.degrees(found.heading) == pytest.approx(0.0, abs=1.0)
    assert found.painted < road.least_comb < found.score


@pytest.mark.parametrize("change", [(0, 40, 0), (-30, 0, 0), (20, 20, 20)])
def test_a_step_is_as_high_as_the_colours_differ_and_where_they_change(change: tuple[int, int, int]) -> None:
    patch = np.full((3, 60, 3), 100, np.uint8)
    patch[:, 30:] = np.array((100, 100, 100)) + change
    found = step(patch, 5)
    assert found.max() == pytest.approx(np.abs(change).max(), rel=0.25)
    assert np.abs(np.flatnonzero(found[1] == found[1].max()).mean() - 29.5) <= 1.0
    assert not found[:, :18].any()
    assert not found[:, 42:].any()


def test_a_step_lies_as_far_from_either_side() -> None:
    patch = np.full((3, 60, 3), 100, np.uint8)
    patch[:, 30:] = 140
    assert np.array_equal(step(patch[:, ::-1], 5), step(patch, 5)[:, ::-1])


@pytest.mark.parametrize("slope", [0.0, 1.0], ids=["even", "lit from one side"])
@pytest.mark.parametrize("columns", [1, 2, 3])
def test_a_painted_line_is_no_step(columns: int, slope: float) -> None:
    patch = np.repeat(60.0 + slope * np.arange(60.0)[None, :, None], 3, axis=0).repeat(3, axis=2).astype(np.uint8)
    patch[:, 30 : 30 + columns] = 250
    assert step(patch, 5)[:, 20:40].max() <= 8.0 * slope
