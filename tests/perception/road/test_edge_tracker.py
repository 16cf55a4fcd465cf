"""The carriageway from the camera, against roads drawn in closed form."""

from dataclasses import replace
from math import radians
from typing import Any

import cv2
import numpy as np
import pytest
from driver_settings import ROBUST
from road_picture import SPEED_MPS, RoadPicture, follow

from vpf_sim.envs.camera import Rig, weather
from vpf_sim.envs.camera.renderer import Renderer
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.geometry import distort, vehicle_from_world, world_from_vehicle
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.perception.road.birds_eye import BirdsEye
from vpf_sim.perception.road.edge_tracker import RoadEdgeTracker
from vpf_sim.perception.road.hypotheses import CarriagewayHypotheses
from vpf_sim.perception.road.line_matcher import BY_LINES
from vpf_sim.perception.road.model import moved, seen_lines, seen_places, state_of
from vpf_sim.perception.road.obstacle_mask import hidden_by
from vpf_sim.types import Bools, Camera, Floats, Obstacles, RoadEdges

KITTI = Camera(1226, 370, 707.1, 707.1, 601.9, 183.1, height_m=1.65, forward_m=1.0)
BEND = np.array([1.2, 0.1, 0.004, 0.006, 0.008, 0.01, 3.5, 0.0, -3.0, 8.0])


def places(state: Floats, numbers: Floats, forward_m: Floats) -> Floats:
    """(L, R) m, lateral places of the road's lines."""
    return seen_places(state, numbers, forward_m, Camera())[0]


def test_the_derivative_of_the_lines_is_that_of_finite_differences() -> None:
    numbers, forward = np.array([-np.inf, -2.0, 0.0, 1.5, np.inf]), np.arange(4.0, 28.0, 3.0)
    _, jacobian, _ = seen_lines(BEND, numbers, forward, Camera())
    for i, step in enumerate(np.eye(len(BEND)) * 1e-6):
        numeric = (places(BEND + step, numbers, forward) - places(BEND - step, numbers, forward)) / 2e-6
        assert np.abs(jacobian[..., i] - numeric).max() < 0.12 * np.abs(numeric).max()


@pytest.mark.parametrize("curvature", [0.0, 0.01, -0.0125])
def test_lines_are_circles_where_the_curvature_is_constant(curvature: float) -> None:
    picture = RoadPicture(Camera(), curvature)
    state = state_of(1.3, -0.07, curvature, 3.5)
    numbers, forward = np.array([-1.0, 2.0]), np.linspace(5.0, 28.0, 12)
    right, reached = seen_places(state, numbers, forward, Camera())
    assert reached.all()
    pose = picture.pose(0.0, 1.3, 0.07)
    places = world_from_vehicle(np.stack([np.broadcast_to(forward, right.shape), right], axis=-1), pose)
    assert np.abs(picture.local(places)[1] - 3.5 * numbers[:, None]).max() < 2e-3


def test_a_line_that_bends_back_is_seen_where_it_crosses_a_row_first() -> None:
    radius, forward = np.array([[16.0], [12.5]]), np.arange(4.0, 29.0)
    right, reached = seen_places(state_of(0.0, 0.0, 1.0 / 16.0, 3.5), np.array([0.0, 1.0]), forward, Camera())
    assert np.array_equal(reached, forward < radius)
    circle = 16.0 - np.sqrt(np.maximum(radius**2 - forward**2, 0.0))
    near = forward < 0.9 * radius
    assert np.abs(right - circle)[near].max() < 0.03


def test_a_road_that_the_vehicle_has_moved_along_is_the_same_road() -> None:
    step = np.array([0.4, 0.05, 0.03])
    after, _ = moved(BEND, step)
    numbers, forward = np.array([-1.0, 0.0, 2.0]), np.linspace(5.0, 26.0, 40)
    for number, right in zip(numbers, places(BEND, numbers, forward), strict=True):
        seen = vehicle_from_world(np.stack([forward, right], axis=-1), step)
        again = places(after, np.array([number]), seen[:, 0])
        assert np.abs(again[0] - seen[:, 1]).max() < 0.01


