"""The carriageway's lane and shape when bright spots, mirror images and blind moments come between."""

from dataclasses import replace

import numpy as np
import pytest
from driver_settings import ROBUST
from road_picture import RoadPicture

from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.perception.road.edge_tracker import RoadEdgeTracker
from vpf_sim.perception.road.hypotheses import CarriagewayHypotheses
from vpf_sim.perception.road.model import CURVATURES, seen_places, state_of
from vpf_sim.perception.road.state_filter import LaneFilter, Sightings, initial_covariance
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats

SPEED_MPS, RATE_HZ = 5.55, 20.0
CONFIG = ROBUST.road_edges
NUMBERS: Floats = np.arange(-2.0, 3.0)  # of the lines, the third of five is the centre


def test_bright_spots_do_not_bend_the_road_ahead() -> None:
    """Near, all lines are seen; far off, a tenth of them, among five times as many spots anywhere within reach."""
    rng = stream(31, "spots")
    forward: Floats = np.arange(4.0, 29.0, 0.5)
    truth = state_of(1.75, 0.0, 0.005, 3.5)
    tracked = LaneFilter(
        truth.copy(), initial_covariance(0.05, 0.005, 0.05, 0.001, CONFIG.filter), Camera(), CONFIG.filter
    )
    variance = np.full((len(NUMBERS), len(forward)), 0.02**2)
    bend = []
    for _ in range(300):
        tracked.predict(np.array([SPEED_MPS / RATE_HZ, 0.0, SPEED_MPS / RATE_HZ * 0.005 / (1.0 - 0.005 * 1.75)]))
        expected, right = (seen_places(state, NUMBERS, forward, Camera())[0] for state in (tracked.state, truth))
        near = np.broadcast_to(forward < 12.0, right.shape)
        spot = ~near & (rng.random(right.shape) < 0.5)
        stretch = np.repeat(rng.random((len(NUMBERS), 10)) < 0.1, 5, axis=1)  # of 2.5 m
        place = np.where(near | stretch, right, expected + rng.uniform(-0.5, 0.5, right.shape))
        tracked.correct(Sightings(NUMBERS, forward, place, variance, near | stretch | spot))
        bend.append(tracked.state[CURVATURES].copy())
    assert np.abs(np.array(bend) - 0.005).max() < 0.03


def test_a_lost_road_is_found_again_in_the_lane_in_which_it_was_left() -> None:
    """Lane 3, then nothing to see, then lines without an end on either side, which fit any lane."""
    camera = Camera()
    blank = np.full((camera.height_px, camera.width_px, 3), 100, np.uint8)
    known, endless = RoadPicture(camera), RoadPicture(camera, half_width_m=14.0)
    tracker = RoadEdgeTracker(camera, replace(ROBUST.road_edges, lost_sigma_m=0.06), RATE_HZ)
    for i in range(100):
        pose = known.pose(i * SPEED_MPS / RATE_HZ, -1.75, 0.0)
        frame = known.draw(pose, i) if i < 8 else blank if i < 90 else endless.draw(pose, i)
        edges = tracker.update(frame, grey(frame), pose, SPEED_MPS, 0.0, None)
        assert edges.right_m == pytest.approx(8.75, abs=0.3)
        if i == 89:
            assert edges.confidence == 0.0


def test_a_road_that_is_believed_elsewhere_is_given_up_and_found_again_in_its_lane() -> None:
    """For 0.75 s it is shown turned by 7 degrees, as a long mirror image may: the state is as sure as it is wrong."""
    camera, place = Camera(), -1.75
    road, tracker = RoadPicture(camera), RoadEdgeTracker(camera, ROBUST.road_edges, RATE_HZ)
    for i in range(60):
        pose = road.pose(i * SPEED_MPS / RATE_HZ, place, 0.0)
        frame = road.draw(pose + np.array([0.0, 0.0, 0.12 if i < 15 else 0.0]), i)
        edges = tracker.update(frame, grey(frame), pose, SPEED_MPS, 0.0, None)
        if i == 14:
            assert edges.heading_rad == pytest.approx(-0.12, abs=0.02)
    assert edges.heading_rad == pytest.approx(0.0, abs=0.01)
    assert edges.right_m == pytest.approx(7.0 - place, abs=0.1)
    assert edges.confidence > 0.5


@pytest.mark.parametrize("lane", [1, 2, 4])
def test_the_lane_is_known_where_water_hides_half_of_all_lines(lane: int) -> None:
    """Half of the rows of the frame, in strips, show the road without its lines but the left edge's."""
    camera = Camera()
    like = (106, 106, 107)  # the verge as the asphalt: the lines alone tell
    whole, bare = RoadPicture(camera, verge=like), RoadPicture(camera, verge=like, lane_width_m=100.0)
    hidden = np.repeat(stream(32, "water").random((25, 96)) < 0.5, 5, axis=1)
    tracker = RoadEdgeTracker(camera, ROBUST.road_edges, RATE_HZ)
    place = 7.0 - 3.5 * (lane - 0.5)
    for i in range(25):
        pose = whole.pose(i * SPEED_MPS / RATE_HZ, place, 0.0)
        frame = np.where(hidden[i][:, None, None], bare.draw(pose, i), whole.draw(pose, i))
        edges = tracker.update(frame, grey(frame), pose, SPEED_MPS, 0.0, None)
    assert edges.right_m == pytest.approx(7.0 - place, abs=0.3)


def test_a_lane_is_left_at_once_in_the_beginning_and_later_only_for_lasting_evidence() -> None:
    most = CONFIG.hypotheses.lasting.most
    assert CarriagewayHypotheses.start(4, 2, CONFIG.hypotheses).is_lasting(2)
    index = CarriagewayHypotheses.start(4, 2, CONFIG.hypotheses)
    assert not any(index.is_lasting(None) for _ in range(200))
    assert not any(index.is_lasting(1) for _ in range(most - 1))
    assert not index.is_lasting(2)
    assert not any(index.is_lasting(1) for _ in range(most - 1))
    assert index.is_lasting(1)
