"""Planar parallax on drawn roads with a plate on, in or under them, and the tracks of low obstacles."""

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from driver_settings import optional_sections, static_obstacles, without
from plated_road import CAMERA, PLATE_M, frame

from vpf_sim.geometry import rotation, vehicle_from_world
from vpf_sim.perception.obstacles.planar_parallax.config import LowTrackConfig, ParallaxConfig
from vpf_sim.perception.obstacles.planar_parallax.detector import LowObservation, PlanarParallax
from vpf_sim.perception.obstacles.planar_parallax.tracker import LowObstacleTracks, in_sight
from vpf_sim.perception.road.config import OcclusionConfig
from vpf_sim.perception.road.occlusion import footprints
from vpf_sim.seeding import stream
from vpf_sim.types import Floats, Image, Obstacles, RoadEdges

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


def looks(
    height_m: float, turn_rad: float = 0.0, rain: bool = False, config: ParallaxConfig = CONFIG
) -> list[tuple[Floats, list[LowObservation]]]:
    """Poses and observations on the way to 6.5 m before the plate; all poses turned about the origin."""
    residual, found = PlanarParallax(CAMERA, config, LOOKS_HZ), []
    for look, forward in enumerate(np.arange(10.0, PLATE_M[0, 0] - BUMPER_M - 6.5, SPEED_MPS / LOOKS_HZ).tolist()):
        pose = np.array([*(rotation(turn_rad) @ np.array([forward, 0.0])), turn_rad])
        image = frame(forward, height_m)
        spots = residual.update(in_rain(image, look) if rain else image, pose)
        if spots is not None:
            found.append((pose, spots))
    return found


def test_a_flat_plate_is_detected_where_it_lies() -> None:
    found = [(PLATE_M[0, 0] - pose[0], spot) for pose, spots in looks(0.15) for spot in spots]
    assert len(found) >= 3
    assert found[0][0] > 13.6, "from farther away than the noise is measured"
    for distance, spot in found:
        assert spot.forward_m == pytest.approx(distance, abs=1.1)
        assert (spot.left_m, spot.right_m) == pytest.approx((-0.2, 0.6), abs=0.7)


@pytest.mark.parametrize("dash_m", [1.5, 3.0])
def test_a_dash_that_ends_at_a_plate_does_not_bring_it_nearer(dash_m: float) -> None:
    """The car weaves a little, so that paint lies a cell aside of where it was."""
    residual, off_m = PlanarParallax(CAMERA, CONFIG, LOOKS_HZ), []
    for way in np.arange(10.0, PLATE_M[0, 0] - 7.3, SPEED_MPS / LOOKS_HZ).tolist():
        pose = np.array([way, 0.02 * np.sin(way), 0.004 * np.cos(1.3 * way)])
        image = frame(way, 0.15, float(pose[1]), float(pose[2]), dash_m=dash_m)
        off_m += [spot.forward_m - (PLATE_M[0, 0] - way) for spot in residual.update(image, pose) or []]
    assert len(off_m) > 6
    assert min(off_m) > -0.5


@pytest.mark.parametrize(("aside_m", "turn_radpm"), [(-2.6, 0.0), (3.0, 0.0), (-2.0, 0.05)])
def test_a_plate_in_the_next_lane_or_in_a_swerve_is_detected_alone(aside_m: float, turn_radpm: float) -> None:
    """The car passes it in the next lane, or swerves towards it: by 13 deg between the frames that are compared."""
    residual, on_plate = PlanarParallax(CAMERA, CONFIG, LOOKS_HZ), 0
    for way in np.arange(8.0, PLATE_M[0, 0] - CONFIG.near_m - 0.3, SPEED_MPS / LOOKS_HZ).tolist():
        turning = max(0.0, way - 14.0)
        pose = np.array([way, aside_m + 0.5 * turn_radpm * turning**2, turn_radpm * turning])
        for spot in residual.update(frame(way, 0.15, float(pose[1]), float(pose[2])), pose) or []:
            middle = rotation(pose[2]).T @ (PLATE_M.mean(axis=0) - pose[:2])
            assert 0.5 * (spot.left_m + spot.right_m) == pytest.approx(middle[1], abs=0.7)
            on_plate += abs(spot.forward_m + 0.6 - middle[0]) < 1.3
    assert on_plate >= 3