@pytest.mark.parametrize("curvature", [0.0, 0.01, -0.01])
@pytest.mark.parametrize(("place", "heading_deg"), [(2.25, 3.0), (1.3, -4.0)])
def test_the_edges_are_found_and_followed(curvature: float, place: float, heading_deg: float) -> None:
    heading = radians(heading_deg) if curvature == 0.0 else 0.0
    seen = list(follow(RoadPicture(Camera(), curvature), place, heading, 16))
    errors = np.array([edges.right_m - (7.0 - right) for edges, right in seen])
    assert abs(errors[0]) < 0.25
    assert np.abs(errors[8:]).max() < 0.06
    last, right = seen[-1]
    assert last.left_m == pytest.approx(-7.0 - right, abs=0.06)
    assert abs(last.heading_rad + heading) < radians(0.6)
    assert last.curvature_per_m == pytest.approx(curvature / (1.0 - curvature * right), abs=1.5e-3)
    assert last.confidence > 0.9
    assert last.sigma_m < 0.05


@pytest.mark.parametrize("radius_m", [35.0, -24.0])
def test_tight_bends_are_followed(radius_m: float) -> None:
    """As of a side street; the middle of the second lane from the right."""
    seen = list(follow(RoadPicture(Camera(), 1.0 / radius_m), 1.75, 0.0, 60))
    assert max(abs(edges.right_m - 5.25) for edges, _ in seen[30:]) < 0.1
    assert max(abs(edges.left_m + 8.75) for edges, _ in seen[30:]) < 0.2
    curvature = 1.0 / (radius_m - 1.75)
    assert seen[-1][0].curvature_per_m == pytest.approx(curvature, rel=0.1)
    assert seen[-1][0].confidence > 0.5


@pytest.mark.parametrize("lane", [1, 3, 4])
def test_the_lane_is_known_by_the_edges_and_not_by_habit(lane: int) -> None:
    place = 7.0 - 3.5 * (lane - 0.5)
    *_, (last, _) = follow(RoadPicture(Camera()), place + 0.2, 0.02, 5)
    assert last.right_m == pytest.approx(7.0 - place - 0.2, abs=0.2)


@pytest.mark.parametrize(
    ("lanes", "width", "lane", "curvature"),
    [
        *((1, 3.5, 1, 0.0), (2, 3.0, 1, 0.0), (2, 3.75, 2, 0.008), (3, 3.25, 3, 0.0)),
        *((4, 3.0, 1, 0.008), (5, 3.5, 3, 0.0), (6, 3.6, 1, 0.0), (6, 3.6, 1, 0.008)),
    ],
)
def test_the_number_of_lanes_and_their_width_are_seen(lanes: int, width: float, lane: int, curvature: float) -> None:
    """An edge is known where the patch of road that is looked at shows it."""
    half = 0.5 * lanes * width
    place = half - (lane - 0.5) * width + 0.2
    *_, (last, _) = follow(RoadPicture(Camera(), curvature, half_width_m=half, lane_width_m=width), place, 0.0, 36)
    seen_m = ROBUST.road_edges.half_width_m - 0.5
    for edge, truth in ((last.left_m, -half - place), (last.right_m, half - place)):
        assert edge == pytest.approx(truth, abs=0.1) or abs(truth) > seen_m
    assert last.lane_m == pytest.approx(-0.2, abs=0.06)


@pytest.mark.parametrize("verge", [(200, 180, 120), (60, 60, 62), (106, 106, 107)], ids=["sand", "dark", "as asphalt"])
def test_the_verge_may_have_any_colour(verge: tuple[int, int, int]) -> None:
    *_, (last, _) = follow(RoadPicture(Camera(), verge=verge), -1.75, 0.0, 5)
    assert last.right_m == pytest.approx(8.75, abs=0.2)


