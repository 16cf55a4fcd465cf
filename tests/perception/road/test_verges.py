"""Where the surface of a road ends: found beside its lines, and followed where these end."""

from dataclasses import replace

import numpy as np
import pytest
from driver_settings import unwrap
from road_picture import SPEED_MPS, RoadPicture, follow

from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.perception.road.edge_tracker import RoadEdgeTracker
from vpf_sim.perception.road.road_settings import VergeConfig
from vpf_sim.perception.road.verges import step
from vpf_sim.planning import variant
from vpf_sim.types import Camera, Obstacles, RoadEdges

RATE_HZ = 10.0
VARIANT = variant.load("verges")
VERGES = unwrap(VARIANT.verges)
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


def test_without_them_the_road_is_lost_there() -> None:
    assert beyond_the_paint(RoadPicture(Camera(), 0.015), None).lane_confidence == 0.0


def test_a_verge_that_looks_like_the_road_is_none() -> None:
    assert beyond_the_paint(RoadPicture(Camera(), 0.0, verge=(106, 106, 107)), VERGES).lane_confidence == 0.0


def test_where_an_obstacle_hides_all_of_the_road_there_is_no_step() -> None:
    """The body of a vehicle just ahead."""
    tracker = RoadEdgeTracker(Camera(), VARIANT.road_edges, RATE_HZ, VERGES)
    frame = RoadPicture(Camera()).draw(np.zeros(3))
    sides = (np.array([value]) for value in (2.5, -20.0, 20.0, 0.1, np.inf))
    wall = Obstacles(*sides, np.array([1]))
    edges = tracker.update(frame, grey(frame), np.zeros(3), SPEED_MPS, 0.0, wall)
    assert edges.lane_confidence == 0.0


@pytest.mark.parametrize("change", [(0, 40, 0), (-30, 0, 0), (20, 20, 20)])
def test_a_step_is_as_high_as_the_colours_differ_and_where_they_change(change: tuple[int, int, int]) -> None:
    patch = np.full((3, 60, 3), 100, np.uint8)
    patch[:, 30:] = np.array((100, 100, 100)) + change
    found = step(patch, 4)
    assert found.max() == pytest.approx(np.abs(change).max(), rel=0.25)
    assert np.abs(np.flatnonzero(found[1] == found[1].max()).mean() - 29.5) <= 1.0
    assert not found[:, :20].any()
    assert not found[:, 40:].any()


@pytest.mark.parametrize("columns", [1, 2, 3])
def test_a_painted_line_is_no_step(columns: int) -> None:
    patch = np.full((3, 60, 3), 100, np.uint8)
    patch[:, 30 : 30 + columns] = 240
    assert not step(patch, 4).any()