def test_drops_on_the_windscreen_are_no_obstacles_and_hide_no_plate() -> None:
    gaps = [
        (spot.forward_m + pose[0] - PLATE_M[0, 0], spot) for pose, spots in looks(0.15, rain=True) for spot in spots
    ]
    on_plate = [gap for gap, spot in gaps if abs(gap) < 1.1 and spot.left_m < 0.6 and spot.right_m > -0.2]
    assert len(on_plate) >= 3
    assert len(gaps) - len(on_plate) <= 2


@pytest.mark.parametrize(("height_m", "bodies"), [(0.15, 1), (0.0, 0), (-0.15, 0), (-1.4, 0)])
def test_only_a_plate_above_the_road_is_confirmed(height_m: float, bodies: int) -> None:
    """Paint as bright as the plate and its mirror image are not."""
    book = LowObstacleTracks(TRACKS, lambda: 7)
    for pose, spots in looks(height_m):
        book.record(spots, pose)
    assert len(book.bodies(pose)) == bodies


def test_the_direction_of_travel_in_the_world_does_not_matter() -> None:
    straight, turned = looks(0.15), looks(0.15, turn_rad=2.4)
    assert [len(spots) for _, spots in turned] == [len(spots) for _, spots in straight]
    for (_, one), (_, other) in zip(straight, turned, strict=True):
        for a, b in zip(one, other, strict=True):
            assert a.forward_m == pytest.approx(b.forward_m, abs=0.06)


@pytest.mark.parametrize(
    ("left_m", "right_m", "ahead_m", "seen"),
    [
        (-0.3, 0.7, 0.0, False),  # on the plate
        (-1.0, 1.0, 2.5, False),  # before it
        (1.1, 3.0, 0.0, True),  # beside it
        (0.7, 3.3, 6.0, False),  # its flank beside it, a truck's
        (0.7, 1.2, 6.0, True),  # a short one
    ],
)
def test_a_known_obstacle_is_left_out_with_what_it_hides_only(
    left_m: float, right_m: float, ahead_m: float, seen: bool
) -> None:
    """The plate lies from 0.2 m left to 0.6 m right."""
    residual, found, one = PlanarParallax(CAMERA, CONFIG, LOOKS_HZ), False, np.ones(1)
    for forward in np.arange(10.0, PLATE_M[0, 0] - BUMPER_M - 6.5, SPEED_MPS / LOOKS_HZ).tolist():
        face = PLATE_M[0, 0] - forward - ahead_m
        body = Obstacles(face * one, left_m * one, right_m * one, 0.1 * one, one, np.array([1]))
        known = footprints(body, STRAIGHT, OcclusionConfig())
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


def changed(config: Any, keys: dict[str, Any]) -> Any:
    """The configuration with other values at dotted keys."""
    for path, value in keys.items():
        key, _, rest = path.partition(".")
        config = replace(config, **{key: changed(getattr(config, key), {rest: value}) if rest else value})
    return config


def recorded(places_m: list[float], speed_mps: float = SPEED_MPS, config: LowTrackConfig = TRACKS) -> list[Obstacles]:
    """Confirmed tracks after each observation so far ahead, one each 0.1 s, straight on."""
    numbers = iter(range(5))
    book, found = LowObstacleTracks(config, lambda: next(numbers)), []
    for k, place in enumerate(places_m):
        pose = np.array([k * speed_mps / LOOKS_HZ, 0.0, 0.0])
        book.record([LowObservation(place, -0.4, 0.4, 30.0)] if np.isfinite(place) else [], pose)
        found.append(book.bodies(pose))
    return found


def test_a_track_is_confirmed_when_it_stays_in_the_world() -> None:
    step = SPEED_MPS / LOOKS_HZ
    found = recorded([12.0 - k * step for k in range(6)] + [np.nan] * 30)
    assert [len(bodies) for bodies in found[:4]] == [0, 0, 1, 1]
    last = found[20]
    assert last.forward_m[0] == pytest.approx(12.0 - 20 * step)
    assert (last.left_m[0], last.right_m[0]) == pytest.approx((-0.4, 0.4))
    assert {int(name) for bodies in found for name in bodies.identity} == {0}
    assert len(recorded([12.0 - k * step for k in range(6)] + [np.nan] * 40)[-1]) == 0, "pruned once passed"


@pytest.mark.parametrize(
    "wrong",
    [
        {"hits": 0},
        {"approach.share": 1.1},
        {"truncated.share": 0.95},
        {"gain_weight.usual_gain": 0.0},
        {"gain_weight.least": 2.0},
        {"tentative.hits": 0},
    ],
)
def test_wrong_track_settings_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong)).rpartition(".")[2]):
        changed(TRACKS, wrong)