def test_another_camera_at_another_rate() -> None:
    *_, (last, _) = follow(RoadPicture(KITTI), 1.6, 0.01, 12, rate_hz=10.0)
    assert last.right_m == pytest.approx(7.0 - 1.6 - 11 * SPEED_MPS / 10.0 * np.tan(0.01), abs=0.08)


def test_hidden_lines_are_bridged_by_own_motion_and_the_doubt_grows() -> None:
    camera = Camera()
    picture, tracker = RoadPicture(camera, 0.01), RoadEdgeTracker(camera, ROBUST.road_edges, 20.0)
    blank = np.full((camera.height_px, camera.width_px, 3), 100, np.uint8)
    result: list[RoadEdges] = []
    for i in range(52):
        pose = picture.pose(i * SPEED_MPS / 20.0, 1.75, 0.0)
        frame = picture.draw(pose, i) if i < 16 else blank
        result.append(tracker.update(frame, grey(frame), pose, SPEED_MPS, 0.0, None))
    assert abs(result[-1].right_m - 5.25) < 0.35  # after 10 m unseen
    assert result[-1].sigma_m > result[15].sigma_m
    assert result[-1].confidence < result[15].confidence


def test_a_road_that_was_lost_by_a_wrong_yaw_is_found_in_the_end() -> None:
    """From 8 m on the vehicle believes that it has turned by 30 deg: where the road should be then, no line ever is."""
    picture, turn = RoadPicture(Camera()), radians(30.0)
    tracker = RoadEdgeTracker(picture.camera, ROBUST.road_edges, 10.0)
    for i in range(80):
        along = 0.5 * i
        frame = picture.draw(picture.pose(along, 1.75, 0.0), i)
        pose = np.array([8.0 + (along - 8.0) * np.cos(turn), (along - 8.0) * np.sin(turn), turn])
        pose = pose if along > 8.0 else np.array([along, 0.0, 0.0])
        edges = tracker.update(frame, grey(frame), pose, 5.0, 0.0, None)
    assert edges.right_m == pytest.approx(5.25, abs=0.1)
    assert abs(edges.heading_rad) < radians(1.0)


@pytest.mark.parametrize(("off_rad", "found"), [(0.03, True), (0.1, False)])
def test_where_a_road_is_known_a_guess_whose_lines_lead_far_from_it_is_none(off_rad: float, found: bool) -> None:
    """Where the lines are seen at all about a guess, the looks that settle it turn it to where they lead."""
    picture = RoadPicture(Camera())
    tracker = RoadEdgeTracker(picture.camera, ROBUST.road_edges, 20.0)
    pose = picture.pose(0.0, 1.75, 0.0)
    frame = picture.draw(pose)
    tracker.update(frame, grey(frame), pose, SPEED_MPS, 0.0, None)
    features = tracker.matcher.features(frame, grey(frame), None, 0.0)
    guess = state_of(1.75 - 5.0 * off_rad, off_rad, 0.0, 3.5)
    settled = tracker.settled(guess, features, tracker.config.first_guess.sigma_m, BY_LINES)
    assert (settled is not None) == found
    if settled is not None:
        assert settled.state[1] == pytest.approx(0.0, abs=0.01)


def test_without_any_line_it_is_the_likely_lane_and_says_so() -> None:
    camera = Camera()
    blank = np.full((camera.height_px, camera.width_px, 3), 100, np.uint8)
    tracker = RoadEdgeTracker(camera, ROBUST.road_edges, 60.0)
    edges = tracker.update(blank, grey(blank), np.zeros(3), 5.0, 0.1, None)
    assert (edges.left_m, edges.right_m, edges.heading_rad) == (-8.75, 5.25, 0.0)
    assert edges.curvature_per_m == pytest.approx(0.02)
    assert edges.confidence == 0.0


