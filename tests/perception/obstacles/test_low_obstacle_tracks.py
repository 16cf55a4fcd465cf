"""Tracks of low obstacles by observations at given places."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from driver_settings import optional_sections, static_obstacles, without

from vpf_sim.geometry import vehicle_from_world
from vpf_sim.perception.obstacles.planar_parallax.config import LowTrackConfig
from vpf_sim.perception.obstacles.planar_parallax.detector import LowObservation
from vpf_sim.perception.obstacles.planar_parallax.tracker import LowObstacleTracks, in_sight
from vpf_sim.seeding import stream
from vpf_sim.types import Obstacles

SPEED_MPS, LOOKS_HZ = 5.55, 10.0
TRACKS = static_obstacles().spots


def tracks(
    config: LowTrackConfig = TRACKS, number: Callable[[], int] = lambda: 0, near_m: float = 0.0
) -> LowObstacleTracks:
    return LowObstacleTracks(config, number, near_m, static_obstacles().behind_m)


def recorded(places_m: list[float], speed_mps: float = SPEED_MPS, config: LowTrackConfig = TRACKS) -> list[Obstacles]:
    """Confirmed tracks after each observation so far ahead, one each 0.1 s, straight on."""
    numbers = iter(range(5))
    book, found = tracks(config, lambda: next(numbers)), []
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


@pytest.mark.parametrize("bend_per_m", [-0.07, 0.0, 0.07])
@pytest.mark.parametrize(("mirrored", "told"), [(False, 1), (True, 0)])
def test_a_track_is_confirmed_as_soon_in_a_bend_and_a_mirror_image_is_not(
    bend_per_m: float, mirrored: bool, told: int
) -> None:
    """On the way of 5 m a mirror image moves on by a fifth of it, away from where the car is headed at first."""
    book, place = tracks(), np.array([13.0, 2.0 * np.sign(bend_per_m)])
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
    book, found = tracks(near_m=6.5), []
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
    book = tracks()
    for k in range(6):
        book.record([LowObservation(9.0 - 0.001 * k, -0.4, 0.4, 4.0, False)], np.array([0.001 * k, 0.0, 0.0]))
    assert len(book.tentative(np.zeros(3))) == 0


def test_tentative_tracks_have_different_identities() -> None:
    book, step = tracks(), SPEED_MPS / LOOKS_HZ
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
    book, step = tracks(replace(TRACKS, way_m=0.5), lambda: 0), SPEED_MPS / LOOKS_HZ
    for k in range(looks):
        pose = np.array([k * step, 0.0, 0.0])
        assert not len(book.bodies(pose))
        book.record([LowObservation(12.0 - k * step, -0.4, 0.4, gain)], pose)
    assert len(book.bodies(pose)) == 1


@pytest.mark.parametrize(("height_m", "believed"), [(0.0, True), (0.9, False)])
def test_a_track_that_approaches_by_less_than_the_way_is_a_mirror_image(height_m: float, believed: bool) -> None:
    """The image of a point 0.9 m high at D lies on the road at D h / (h + 0.9), with h of the camera."""
    book, height, numbers = tracks(TRACKS, lambda: next(numbers)), 1.4, iter(range(9))
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


def test_a_track_that_turns_out_to_be_road_is_removed() -> None:
    book, pose = tracks(TRACKS, lambda: 4), np.zeros(3)
    for forward in np.arange(0.0, 4.0, 0.555).tolist():
        pose = np.array([forward, 0.0, 0.0])
        book.record([LowObservation(14.0 - forward, -0.4, 0.4, 30.0)], pose)
    book.forget(3)
    assert len(book.bodies(pose)) == 1
    book.forget(4)
    assert len(book.bodies(pose)) == 0


def test_a_track_of_single_flashes_is_pruned() -> None:
    assert not any(len(bodies) for bodies in recorded([12.0, np.nan, np.nan, np.nan, 9.8, np.nan, np.nan, np.nan, 7.6]))


@pytest.mark.parametrize(("flashes", "hits"), [(0, 3), (2, 7)])
def test_in_clutter_a_track_takes_more_observations(flashes: int, hits: int) -> None:
    rng, numbers = stream(33, "flashes"), iter(range(50))
    book, step = tracks(TRACKS, lambda: next(numbers)), SPEED_MPS / LOOKS_HZ
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


@pytest.mark.parametrize("path", list(optional_sections(TRACKS)))
def test_an_obstacle_is_confirmed_with_each_mechanism_of_the_tracks_switched_off(path: str) -> None:
    step = SPEED_MPS / LOOKS_HZ
    found = recorded([12.0 - k * step for k in range(6)], config=without(TRACKS, path))
    assert [len(bodies) for bodies in found[:4]] == [0, 0, 1, 1]


def test_without_the_approach_rule_a_drop_is_confirmed() -> None:
    assert len(recorded([8.0] * 40, 1.0, without(TRACKS, "approach"))[-1]) == 1