@pytest.mark.parametrize("bend_per_m", [-0.07, 0.0, 0.07])
@pytest.mark.parametrize(("mirrored", "told"), [(False, 1), (True, 0)])
def test_a_track_is_confirmed_as_soon_in_a_bend_and_a_mirror_image_is_not(
    bend_per_m: float, mirrored: bool, told: int
) -> None:
    """On the way of 5 m a mirror image moves on by a fifth of it, away from where the car is headed at first."""
    book, place = LowObstacleTracks(TRACKS, lambda: 0), np.array([13.0, 2.0 * np.sign(bend_per_m)])
    for way in np.arange(0.0, 5.0, 0.5):
        turn = bend_per_m * way
        pose = np.array([way * np.sinc(turn / np.pi), 0.5 * way * turn, turn])
        ahead, aside = vehicle_from_world(place + np.array([0.2 * way * mirrored, 0.0]), pose)
        book.record([LowObservation(ahead, aside - 0.4, aside + 0.4, 30.0)], pose)
        if way == 2.0:
            assert len(book.bodies(pose)) == told
    assert len(book.bodies(pose)) == told


@pytest.mark.parametrize("speed_mps", [1.0, 3.0, 5.55])
def test_a_drop_that_moves_with_the_car_is_never_confirmed(speed_mps: float) -> None:
    assert not any(len(bodies) for bodies in recorded([8.0] * 40, speed_mps))


def suspected(sightings: list[tuple[float, bool, bool]], step_m: float = SPEED_MPS / LOOKS_HZ) -> list[tuple[int, int]]:
    """How many are tentative and confirmed after each observation so far ahead (nan: none), `sure`, `truncated`."""
    book, found = LowObstacleTracks(TRACKS, lambda: 0, near_m=6.5), []
    for k, (place, sure, cut) in enumerate(sightings):
        pose = np.array([k * step_m, 0.0, 0.0])
        gain = 12.0 if sure else 4.0
        book.record([LowObservation(place, -0.4, 0.4, gain, sure, cut)] if np.isfinite(place) else [], pose)
        found.append((len(book.tentative(pose)), len(book.bodies(pose))))
    return found


@pytest.mark.parametrize(
    ("sure", "cut", "step_m", "found"),
    [(True, True, 0.5, 1), (False, True, 0.5, 0), (True, False, 0.5, 0), (True, True, 0.05, 0)],
    ids=["hidden until then", "weak", "not truncated", "at standstill"],
)
def test_a_sure_truncated_track_is_tentative(sure: bool, cut: bool, step_m: float, found: int) -> None:
    """Drops hid a pallet until 6.8 m; it cannot come nearer than 6.7 m, where the patch ends."""
    assert suspected([(6.8, sure, False), (6.7, sure, cut)], step_m) == [(0, 0), (found, 0)]


def test_at_standstill_nothing_is_tentative() -> None:
    """Water stays on the windscreen, while the pose trembles by a millimetre."""
    book = LowObstacleTracks(TRACKS, lambda: 0)
    for k in range(6):
        book.record([LowObservation(9.0 - 0.001 * k, -0.4, 0.4, 4.0, False)], np.array([0.001 * k, 0.0, 0.0]))
    assert len(book.tentative(np.zeros(3))) == 0


def test_tentative_tracks_have_different_identities() -> None:
    book, step = LowObstacleTracks(TRACKS, lambda: 0), SPEED_MPS / LOOKS_HZ
    for k in range(3):
        spots = [
            LowObservation(place - k * step, left, left + 0.8, 4.0, False) for place, left in ((9.0, 1.3), (11.0, -0.4))
        ]
        book.record(spots, np.array([k * step, 0.0, 0.0]))
    tentative = book.tentative(np.array([2 * step, 0.0, 0.0]))
    assert len(set(tentative.identity.tolist())) == 2


def test_weak_observations_make_a_tentative_track_and_never_confirm_it() -> None:
    step = SPEED_MPS / LOOKS_HZ
    assert suspected([(12.0 - k * step, False, False) for k in range(9)]) == [(0, 0), *[(1, 0)] * 8]
    sure = [(12.0 - k * step, k > 1, False) for k in range(6)]
    assert suspected(sure) == [(0, 0), (1, 0), (1, 0), (1, 0), (0, 1), (0, 1)]


