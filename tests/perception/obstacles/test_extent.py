"""Face and sides of obstacles by their points, and which points are of another."""

from dataclasses import replace

import numpy as np
import pytest
from driver_settings import static_obstacles
from made_obstacles import obstacles

from vpf_sim.geometry import rotation, vehicle_from_world
from vpf_sim.perception.obstacles.clustering import split
from vpf_sim.perception.obstacles.extent import (
    ObstaclePoints,
    corrected_front,
    direction_at,
    fragments,
    front,
    is_behind,
    move_to_face,
    rotate,
    rotate_back,
    sides,
)
from vpf_sim.perception.obstacles.low_obstacles import extend_by_low, join, widen_to_tracks
from vpf_sim.perception.obstacles.prediction import predict
from vpf_sim.seeding import stream
from vpf_sim.types import Floats, RoadEdges

CONFIG = static_obstacles()
SPLIT, FRAGMENT = CONFIG.split, CONFIG.fragment


def test_obstacles_are_predicted_by_the_ego_motion_and_their_own() -> None:
    """One stands and one drives at 4 m/s along a straight road that runs 0.1 rad to the right; 0.05 s later the car has
    gone 0.3 m ahead, 0.02 m aside and turned by 0.03 rad."""
    reported = obstacles((20.0, 2.0, 4.0), (30.0, -3.0, -1.0), identity=(1, -1), speed_mps=(0.0, 4.0))
    road, seen_from = RoadEdges(-5.0, 5.0, 0.1, 0.0, 0.05, 1.0, 0.0, 3.5), np.array([3.0, 1.0, 0.5])
    pose = np.array([*(seen_from[:2] + rotation(0.5) @ np.array([0.3, 0.02])), 0.53])
    found = predict(reported, seen_from, pose, road, 0.05)
    expected = np.array([[20.0, 3.0], [30.0, -2.0] + 0.2 * np.array([np.cos(0.1), np.sin(0.1)])]) - (0.3, 0.02)
    expected = expected @ rotation(0.03)
    assert np.stack([found.forward_m, found.middle_m], axis=1) == pytest.approx(expected, abs=1e-3)


def ahead(forward_m: Floats, sigma_m: Floats) -> ObstaclePoints:
    """Points (M,) straight ahead, seen sharply; none of them is an obstacle by itself, or a stray."""
    return replace(points(np.column_stack([forward_m, np.zeros(len(forward_m))])), sigma_m=sigma_m)


def test_points_before_the_face_move_along_their_line_of_sight() -> None:
    """A corner 12 m ahead and 3 m right, seen from the origin and placed at two thirds of its distance; then a turn."""
    turn, corner = -0.3, np.array([12.0, 3.0])
    placed = vehicle_from_world(np.stack([corner * 2.0 / 3.0, corner]), np.array([0.0, 0.0, turn]))
    sight = np.arctan2(corner[1], corner[0]) - turn
    across = move_to_face(np.full(2, placed[1, 0]), placed, np.full(2, sight))
    assert across == pytest.approx([placed[1, 1]] * 2)


