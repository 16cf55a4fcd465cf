"""Planar parallax on drawn roads with a plate on, in or under them."""

from itertools import count

import cv2
import numpy as np
import pytest
from driver_settings import static_obstacles
from made_obstacles import obstacles
from plated_road import CAMERA, PLATE_M, frame

from vpf_sim.geometry import rotation
from vpf_sim.perception.obstacles.planar_parallax.detector import LowObservation, PlanarParallax
from vpf_sim.perception.obstacles.planar_parallax.tracker import LowObstacleTracks
from vpf_sim.perception.road.occlusion import footprints
from vpf_sim.seeding import stream
from vpf_sim.types import Floats, Image, RoadEdges

SPEED_MPS, LOOKS_HZ = 5.55, 10.0
BUMPER_M = 2.25
CONFIG, TRACKS = static_obstacles().planar_parallax, static_obstacles().low_tracks
STRAIGHT = RoadEdges(-7.0, 7.0, 0.0, 0.0, 0.05, 1.0, 0.0, 3.5)


def in_rain(image: Image, look: int) -> Image:
    """The frame behind drops that a wiper takes away every second."""
    rng, wet = stream(33, f"drops {look // 10}"), image.copy()
    for _ in range(3 * (look % 10)):
        column, row, size = rng.uniform(200.0, 440.0), rng.uniform(270.0, 335.0), rng.uniform(2.0, 5.0)
        cv2.circle(wet, (int(column), int(row)), int(size), rng.uniform(120.0, 220.0), -1, cv2.LINE_AA)
    return wet


def looks(height_m: float, turn_rad: float = 0.0, rain: bool = False) -> list[tuple[Floats, list[LowObservation]]]:
    """Poses and observations on the way to 6.5 m before the plate; all poses turned about the origin."""
    residual, found = PlanarParallax(CAMERA, CONFIG, LOOKS_HZ), []
    for look, forward in enumerate(np.arange(10.0, PLATE_M[0, 0] - BUMPER_M - 6.5, SPEED_MPS / LOOKS_HZ).tolist()):
        pose = np.array([*(rotation(turn_rad) @ np.array([forward, 0.0])), turn_rad])
        image = frame(forward, height_m)
        observations = residual.update(in_rain(image, look) if rain else image, pose)
        if observations is not None:
            found.append((pose, observations))
    return found


def test_a_flat_plate_is_detected_where_it_lies() -> None:
    found = [(PLATE_M[0, 0] - pose[0], one) for pose, observations in looks(0.15) for one in observations]
    assert len(found) >= 3
    assert found[0][0] > 13.6, "from farther away than the noise is measured"
    for distance, one in found:
        assert one.forward_m == pytest.approx(distance, abs=1.1)
        assert (one.left_m, one.right_m) == pytest.approx((-0.2, 0.6), abs=0.7)


def reliefs(height_m: float, left_m: float, right_m: float) -> list[float]:
    """Of a face at the plate's distance, on the way to 4.5 m before it."""
    residual, found = PlanarParallax(CAMERA, CONFIG, LOOKS_HZ), []
    for forward in np.arange(10.0, PLATE_M[0, 0] - BUMPER_M - 4.5, SPEED_MPS / LOOKS_HZ).tolist():
        residual.update(frame(forward, height_m), np.array([forward, 0.0, 0.0]))
        found += residual.relief(obstacles((PLATE_M[0, 0] - forward, left_m, right_m))).tolist()
    return [value for value in found if not np.isnan(value)]


def test_what_is_painted_has_no_relief_and_what_lies_on_the_road_has() -> None:
    """A plate, paint as bright, and the asphalt beside it."""
    paint = reliefs(0.0, -0.2, 0.6)
    assert np.median(reliefs(0.15, -0.2, 0.6)) > 0.1
    assert np.median(paint) < -0.5
    assert np.abs(reliefs(0.0, -1.8, -0.9)).max() < 0.1
    assert len(paint) >= 12, "in each comparison from 15 to 7 m"