def test_a_tentative_track_ends_with_misses_but_not_nearer_than_the_patch() -> None:
    step = SPEED_MPS / LOOKS_HZ
    far = [(12.0 - k * step, False, False) for k in range(3)] + [(np.nan, False, False)] * 5
    assert [one for one, _ in suspected(far)] == [0, 1, 1, 1, 1, 0, 0, 0]
    near = [(7.6 - k * step, False, False) for k in range(3)] + [(np.nan, False, False)] * 12
    assert [one for one, _ in suspected(near)] == [0, *[1] * 13, 0], "until the car is there"


@pytest.mark.parametrize(("gain", "looks"), [(6.0, 6), (12.0, 3), (60.0, 2)])
def test_the_fainter_an_obstacle_the_more_observations_it_takes(gain: float, looks: int) -> None:
    book, step = LowObstacleTracks(replace(TRACKS, way_m=0.5), lambda: 0), SPEED_MPS / LOOKS_HZ
    for k in range(looks):
        pose = np.array([k * step, 0.0, 0.0])
        assert not len(book.bodies(pose))
        book.record([LowObservation(12.0 - k * step, -0.4, 0.4, gain)], pose)
    assert len(book.bodies(pose)) == 1


@pytest.mark.parametrize(("height_m", "believed"), [(0.0, True), (0.9, False)])
def test_a_track_that_approaches_by_less_than_the_way_is_a_mirror_image(height_m: float, believed: bool) -> None:
    """The image of a point 0.9 m high at D lies on the road at D h / (h + 0.9), with h of the camera."""
    book, height, numbers = LowObstacleTracks(TRACKS, lambda: next(numbers)), 1.4, iter(range(9))
    share = height / (height + height_m)
    for way in np.arange(0.0, 8.0, SPEED_MPS / LOOKS_HZ).tolist():
        pose = np.array([way, 0.0, 0.0])
        book.record([LowObservation(0.8 + share * (14.0 / share - way), -0.4, 0.4, 30.0)], pose)
    assert (len(book.bodies(pose)) > 0) == believed


def test_a_drop_is_not_tentative_either() -> None:
    assert not any(one for one, _ in suspected([(8.0, True, False)] * 30))


def test_the_near_end_of_a_truncated_observation_is_no_place() -> None:
    step = SPEED_MPS / LOOKS_HZ
    assert not any(one or two for one, two in suspected([(6.7, True, True)] * 10))
    assert not any(two for _, two in suspected([(7.9, True, False), *[(6.7, True, True)] * 3]))
    seen = [(8.4 - k * step, True, False) for k in range(3)]
    assert suspected([*seen[:2], (7.0, True, True), (6.7, True, True)])[-1] == (1, 0), "too short a way"
    assert suspected(seen)[-1] == (0, 1)


def test_more_truncated_observations_confirm_a_track_that_begins_near() -> None:
    seen = [(7.9, True, False), (np.nan, False, False), *[(6.7, True, True)] * 4]
    told = suspected(seen, step_m=0.3)
    assert told[2:] == [(1, 0), (1, 0), (1, 0), (0, 1)]
    assert not any(two for _, two in suspected([(7.1, True, False), *[(6.7, True, True)] * 9], 0.3)), "a drop"


def test_a_track_of_single_flashes_is_pruned() -> None:
    assert not any(len(bodies) for bodies in recorded([12.0, np.nan, np.nan, np.nan, 9.8, np.nan, np.nan, np.nan, 7.6]))


@pytest.mark.parametrize(("flashes", "hits"), [(0, 3), (2, 7)])
def test_in_clutter_a_track_takes_more_observations(flashes: int, hits: int) -> None:
    rng, numbers = stream(33, "flashes"), iter(range(50))
    book, step = LowObstacleTracks(TRACKS, lambda: next(numbers)), SPEED_MPS / LOOKS_HZ
    for k in range(60):
        spots = [LowObservation(float(place), -2.4, -2.0, 12.0) for place in rng.uniform(7.0, 30.0, flashes)]
        if k >= 40:
            spots.append(LowObservation(13.0 - (k - 40) * step, 0.6, 1.4, 12.0))
        book.record(spots, np.array([k * step, 0.0, 0.0]))
        if np.any(book.bodies(np.array([k * step, 0.0, 0.0])).right_m > 1.0):
            break
    assert k - 40 + 1 == hits


