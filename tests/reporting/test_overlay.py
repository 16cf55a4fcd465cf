"""The overlay: drawn at the right pixels, without changing the input frame."""

from dataclasses import replace

import numpy as np
import pytest

from vpf_sim.geometry import project
from vpf_sim.planning.paper.lane import Lane
from vpf_sim.planning.paper.planner import PaperPlan
from vpf_sim.reporting import overlay
from vpf_sim.reporting.top_view import RADIUS, TOTAL
from vpf_sim.types import (
    Camera,
    Expansion,
    Floats,
    Flow,
    Force,
    KnownFeatures,
    ObstacleMap,
    Obstacles,
    Perception,
    Plan,
    Reference,
    RoadEdges,
)

GREY = 90


def plan(camera: Camera, points: Floats | None = None, ahead_m: float | None = None, plane: float = 0.0) -> Plan:
    """A plan on a straight road, edges 5.25 m right and 8.75 m left."""
    points = np.empty((0, 2)) if points is None else points
    count = len(points)
    flow = Flow(
        points, np.full((count, 2), 6.0), np.full(count, 0.1), np.tile([-0.55, 0.0, 0.0], (count, 1)), np.zeros(3),
        np.arange(count), points, np.zeros((count, 3)), np.ones(count, np.int64), np.zeros((count, 2, 2)),
    )  # fmt: skip
    places = [] if ahead_m is None else [ahead_m]
    obstacles = Obstacles(
        np.array(places), np.array([-1.0] * len(places)), np.array([1.0] * len(places)), np.array([0.2] * len(places)),
        np.array([np.inf] * len(places)), np.arange(len(places)),
    )  # fmt: skip
    grid = np.full((camera.height_px // 8, camera.width_px // 8), plane)
    expansion = Expansion(camera.cx_px, camera.cy_px, np.eye(2), np.ones(count, np.bool_), 0.9)
    road = RoadEdges(-8.75, 5.25, 0.0, 0.0, 0.02, 0.95, 0.0, 3.5)
    obstacle_map = ObstacleMap(np.zeros(count, np.bool_), grid, np.zeros((2, *grid.shape)), 8)
    salience = KnownFeatures(obstacle_map, np.full(count, 1.0))
    perception = Perception(flow, expansion, salience, obstacles, road, flow.pose)
    none = np.zeros(2)
    force = Force(np.array([1.0, 0.0]), none, none, np.array([1.0, 0.0]))
    return Plan(perception, force, Reference(0.2, 5.5), PaperPlan(Lane(0.0, 5.25, -8.75, 0.0, 0.0), 0))


def drawn(camera: Camera, made: Plan) -> Floats:
    """(H, W) how far each pixel was changed."""
    frame = np.full((camera.height_px, camera.width_px, 3), GREY, np.uint8)
    result = overlay.draw(frame, made, camera)
    assert np.all(frame == GREY), "the frame that came in was drawn on"
    assert result.shape == frame.shape
    assert result.dtype == np.uint8
    return np.abs(result.astype(float) - GREY).sum(axis=2)


CAMERAS = [Camera(), Camera(1226, 370, 707.1, 707.1, 601.9, 183.1, 1.65, 0.0, 0.021), Camera(k1=-0.1)]


@pytest.mark.parametrize("camera", CAMERAS, ids=["default", "kitti", "distorted"])
def test_the_right_edge_is_drawn_where_it_lies(camera: Camera) -> None:
    change = drawn(camera, plan(camera))
    for ahead in (12.0, 20.0):
        x, y = project(camera, np.array([ahead, 5.25, 0.0]))
        if camera.k1:
            centre = np.array([camera.cx_px, camera.cy_px])
            ray = (np.array([x, y]) - centre) / camera.fx_px
            x, y = centre + camera.fx_px * ray * (1.0 + camera.k1 * np.sum(ray**2))
        assert change[round(y) - 1 : round(y) + 2, round(x) - 1 : round(x) + 2].max() > 100.0


def test_flow_obstacles_map_and_focus_are_drawn() -> None:
    camera = Camera()
    bare = drawn(camera, plan(camera))
    with_flow = drawn(camera, plan(camera, points=np.array([[100.0, 120.0]])))
    assert with_flow[120, 100] > 100.0
    assert bare[120, 100] == 0.0
    foot = project(camera, np.array([10.0, -1.0, 0.0]))
    with_obstacle = drawn(camera, plan(camera, ahead_m=10.0))
    assert with_obstacle[round(foot[1]), round(foot[0])] > bare[round(foot[1]), round(foot[0])] + 50.0
    tinted = drawn(camera, plan(camera, plane=1.0))
    assert tinted[150, 50] > 20.0
    assert bare[round(camera.cy_px), round(camera.cx_px) + 11] > 100.0


def test_the_total_force_points_up_when_it_pulls_ahead() -> None:
    camera = Camera()
    frame = overlay.draw(np.full((480, 640, 3), GREY, np.uint8), plan(camera), camera)
    above = frame[480 - 24 - round(1.6 * RADIUS), 640 - 14 - round(RADIUS)]
    assert np.abs(above.astype(int) - TOTAL).max() < 40


def test_an_obstacle_behind_the_camera_is_not_drawn() -> None:
    camera = Camera()
    assert camera.forward_m > 0.5, "m ahead of the pose, where the obstacle is"
    assert np.array_equal(drawn(camera, plan(camera, ahead_m=0.5)), drawn(camera, plan(camera)))


def test_points_at_the_frames_corners_are_clipped() -> None:
    camera = Camera()
    change = drawn(camera, plan(camera, points=np.array([[0.0, 0.0], [639.0, 479.0]])))
    assert min(change[0, 0], change[479, 639]) > 100.0


def test_a_nan_focus_of_expansion_is_not_drawn() -> None:
    camera = Camera()
    made = plan(camera)
    unknown = replace(made.perception.expansion, x_px=float("nan"))
    change = drawn(camera, replace(made, perception=replace(made.perception, expansion=unknown)))
    beside = (round(camera.cy_px), round(camera.cx_px) + 11)
    assert drawn(camera, made)[beside] > 100.0
    assert change[beside] == 0.0


def test_colours_run_from_red_to_green_and_grey_is_unknown() -> None:
    red, green = overlay.ttc_colour(0.5), overlay.ttc_colour(20.0)
    assert red[0] > 200 > 100 > red[1]
    assert green[1] > 200 > 100 > green[0]
    assert overlay.ttc_colour(float("inf")) == overlay.UNKNOWN


@pytest.mark.parametrize("curvature", [0.0, 0.01, -0.02])
def test_a_line_along_the_road_is_an_arc(curvature: float) -> None:
    road = RoadEdges(-8.75, 5.25, 0.1, curvature, 0.0, 1.0, 0.0, 3.5)
    line = overlay.road_line(road, 2.0, np.linspace(0.0, 40.0, 9))
    assert line[0] == pytest.approx([-2.0 * np.sin(0.1), 2.0 * np.cos(0.1)])
    if curvature:
        centre = np.array([-np.sin(0.1), np.cos(0.1)]) / curvature
        distance = np.linalg.norm(line - centre, axis=1)
        assert distance == pytest.approx(np.full(9, abs(1.0 / curvature - 2.0)))


def test_labels_do_not_cover_each_other() -> None:
    near, behind = overlay.Label("8.0 m", 100.0, 150.0, 200.0), overlay.Label("11.0 m", 140.0, 200.0, 195.0)
    beside, above = overlay.Label("12.0 m", 170.0, 220.0, 200.0), overlay.Label("14.0 m", 100.0, 150.0, 170.0)
    assert overlay.uncovered([near, behind, beside, above]) == [near, beside, above]