def test_two_lines_are_no_four_lane_road() -> None:
    """By the lines alone: verges make the course certain, and with it the lanes, of which nothing is seen."""
    *_, (last, _) = follow(RoadPicture(Camera(), lane_width_m=14.0), 1.75, 0.0, 5, verges=None)
    assert last.confidence < 0.5


def test_bright_bars_on_a_known_body_do_not_pull_the_lines() -> None:
    camera = Camera()
    picture = RoadPicture(camera)
    body = Obstacles(*(np.array([x]) for x in (9.0, -1.0, 3.2, 0.1, 2.0)), identity=np.array([1]))
    tracker = RoadEdgeTracker(camera, ROBUST.road_edges, 20.0)
    for i in range(12):
        pose = picture.pose(0.05 * i, 1.75, 0.0)
        frame = picture.draw(pose, i)
        cv2.rectangle(frame, (320 - 40, 180), (320 + 124, 290), (60, 60, 60), -1)
        cv2.rectangle(frame, (320 + 76, 180), (320 + 84, 290), (220, 220, 220), -1)
        edges = tracker.update(frame, grey(frame), pose, 1.0, 0.0, body)
    assert edges.right_m == pytest.approx(5.25, abs=0.06)


@pytest.mark.parametrize("scenario", ["curve-right", "slalom"])
def test_rendered_frames_meet_the_target(scenario: str) -> None:
    """0.03 m in the median and 0.10 m at the 95th percentile, 10 m ahead, on a course that weaves."""
    env = FourLane(scenario=scenario)
    env.reset(seed=5)
    centre, half = env.road.network.centre, env.road.network.half_width_m
    renderer = Renderer(env.road, Rig(env.camera), weather.load("clear"), 5)
    tracker = RoadEdgeTracker(env.camera, ROBUST.road_edges, 10.0)
    start_s, start_lateral = centre.local_at(*env.ego.position)
    errors = []
    for i in range(90):
        s = start_s + 0.8 * i
        lateral = start_lateral + np.sin(s / 9.0) - np.sin(start_s / 9.0)
        slope = np.cos(s / 9.0) / 9.0 / (1.0 - lateral * centre.curvature_at(s))
        heading = centre.heading_at(s) + np.arctan(slope)
        env.ego.position, env.ego.heading = np.array(centre.position_at(s, lateral)), heading
        frame = renderer.render(env.ego, 0.1 * i)
        pose = np.array([*env.ego.position, heading])
        seen = tracker.update(frame, grey(frame), pose, 8.0, 0.0, None)
        ahead = env.ego.position + 10.0 * np.array([np.cos(heading), np.sin(heading)])
        shift = 10.0 * np.tan(seen.heading_rad) + 50.0 * seen.curvature_per_m / np.cos(seen.heading_rad) ** 3
        across = (seen.right_m / np.cos(seen.heading_rad) + shift) * np.cos(
            seen.heading_rad + 10.0 * seen.curvature_per_m
        )
        errors.append(across - (half - centre.local_at(*ahead)[1]))
    size = np.abs(errors)
    assert np.median(size) <= 0.03
    assert np.percentile(size, 95) <= 0.10


def test_distortion_is_that_of_opencv() -> None:
    camera = Camera(k1=-0.17, k2=0.02)
    ray: Floats = np.array([[0.3, 0.2, 1.0], [-0.8, 0.5, 1.0]])
    matrix = np.array([[320.0, 0.0, 319.5], [0.0, 320.0, 239.5], [0.0, 0.0, 1.0]])
    expected, _ = cv2.projectPoints(ray, np.zeros(3), np.zeros(3), matrix, np.array([-0.17, 0.02, 0.0, 0.0]))
    pinhole = ray[:, :2] * 320.0 + np.array([319.5, 239.5])
    assert np.allclose(distort(camera, pinhole), expected[:, 0])