def test_an_obstacle_hides_the_road_from_either_camera_position() -> None:
    none, config = np.full(1, np.inf), TRACKS
    body = Obstacles(np.array([8.0]), np.array([-1.0]), np.array([1.0]), np.ones(1), none, np.zeros(1, np.int64))
    lens, before = np.array([0.8, 0.0]), np.array([-4.0, 5.0])
    assert in_sight(LowObservation(12.0, -0.4, 0.4, 30.0), lens, body, config) is None
    beside, in_front = LowObservation(12.0, 2.6, 3.4, 30.0), LowObservation(7.0, -0.4, 0.4, 30.0)
    assert in_sight(beside, lens, body, config) == beside
    assert in_sight(in_front, lens, body, config) == in_front
    seen_aslant = LowObservation(12.0, -3.6, -3.0, 30.0)
    assert in_sight(seen_aslant, before, body, config) is None
    assert in_sight(seen_aslant, lens, body, config) == seen_aslant


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_visible_half_of_an_observation_is_kept(side: float) -> None:
    """From 0.8 m, what is 1.3 m aside at 8 m hides up to 1.3 * 11.2 / 7.2 = 2.02 m aside at 12 m."""
    none, config = np.full(1, np.inf), TRACKS
    body = Obstacles(np.array([8.0]), np.array([-1.0]), np.array([1.0]), np.ones(1), none, np.zeros(1, np.int64))
    lens = np.array([0.8, 0.0])
    ends = sorted((side * 1.5, side * 2.9))
    seen = in_sight(LowObservation(12.0, *ends, 30.0), lens, body, config)
    assert seen is not None
    assert (seen.left_m, seen.right_m) == pytest.approx(sorted((side * 2.02, side * 2.9)), abs=0.01)
    assert in_sight(LowObservation(12.0, *sorted((side * 1.5, side * 2.2)), 30.0), lens, body, config) is None, (
        "a rim of it"
    )


def test_wrong_parallax_settings_are_refused_with_what_was_given() -> None:
    with pytest.raises(ValueError, match=r"expected near < far, got 20\.0, 16\.0"):
        replace(CONFIG, near_m=20.0)
    with pytest.raises(ValueError, match=r"noise_far_m: expected 6\.5 to 16\.0, got 17\.0"):
        replace(CONFIG, noise_far_m=17.0)
    with pytest.raises(ValueError, match=r"tentative\.least_gain: expected <= least_gain = 6\.0, got 7\.0"):
        changed(CONFIG, {"tentative.least_gain": 7.0})


@pytest.mark.parametrize("path", list(optional_sections(CONFIG)))
def test_a_plate_is_detected_with_each_mechanism_of_the_detector_switched_off(path: str) -> None:
    found = [
        PLATE_M[0, 0] - pose[0] - spot.forward_m
        for pose, spots in looks(0.15, config=without(CONFIG, path))
        for spot in spots
    ]
    assert np.count_nonzero(np.abs(found) < 2.0) >= 3


@pytest.mark.parametrize("path", list(optional_sections(TRACKS)))
def test_an_obstacle_is_confirmed_with_each_mechanism_of_the_tracks_switched_off(path: str) -> None:
    step = SPEED_MPS / LOOKS_HZ
    found = recorded([12.0 - k * step for k in range(6)], config=without(TRACKS, path))
    assert [len(bodies) for bodies in found[:4]] == [0, 0, 1, 1]


def test_without_the_approach_rule_a_drop_is_confirmed() -> None:
    assert len(recorded([8.0] * 40, 1.0, without(TRACKS, "approach"))[-1]) == 1


def test_without_dash_rejection_a_dash_brings_the_plate_nearer() -> None:
    def nearest(config: ParallaxConfig) -> float:
        residual, off_m = PlanarParallax(CAMERA, config, LOOKS_HZ), []
        for way in np.arange(10.0, PLATE_M[0, 0] - 7.3, SPEED_MPS / LOOKS_HZ).tolist():
            pose = np.array([way, 0.02 * np.sin(way), 0.004 * np.cos(1.3 * way)])
            image = frame(way, 0.15, float(pose[1]), float(pose[2]), dash_m=3.0)
            off_m += [spot.forward_m - (PLATE_M[0, 0] - way) for spot in residual.update(image, pose) or []]
        return min(off_m)

    assert nearest(without(CONFIG, "dash")) < nearest(CONFIG)


def test_a_range_that_is_not_measured_is_the_whole_patch() -> None:
    sight = PlanarParallax(CAMERA, without(CONFIG, "sensing_range"), LOOKS_HZ).sight
    needed = sight.needed_m(5.0, 2)
    assert sight.distance_m(needed) == sight.good_m(needed) == CONFIG.far_m
