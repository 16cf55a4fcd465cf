"""Tracks of low obstacles by observations at given places."""

from collections.abc import Callable
from dataclasses import replace
from itertools import count

import numpy as np
import pytest
from driver_settings import static_obstacles

from vpf_sim.geometry import vehicle_from_world
from vpf_sim.perception.obstacles.planar_parallax.detector import LowObservation
from vpf_sim.perception.obstacles.planar_parallax.low_obstacle_settings import LowTrackConfig
from vpf_sim.perception.obstacles.planar_parallax.tracker import LowObstacleTracks
from vpf_sim.seeding import stream
from vpf_sim.types import Obstacles

SPEED_MPS, LOOKS_HZ = 5.55, 10.0
STEP_M = SPEED_MPS / LOOKS_HZ
TRACKS = static_obstacles().low_tracks
GAIN = 12.0  # of a clear observation


def tracks(
    config: LowTrackConfig = TRACKS, number: Callable[[], int] = lambda: 0, near_m: float = 0.0
) -> LowObstacleTracks:
    return LowObstacleTracks(config, number, near_m, static_obstacles().behind_m)


def recorded(
    places_m: list[float], speed_mps: float = SPEED_MPS, config: LowTrackConfig = TRACKS, gain: float = GAIN
) -> list[Obstacles]:
    """Confirmed tracks after each observation so far ahead, one each 0.1 s, straight on."""
    numbers, found = count(), list[Obstacles]()
    book = tracks(config, lambda: next(numbers))
    for k, place in enumerate(places_m):
        pose = np.array([k * speed_mps / LOOKS_HZ, 0.0, 0.0])
        book.record([LowObservation(place, -0.4, 0.4, gain)] if np.isfinite(place) else [], pose)
        found.append(book.bodies(pose))
    return found


def test_a_track_is_confirmed_when_it_stays_in_the_world() -> None:
    found = recorded([12.0 - k * STEP_M for k in range(6)] + [np.nan] * 30)
    assert [len(bodies) for bodies in found[:4]] == [0, 0, 1, 1]
    last = found[20]
    assert last.forward_m[0] == pytest.approx(12.0 - 20 * STEP_M)
    assert (last.left_m[0], last.right_m[0]) == pytest.approx((-0.4, 0.4))
    assert {int(name) for bodies in found for name in bodies.identity} == {0}
    assert len(recorded([12.0 - k * STEP_M for k in range(6)] + [np.nan] * 40)[-1]) == 0, "pruned once passed"


@pytest.mark.parametrize("bend_per_m", [-0.07, 0.0, 0.07])
def test_a_track_is_confirmed_as_soon_in_a_bend(bend_per_m: float) -> None:
    book, place = tracks(), np.array([13.0, 2.0 * np.sign(bend_per_m)])
    for way in np.arange(0.0, 5.0, 0.5):
        turn = bend_per_m * way
        pose = np.array([way * np.sinc(turn / np.pi), 0.5 * way * turn, turn])
        ahead, aside = vehicle_from_world(place, pose)
        book.record([LowObservation(ahead, aside - 0.4, aside + 0.4, GAIN)], pose)
        if abs(way - TRACKS.way_m) > 0.1:  # the chord of a bend is a little shorter
            assert len(book.bodies(pose)) == (way > TRACKS.way_m)


def test_a_track_of_single_flashes_is_pruned() -> None:
    assert not any(len(bodies) for bodies in recorded([12.0, np.nan, np.nan, np.nan, 9.8, np.nan, np.nan, np.nan, 7.6]))


@pytest.mark.parametrize("speed_mps", [1.0, 3.0, 5.55])
def test_a_drop_that_moves_with_the_car_is_never_confirmed(speed_mps: float) -> None:
    assert not any(len(bodies) for bodies in recorded([8.0] * 40, speed_mps))


@pytest.mark.parametrize(("height_m", "confirmed"), [(0.0, True), (0.9, False)])
def test_a_track_that_approaches_by_less_than_the_way_is_a_mirror_image(height_m: float, confirmed: bool) -> None:
    """The image of a point 0.9 m high at D lies on the road at D h / (h + 0.9), with h of the camera."""
    share = 1.4 / (1.4 + height_m)
    found = recorded([0.8 + share * (14.0 / share - way) for way in np.arange(0.0, 8.0, STEP_M).tolist()])
    assert (len(found[-1]) > 0) == confirmed


@pytest.mark.parametrize(("gain", "looks"), [(6.0, 6), (12.0, 3), (60.0, 2)])
def test_the_fainter_an_obstacle_the_more_observations_it_takes(gain: float, looks: int) -> None:
    found = recorded([12.0 - k * STEP_M for k in range(looks)], config=replace(TRACKS, way_m=0.5), gain=gain)
    assert [len(bodies) for bodies in found] == [0] * (looks - 1) + [1]


@pytest.mark.parametrize(("flashes", "hits"), [(0, 3), (2, 7)])
def test_in_clutter_a_track_takes_more_observations(flashes: int, hits: int) -> None:
    rng, numbers = stream(33, "flashes"), count()
    book = tracks(TRACKS, lambda: next(numbers))
    for k in range(60):
        seen = [LowObservation(float(place), -2.4, -2.0, GAIN) for place in rng.uniform(7.0, 30.0, flashes)]
        if k >= 40:
            seen.append(LowObservation(13.0 - (k - 40) * STEP_M, 0.6, 1.4, GAIN))
        pose = np.array([k * STEP_M, 0.0, 0.0])
        book.record(seen, pose)
        if np.any(book.bodies(pose).right_m > 1.0):
            break
    assert k - 40 + 1 == hits