def test_front_is_a_quantile_of_the_points_not_the_nearest() -> None:
    """200 obstacles of 8 points with sigma 1.2 m: the nearest errs by -1.7 m. Half of them have 2 points 3 m behind."""
    rng, count = stream(25, "faces"), 200
    forward = np.concatenate([rng.normal(20.0, 1.2, 8 * count), rng.normal(23.0, 0.5, count)])
    label = np.concatenate([np.repeat(np.arange(count), 8), np.repeat(np.arange(count // 2, count), 2)])
    sigma = np.concatenate([np.full(8 * count, 1.2), np.full(count, 0.5)])
    face, face_sigma = front(ahead(forward, sigma), label, count)
    alone, followed = face[: count // 2] - 20.0, face[count // 2 :] - 20.0
    assert -1.0 < np.mean(alone) < 0.0
    assert np.mean(np.abs(alone) < 1.5) > 0.9
    assert np.all(face_sigma < 0.5)
    assert np.mean(np.abs(followed) < 1.5) > 0.9


@pytest.mark.parametrize("count", [3, 8, 30])
def test_corrected_front_is_unbiased(count: int) -> None:
    """400 faces 20 m ahead, of points known to 1.2 m."""
    rng, faces = stream(29, "faces"), 400
    label = np.repeat(np.arange(faces), count)
    sigma = np.full(len(label), 1.2)
    seen = ahead(20.0 + sigma * rng.standard_normal(len(label)), sigma)
    nearest, _ = front(seen, label, faces)
    face, face_sigma = corrected_front(seen, label, faces)
    standard_error = np.std(face) / np.sqrt(faces)
    assert abs(np.mean(face) - 20.0) < 0.03 + 3.0 * standard_error
    assert np.mean(nearest) < 19.5, "their nearest quarter"
    assert face_sigma == pytest.approx(1.2 / np.sqrt(count))


def test_width_of_a_long_obstacle_is_that_of_its_face_for_a_turned_car() -> None:
    """A truck of 2.5 x 9 m whose points err along the line of sight: 0.03 m on the face, 0.6 m on the roof."""
    rng, heading_rad = stream(26, "sides"), 0.3
    face = np.column_stack([np.full(40, 12.0), rng.uniform(-1.0, 1.5, 40)])
    side = np.column_stack([rng.uniform(12.0, 21.0, 20), np.full(20, -1.0)])
    roof = np.column_stack([rng.uniform(12.0, 21.0, 20), rng.uniform(-1.0, 1.5, 20)])
    turn = rotation(heading_rad).T
    place = np.concatenate([face, side, roof]) @ turn
    sigma = np.repeat([0.03, 0.03, 0.6], [40, 20, 20])
    sight = np.arctan2(place[:, 1], place[:, 0])
    place = place + (sigma * rng.standard_normal(80))[:, None] * np.column_stack([np.cos(sight), np.sin(sight)])
    road = RoadEdges(-7.0, 7.0, heading_rad, 0.0, 0.02, 1.0, 0.0, 3.5)
    label, seen = np.zeros(80, np.int64), replace(points(place), sigma_m=sigma, sight_rad=sight)
    angle = direction_at(seen, label, 1, road)
    seen = rotate(seen, angle[label])
    begin, _ = front(seen, label, 1)
    forward, left, right = rotate_back(begin, *sides(seen, label, begin, CONFIG.sharpest), angle)
    assert right[0] - left[0] == pytest.approx(2.5, abs=0.3)
    middle = turn @ [forward[0], 0.5 * (left[0] + right[0])]
    assert middle == pytest.approx([12.0, 0.25], abs=0.2)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_points_that_slide_along_the_far_edge_do_not_widen_an_obstacle(side: float) -> None:
    """A car's face from 1 m left to 1 m right of the axis, 12 m ahead, and points that slide along its far edge; the
    points on a side that is turned to the camera are where they seem."""
    face = np.array([[12.0, across] for across in np.linspace(-1.0, 1.0, 9)])
    slides = np.array([[depth, side * depth / 12.0] for depth in (20.0, 16.0, 14.0, 13.0)])
    place = np.concatenate([face, slides])
    seen = points(place)
    left, right = sides(seen, np.zeros(len(place), np.int64), np.array([12.0]), CONFIG.sharpest)
    assert (left[0], right[0]) == pytest.approx((-1.0, 1.0), abs=1e-9)
    near_side = np.array([[12.0, 3.0 * side], [12.0, 5.0 * side], [16.0, 3.0 * side], [19.0, 3.0 * side]])
    left, right = sides(points(near_side), np.zeros(4, np.int64), np.array([12.0]), CONFIG.sharpest)
    assert sorted((side * left[0], side * right[0])) == pytest.approx([3.0, 5.0], abs=1e-9)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_blurred_points_beside_an_edge_do_not_move_it(side: float) -> None:
    """A car's face between 1 and 3 m aside, observed from 8 m. A point 0.5 m beside it was observed from 20 m:
    half a window is as wide there; those of a barrier were not observed since."""
    face = [(8.0, side * across) for across in np.linspace(1.0, 3.0, 9)]
    place = np.array([*face, (8.0, side * 3.5), (8.0, side * 5.0), (8.0, side * 6.0)])
    rim = np.repeat([0.14, 0.35], [9, 3])
    for count, outer in ((10, 3.0), (12, 6.0)):
        seen = replace(points(place[:count], 0.01), rim_m=rim[:count])
        found = sides(seen, np.zeros(count, np.int64), np.array([8.0]), CONFIG.sharpest)
        assert sorted(side * edge[0] for edge in found) == pytest.approx([1.0, outer], abs=1e-9)


def points(place_m: Floats, sigma_m: float = 0.1) -> ObstaclePoints:
    """Points (N, 2) in vehicle axes, seen sharply from the origin."""
    count = len(place_m)
    sight_rad = np.arctan2(place_m[:, 1], place_m[:, 0])
    return ObstaclePoints(place_m, np.full(count, sigma_m), sight_rad, np.zeros(count))


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_points_behind_and_beside_an_obstacle_are_split_off(side: float) -> None:
    """A van on one side, its flank turned to the camera, what slides along its outer edge, and a pedestrian."""
    face = [(8.0, side * across) for across in (3.0, 3.5, 4.0, 4.5, 5.0)]
    flank = [(forward, side * 3.0) for forward in (9.5, 11.0, 12.5)]
    slides = [(14.0, side * 5.0 * 14.0 / 8.0)]
    pedestrian = [(11.0, side * 1.2), (11.0, side * 1.6), (11.1, side * 1.4)]
    place = np.array(face + flank + slides + pedestrian)
    seen = points(place)
    label = np.zeros(len(place), np.int64)
    behind = is_behind(seen, label, 1, SPLIT, 2.5)
    assert behind.tolist() == [False] * 9 + [True] * 3
    assert not is_behind(replace(seen, sigma_m=np.full(len(place), 1.5)), label, 1, SPLIT, 2.5).any(), (
        "depth known badly"
    )
    step = np.where(behind, 0, -1)
    parts, apart = split(label, step, lambda parts: np.ones(parts.max() + 1, np.bool_))
    assert parts.tolist() == [0] * 9 + [1] * 3
    assert apart.tolist() == [False, True]
    parts, apart = split(label, step, lambda parts: np.arange(parts.max() + 1) == 0)
    assert parts.tolist() == [0] * 12, "what would be no obstacle by itself stays a part of the other"
    assert apart.tolist() == [False]


def test_points_behind_an_obstacle_on_both_sides_are_split_off() -> None:
    """Two points on either side, and one astray, which stays a part of what is left."""
    label, step = np.zeros(9, np.int64), np.array([-1, -1, -1, -1, 0, 1, 0, 1, 2])
    parts, apart = split(label, step, lambda parts: np.bincount(parts) > 1)
    assert parts.tolist() == [0, 0, 0, 0, 1, 2, 1, 2, 0]
    assert apart.tolist() == [False, True, True]


@pytest.mark.parametrize(
    ("ahead_m", "across_m", "body", "support", "own"),
    [
        (15.0, (-3.6, -3.4), 4, 1, False),  # one point beside the van, once taken for a part of it
        (15.0, (-3.6, -3.4), 4, 3, True),  # several are an obstacle
        (15.0, (-3.6, -3.4), 5, 1, True),  # and so is one of another
        (12.0, (-6.5, -5.5), 4, 3, False),  # in the strip that the van hides
        (9.0, (-2.2, -1.8), 4, 3, False),  # along its side
        (16.0, (-2.2, -1.8), 4, 3, True),  # beyond it
        (4.5, (-5.5, -5.5), 4, 1, True),  # its own side
        (4.5, (-2.5, -0.5), 4, 3, True),
        (3.0, (-3.0, -2.5), 4, 3, True),  # nothing nearer hides it, and it hides not the larger
    ],
)
def test_fragments_behind_an_obstacle_are_no_obstacles(
    ahead_m: float, across_m: tuple[float, float], body: int, support: int, own: bool
) -> None:
    """A van 4 m ahead, from 4 to 2 m left of the camera's axis, has the number 4."""
    left, right = np.array([-4.0, across_m[0]]), np.array([-2.0, across_m[1]])
    ahead, straight = np.array([4.0, ahead_m]), np.zeros(2)
    belongs_to = fragments(ahead, left, right, straight, np.array([4, body]), np.array([20, support]), FRAGMENT)
    assert belongs_to.tolist() == [False, not own]


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_in_line_is_along_the_road_for_a_turned_car(side: float) -> None:
    """A truck's face 2.4 m ahead and, 4.7 m behind that and 1.1 m off its flank, another; the car is turned 13 deg."""
    ahead, truck, other = np.array([2.4, 7.1]), sorted((side * 3.3, side * 5.8)), sorted((side * 2.6, side * 3.1))
    left, right = np.array([truck, other]).T
    for angle, parts in ((0.0, [False, True]), (side * 0.23, [False, False])):
        found = fragments(ahead, left, right, np.full(2, angle), np.array([4, 4]), np.array([20, 6]), FRAGMENT)
        assert found.tolist() == parts


@pytest.mark.parametrize("sight_deg", [70.0, 89.9, 90.0, 95.0])
def test_points_with_lines_of_sight_across_the_road_stretch_an_obstacle_little(sight_deg: float) -> None:
    """A car that has turned far observes a flank along these lines; one of its points lies before the face."""
    place = np.array([[8.0, 1.0], [8.0, 1.4], [8.0, 1.8], [7.6, 1.4]])
    sight = np.radians([sight_deg] * 4)
    for turn in (-1.0, 1.0):
        seen = replace(points(place), sight_rad=turn * sight)
        left, right = sides(seen, np.zeros(4, np.int64), np.array([8.0]), CONFIG.sharpest)
        assert 0.5 <= left[0] <= 1.0
        assert 1.8 <= right[0] <= 2.3


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_low_obstacle_that_sticks_out_of_a_taller_one_is_its_own(side: float) -> None:
    """Beside a car's flank, 0.6 m wide or more as what is low is reported: a wheel, a shadow's corner, and a pallet."""
    car = obstacles((5.5, *sorted((side * 2.5, side * 4.7))))
    wheel, shadow, pallet = ((6.5, *sorted((side * a, side * b))) for a, b in ((2.2, 2.8), (1.85, 2.45), (1.6, 2.45)))
    for one in (wheel, shadow):
        assert len(join(car, obstacles(one), 0.1, 0.75, 2.0, 2.0)) == 1
    both = join(car, obstacles(pallet), 0.1, 0.75, 2.0, 2.0)
    assert sorted(both.left_m.tolist()) == sorted((car.left_m[0], pallet[1]))


@pytest.mark.parametrize(("before_m", "own"), [(0.8, False), (1.2, True)])
def test_a_low_obstacle_well_before_a_taller_one_is_its_own(before_m: float, own: bool) -> None:
    wall, plank = obstacles((9.0, -3.0, 3.0)), obstacles((9.0 - before_m, -0.5, 0.5))
    assert len(join(wall, plank, 0.4, 1.0, 1.0, 2.0)) == 1 + own


@pytest.mark.parametrize(
    ("seen_m", "tracks_m", "sides_m"),
    [
        pytest.param((0.98, 1.1), [(8.3, 1.2, 2.0)], (0.98, 1.78), id="a pallet's left rim"),
        pytest.param((-1.1, -0.98), [(8.3, -2.0, -1.2)], (-1.78, -0.98), id="mirrored"),
        pytest.param((-3.0, -2.9), [(8.3, 1.2, 2.0)], (-3.0, -2.9), id="on the other side"),
        pytest.param((1.0, 1.2), [(8.3, 1.7, 2.5)], (1.0, 1.2), id="a track beside it"),
        pytest.param((1.0, 1.2), [(10.3, 0.9, 1.7)], (1.0, 1.2), id="a track behind it"),
        pytest.param((1.0, 2.0), [(8.0, 1.2, 1.8)], (1.0, 2.0), id="a narrower track"),
        pytest.param((1.0, 1.2), [(8.0, 0.2, 0.9), (8.0, 1.25, 2.0)], (1.0, 1.75), id="the nearer is the second"),
        pytest.param((1.0, 1.2), [(8.0, 1.25, 2.0), (8.0, 0.2, 0.9)], (1.0, 1.75), id="the nearer is the first"),
        pytest.param((1.0, 1.2), [], (1.0, 1.2), id="no track"),
    ],
)
def test_a_low_obstacle_has_the_width_of_the_nearest_track_and_contains_its_points(
    seen_m: tuple[float, float], tracks_m: list[tuple[float, float, float]], sides_m: tuple[float, float]
) -> None:
    """Points 8 m ahead show a part of what the track spans, which is reported some decimetres off."""
    seen = widen_to_tracks(obstacles((8.0, *seen_m)), obstacles(*tracks_m), 1.0, 0.4)
    assert (seen.left_m[0], seen.right_m[0]) == pytest.approx(sides_m)
    assert not len(widen_to_tracks(obstacles(), obstacles(*tracks_m), 1.0, 0.4))


@pytest.mark.parametrize(
    ("low", "reported"), [((8.5, 1.0, 1.85), (8.0, 1.0, 1.85)), ((7.7, 1.0, 1.6), (7.7, 1.0, 1.8))]
)
def test_a_tall_obstacle_on_a_wider_low_one_has_its_width(
    low: tuple[float, float, float], reported: tuple[float, float, float]
) -> None:
    """They are reported by themselves where its right end is."""
    seen = extend_by_low(obstacles((8.0, 1.4, 1.8)), obstacles(low), 0.5, 2.0)
    assert (seen.forward_m[0], seen.left_m[0], seen.right_m[0]) == pytest.approx(reported)


@pytest.mark.parametrize("low", [(8.5, 1.9, 2.5), (10.5, 1.0, 1.85), (7.0, 1.0, 1.85), (8.0, 1.3, 1.6)])
def test_a_low_obstacle_elsewhere_or_narrower_extends_nothing(low: tuple[float, float, float]) -> None:
    """Beside it, behind, before: an obstacle of its own, which must keep its face; and a wheel."""
    seen = extend_by_low(obstacles((8.0, 1.4, 1.8)), obstacles(low), 0.5, 2.0)
    assert (seen.forward_m[0], seen.left_m[0], seen.right_m[0]) == (8.0, 1.4, 1.8)