@pytest.mark.parametrize(("wrong", "says"), [({"lanes": 0}, "lanes"), ({"likely_lane": 5}, r"1 \.\. 4, got 5")])
def test_a_nonsense_configuration_is_refused(wrong: dict[str, float], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        replace(ROBUST.road_edges, **wrong)  # type: ignore[arg-type]


def test_a_body_that_was_passed_and_is_behind_us_hides_no_line() -> None:
    """It is predicted behind us in our own lane, and spans our axis; the road bends away meanwhile."""
    behind = Obstacles(*(np.array([x]) for x in (-12.0, -0.8, 1.6, 1.0, np.inf)), identity=np.array([-1]))
    camera = Camera()
    picture, tracker = RoadPicture(camera, 0.01), RoadEdgeTracker(camera, ROBUST.road_edges, 20.0)
    known: list[RoadEdges] = []
    for i in range(60):
        pose = picture.pose(i * SPEED_MPS / 20.0, 1.75, 0.0)
        frame = picture.draw(pose, i)
        known.append(tracker.update(frame, grey(frame), pose, SPEED_MPS, 0.0, behind if i >= 16 else None))
    assert known[-1].sigma_m < 1.5 * known[15].sigma_m
    assert known[-1].right_m == pytest.approx(5.25, abs=0.1)


@pytest.mark.parametrize(
    ("face_m", "left_m", "right_m", "length_m"),
    [
        (9.0, 2.0, 3.8, 5.5),  # a car's rear and its flank
        (9.0, -3.8, -2.0, 5.5),
        (9.0, -0.9, 0.9, 5.5),
        (1.0, 2.5, 4.3, 5.5),  # beside us, its front is ahead
        (-1.0, -4.5, -2.7, 5.5),
        (9.0, 2.0, 2.5, 1.0),  # a cone
        (9.0, 2.0, 4.5, 9.0),  # as wide as a truck
    ],
)
def test_what_a_body_and_its_flank_hide_is_no_road(
    face_m: float, left_m: float, right_m: float, length_m: float
) -> None:
    camera = Camera()
    config, view = ROBUST.road_edges, BirdsEye(camera, ROBUST.road_edges.patch)
    body = Obstacles(*(np.array([value]) for value in (face_m, left_m, right_m, 0.4, np.inf)), identity=np.array([1]))
    hidden = hidden_by(body, view, 0.0, config.obstacle_mask)
    ahead, aside = np.meshgrid(view.forward_m, view.right_m, indexing="ij")
    share = np.linspace(0.0, 1.0, 400)[:, None, None]
    along, across = camera.forward_m + share * (ahead - camera.forward_m), share * aside

    def meets(wider_m: float) -> Bools:
        """The line of sight meets the body's outline, so much larger."""
        inside = (along > face_m - wider_m) & (along < face_m + length_m + wider_m)
        inside &= (across > left_m - wider_m) & (across < right_m + wider_m)
        return np.asarray(inside.any(axis=0))

    assert hidden[meets(0.0)].all()
    assert meets(1.0)[hidden].all()


@pytest.mark.parametrize("rate_hz", [10.0, 20.0])
def test_the_lane_is_judged_at_its_period_at_any_frame_rate(rate_hz: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A period of 0.2 s is two frames at 10 Hz, and four at 20 Hz."""
    judged = []
    judge = CarriagewayHypotheses.judge

    def counted(self: CarriagewayHypotheses, *arguments: Any) -> None:
        judged.append(arguments)
        judge(self, *arguments)

    monkeypatch.setattr(CarriagewayHypotheses, "judge", counted)
    duration_s = 3.0
    for _ in follow(RoadPicture(Camera()), 1.3, 0.0, round(duration_s * rate_hz), rate_hz):
        pass
    assert len(judged) == pytest.approx(duration_s / ROBUST.road_edges.index_period_s, abs=2)