@pytest.mark.parametrize(("aside_m", "turn_radpm"), [(-2.6, 0.0), (3.0, 0.0), (-2.0, 0.05)])
def test_a_plate_in_the_next_lane_or_in_a_swerve_is_detected_alone(aside_m: float, turn_radpm: float) -> None:
    """The car passes it in the next lane, or swerves towards it: by 13 deg between the frames that are compared."""
    residual, on_plate = PlanarParallax(CAMERA, CONFIG, LOOKS_HZ), 0
    for way in np.arange(8.0, PLATE_M[0, 0] - CONFIG.near_m - 0.3, SPEED_MPS / LOOKS_HZ).tolist():
        turning = max(0.0, way - 14.0)
        pose = np.array([way, aside_m + 0.5 * turn_radpm * turning**2, turn_radpm * turning])
        for one in residual.update(frame(way, 0.15, float(pose[1]), float(pose[2])), pose) or []:
            middle = rotation(pose[2]).T @ (PLATE_M.mean(axis=0) - pose[:2])
            assert 0.5 * (one.left_m + one.right_m) == pytest.approx(middle[1], abs=0.7)
            on_plate += abs(one.forward_m + 0.6 - middle[0]) < 1.3
    assert on_plate >= 3


@pytest.mark.parametrize(
    ("height_m", "rain"), [(0.15, False), (0.15, True), (0.0, False), (0.0, True), (-0.15, False), (-1.4, False)]
)
def test_only_a_plate_above_the_road_is_confirmed(height_m: float, rain: bool) -> None:
    """Paint as bright as the plate and its mirror image are not, nor drops on the windscreen, which hide no plate."""
    numbers = count()
    tracks = LowObstacleTracks(TRACKS, lambda: next(numbers), CONFIG.near_m, 11.0)
    for pose, observations in looks(height_m, rain=rain):
        tracks.record(observations, pose)
    places_m = [PLATE_M[0, 0]] if height_m > 0.0 else []
    assert (tracks.bodies(pose).forward_m + pose[0]).tolist() == pytest.approx(places_m, abs=1.1)


def test_the_direction_of_travel_in_the_world_does_not_matter() -> None:
    straight, turned = looks(0.15), looks(0.15, turn_rad=2.4)
    assert [len(observations) for _, observations in turned] == [len(observations) for _, observations in straight]
    for (_, one), (_, other) in zip(straight, turned, strict=True):
        for a, b in zip(one, other, strict=True):
            assert a.forward_m == pytest.approx(b.forward_m, abs=0.06)


@pytest.mark.parametrize(
    ("left_m", "right_m", "ahead_m", "seen"),
    [
        (-0.3, 0.7, 0.0, False),  # on the plate
        (-1.0, 1.0, 2.5, False),  # before it
        (1.1, 3.0, 0.0, True),  # beside it
        (0.7, 1.2, 6.0, True),  # a short one
    ],
)
def test_a_known_obstacle_is_left_out_with_what_it_hides_only(
    left_m: float, right_m: float, ahead_m: float, seen: bool
) -> None:
    """The plate lies from 0.2 m left to 0.6 m right."""
    residual, found = PlanarParallax(CAMERA, CONFIG, LOOKS_HZ), False
    for forward in np.arange(10.0, PLATE_M[0, 0] - BUMPER_M - 6.5, SPEED_MPS / LOOKS_HZ).tolist():
        known = footprints(obstacles((PLATE_M[0, 0] - forward - ahead_m, left_m, right_m)), STRAIGHT)
        found |= bool(residual.update(frame(forward, 0.15), np.array([forward, 0.0, 0.0]), known))
    assert found is seen


def test_nothing_is_reported_without_a_baseline() -> None:
    residual = PlanarParallax(CAMERA, CONFIG, 60.0)
    image = frame(0.0, 0.15)
    assert all(residual.update(image, np.zeros(3)) is None for _ in range(20))


def test_an_observation_waits_while_the_wiper_hides_the_road() -> None:
    residual, image, looked = PlanarParallax(CAMERA, CONFIG, 60.0), frame(0.0, 0.15), []
    for index in range(24):
        hidden = 4 <= index < 9  # it is due in frame 6
        looked += [index] if residual.looks and not hidden else []
        residual.update(None if hidden else image, np.zeros(3))
    assert looked == [0, 9, 15, 21]
