"""Roads whose lanes are wider than usual, as a recording may have them: ramps, drawn in closed form."""

import numpy as np
import pytest
from driver_settings import ROBUST
from road_picture import RoadPicture

from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.perception.road.edge_tracker import RoadEdgeTracker
from vpf_sim.perception.road.road_settings import RoadEdgeConfig
from vpf_sim.replay import lane_height
from vpf_sim.replay.open_loop_driver import any_road
from vpf_sim.replay.recording import Frame
from vpf_sim.types import Camera, RoadEdges

USUAL = ROBUST.road_edges
ANY = any_road(USUAL)
CAMERA = Camera(forward_m=0.0)
LOOKS, RATE_HZ, SPEED_MPS = 6, 20.0, 10.0  # which lines are the edges is judged at the fifth look


def seen(config: RoadEdgeConfig, picture: RoadPicture, right_m: float) -> RoadEdges:
    """After a few looks from a car that drives along the road."""
    tracker = RoadEdgeTracker(picture.camera, config, RATE_HZ)
    road: RoadEdges | None = None
    for k in range(LOOKS):
        pose = picture.pose(k * SPEED_MPS / RATE_HZ, right_m, 0.0)
        image = picture.draw(pose, k)
        road = tracker.update(image, grey(image), pose, SPEED_MPS, 0.0, None)
    assert road is not None
    return road


def ramp(width_m: float, curvature_per_m: float = 0.0) -> RoadPicture:
    """One lane between two solid lines."""
    return RoadPicture(CAMERA, curvature_per_m, half_width_m=0.5 * width_m, lane_width_m=width_m)


@pytest.mark.parametrize(("width_m", "curvature_per_m"), [(4.5, 0.0), (5.25, 0.01), (6.0, 0.0)])
def test_the_lines_of_a_ramp_are_its_lane(width_m: float, curvature_per_m: float) -> None:
    road = seen(ANY, ramp(width_m, curvature_per_m), 0.4)
    assert road.lane_confidence >= 0.5
    assert road.lane_width_m == pytest.approx(width_m, abs=0.1)
    assert road.lane_m == pytest.approx(-0.4, abs=0.1)


def test_lanes_of_the_usual_width_are_no_wider_for_it() -> None:
    for config in (USUAL, ANY):
        road = seen(config, RoadPicture(CAMERA), 1.75)
        assert road.lane_width_m == pytest.approx(3.5, abs=0.05)
        assert road.lane_m == pytest.approx(0.0, abs=0.1)


def test_two_lines_two_lanes_apart_tell_no_height() -> None:
    """With none between, they are those of one wide lane."""
    picture = RoadPicture(Camera(forward_m=0.0, height_m=1.4), half_width_m=3.5, lane_width_m=7.0)
    times = np.arange(12.0)
    frames = [Frame(k, picture.draw(picture.pose(10.0 * k, 0.0, 0.0), k)) for k in range(3)]
    assert lane_height.height_m(iter(frames), picture.camera, times[:3], USUAL) is None
