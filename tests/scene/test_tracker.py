"""The tracker on generated detections: each track is made with noise about a known motion."""

from collections.abc import Iterator
from dataclasses import dataclass

import driver_settings
import numpy as np
import pytest
from made_scene import road

from vpf_sim.scene.tracker import Detections, SceneTracker, no_detections

CONFIG = driver_settings.scene().tracker
RATE_HZ = 20.0
SIGMAS = np.array([0.3, 0.15, 0.5, 0.5])  # s, d, along, across
GAIN = 1.5


@dataclass(frozen=True)
class Motion:
    """An actor with constant acceleration, which does not turn back."""

    s_m: float
    d_m: float = 0.0
    along_mps: float = 0.0
    across_mps: float = 0.0
    brakes_mps2: float = 0.0

    def at(self, time_s: float) -> np.ndarray:
        braked = min(time_s, self.along_mps / self.brakes_mps2) if self.brakes_mps2 else time_s
        along = self.along_mps - self.brakes_mps2 * braked
        s = self.s_m + self.along_mps * braked - 0.5 * self.brakes_mps2 * braked**2
        return np.array([s, self.d_m + self.across_mps * time_s, along, self.across_mps])


def detected(states: list[np.ndarray], random: np.random.Generator) -> Detections:
    """The states with the noise that the covariance says."""
    if not states:
        return no_detections()
    count = len(states)
    noisy = np.array(states) + SIGMAS * random.standard_normal((count, 4))
    same = np.ones(count)
    return Detections(noisy, np.tile(np.diag(SIGMAS**2), (count, 1, 1)), 4.5 * same, 1.8 * same, GAIN * same, same)


def stands(s_m: float, seed: int = 1, gain: float = GAIN) -> Iterator[Detections]:
    """Detections, each with noise of its own place, of something that is known not to move."""
    random = np.random.Generator(np.random.PCG64(seed))
    while True:
        seen = detected([Motion(s_m).at(0.0)], random)
        seen.state[:, 2:], seen.gain[:] = 0.0, gain
        yield seen


def track(
    *motions: Motion, seconds: float = 3.0, seen_until_s: float = np.inf, share: float = 1.0, seed: int = 3
) -> SceneTracker:
    """After some seconds in which a `share` of the actors' detections came, up to a time."""
    random, tracker = np.random.Generator(np.random.PCG64(seed)), SceneTracker(CONFIG)
    for index in range(round(seconds * RATE_HZ)):
        time_s = index / RATE_HZ
        tracker.predict(1.0 / RATE_HZ)
        visible = [one.at(time_s) for one in motions if time_s < seen_until_s and random.random() < share]
        tracker.update(detected(visible, random), 0.2, np.full(len(tracker.table), 0.05), 0.0)
    return tracker


MOTIONS = {
    "crossing": Motion(20.0, 4.0, across_mps=-1.5),
    "oncoming": Motion(60.0, -3.5, along_mps=-8.0),
    "standing": Motion(18.0, 1.0),
    "slowing down": Motion(10.0, along_mps=5.0, brakes_mps2=3.0),
    "passing": Motion(-10.0, -3.5, along_mps=9.0),
}


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_an_actor_is_one_track_with_its_motion(motion: Motion) -> None:
    tracker = track(motion)
    (row,) = tracker.reported
    error = tracker.table.state[row] - motion.at(3.0 - 1.0 / RATE_HZ)
    sigma = np.sqrt(np.diag(tracker.table.covariance[row]))
    assert (sigma < SIGMAS).all(), "many detections tell more than one"
    assert (np.abs(error) < 4.0 * sigma).all()


def test_all_of_them_at_once_keep_their_identities() -> None:
    tracker = track(*MOTIONS.values(), seconds=1.0)
    truth = np.array([one.at(1.0 - 1.0 / RATE_HZ) for one in MOTIONS.values()])
    state = tracker.table.state[np.argsort(tracker.table.identity)]
    assert sorted(tracker.table.identity) == [0, 1, 2, 3, 4]
    np.testing.assert_allclose(state[:, :2], truth[:, :2], atol=1.0)


def test_two_that_meet_keep_their_courses() -> None:
    """One drives past another that stands 2 m beside its way."""
    tracker = track(Motion(0.0, 0.0, along_mps=6.0), Motion(9.0, 2.0))
    state = tracker.table.state[np.argsort(tracker.table.identity)[:2]]
    state = state[np.argsort(state[:, 0])]
    np.testing.assert_allclose(state[:, 1], [2.0, 0.0], atol=0.3)
    np.testing.assert_allclose(state[:, 2], [0.0, 6.0], atol=0.6)


def test_the_reported_spread_is_that_of_the_errors() -> None:
    """The mean squared Mahalanobis distance of the four states is four."""
    squares = []
    for seed in range(60):
        tracker = track(MOTIONS["oncoming"], seconds=1.5, seed=seed)
        (row,) = tracker.reported
        error = tracker.table.state[row] - MOTIONS["oncoming"].at(1.5 - 1.0 / RATE_HZ)
        squares.append(error @ np.linalg.solve(tracker.table.covariance[row], error))
    assert 1.0 < np.mean(squares) < 5.0, "process noise allows for more than a constant speed"


def test_who_leaves_the_picture_is_expected_where_it_drove_on() -> None:
    motion = Motion(5.0, -3.5, along_mps=4.0)
    tracker = track(motion, seen_until_s=2.0, seconds=4.0)
    (row,) = tracker.reported
    error = np.abs(tracker.table.state[row] - motion.at(4.0 - 1.0 / RATE_HZ))
    assert error[0] < 4.0 * np.sqrt(tracker.table.covariance[row, 0, 0])
    assert np.sqrt(tracker.table.covariance[row, 0, 0]) > 1.5


@pytest.mark.parametrize("paint_m", [32.0, 42.0])
def test_paint_is_not_a_vehicle_that_is_out_of_sight(paint_m: float) -> None:
    """However little is known of the vehicle's place by then, some 45 m, a doubtful obstacle does not become it."""
    tracker = track(Motion(20.0, along_mps=3.5))
    for _ in range(round(4.0 * RATE_HZ)):
        tracker.predict(1.0 / RATE_HZ)
        tracker.update(no_detections(), 0.2, np.zeros(len(tracker.table)), 0.0)
    expected = tracker.table.state.copy()
    tracker.update(next(stands(paint_m, gain=-0.5)), 0.2, np.zeros(len(tracker.table)), 0.0)
    assert tracker.table.state[tracker.reported] == pytest.approx(expected)


def test_existence_falls_without_detections_until_the_track_is_pruned() -> None:
    tracker = track(Motion(12.0), seconds=1.0)
    before = float(tracker.table.gain[0])
    for _ in range(5):
        tracker.update(no_detections(), 0.2, np.full(len(tracker.table), 1.0), 0.0)
    assert float(tracker.table.gain[0]) == pytest.approx(before - 5.0)
    for _ in range(20):
        tracker.update(no_detections(), 0.2, np.full(len(tracker.table), 1.0), 0.0)
    assert not len(tracker.table)


def test_detections_that_speak_against_a_track_end_it() -> None:
    """As of an obstacle that turns out to be paint."""
    tracker = track(Motion(12.0), seconds=1.0)
    for _, against in zip(range(60), stands(12.0, gain=-0.75), strict=False):
        tracker.update(against, 0.5, np.full(len(tracker.table), 1.0 / RATE_HZ), 0.0)
    assert not len(tracker.reported)


def test_a_velocity_of_its_own_corrects_a_track() -> None:
    """A car that drove at 5 m/s and stands now, of which only the velocity is measured."""
    tracker = track(Motion(12.0, along_mps=5.0), seconds=2.0)
    for _ in range(10):
        tracker.predict(1.0 / RATE_HZ)
        tracker.correct_velocity(0, np.zeros(2), np.array([0.5, 0.4]))
    sigma = np.sqrt(np.diag(tracker.table.covariance[0]))
    assert (np.abs(tracker.table.state[0, 2:]) < 3.0 * sigma[2:]).all()
    assert (sigma[2:] < 0.5).all()


def test_a_car_that_stood_and_moves_away_is_no_longer_where_it_was() -> None:
    """A parked car pulls out at 1.2 m/s across; a detection with a memory still finds it where it stood."""
    random, tracker, across = np.random.Generator(np.random.PCG64(1)), track(Motion(12.0, -3.5), seconds=1.0), 1.2
    for _ in range(20):
        tracker.predict(1.0 / RATE_HZ)
        stood = detected([Motion(12.0, -3.5).at(0.0)], random)
        stood.state[:, 2:] = 0.0
        tracker.update(stood, 0.2, np.full(len(tracker.table), 1.0 / RATE_HZ), 0.0)
        seen = np.array([0.0, across + 0.1 * random.standard_normal()])
        tracker.see_motion(int(np.argmax(tracker.table.gain)), seen, np.array([0.5, 0.25]), 5.0)
    (row,) = tracker.reported
    assert tracker.table.state[row, 3] == pytest.approx(across, abs=0.3)
    assert tracker.table.state[row, 1] == pytest.approx(-3.5 + across * 17.0 / RATE_HZ, abs=0.3)


@pytest.mark.parametrize(("own_mps", "along_mps", "moves"), [(0.0, 3.0, True), (0.0, 0.5, False), (5.0, 2.0, False)])
def test_a_lead_car_that_drives_on_moves_but_a_wrong_distance_does_not(
    own_mps: float, along_mps: float, moves: bool
) -> None:
    tracker = track(Motion(8.0), seconds=1.0)
    for _ in range(4):
        tracker.see_motion(0, np.array([along_mps, 0.0]), np.array([0.3, 0.25]), own_mps)
    assert bool(tracker.table.state[0, 2] > 0.6 * along_mps) is moves


def test_what_stands_is_never_so_sure_that_new_evidence_does_not_count() -> None:
    """It was reported for 2 s; then four looks speak against it."""
    tracker = SceneTracker(CONFIG)
    for gain, seen in zip([4.0] * 40 + [-0.9] * 4, stands(12.0), strict=False):
        seen.gain[:] = gain
        tracker.update(seen, 1.0, np.full(len(tracker.table), 1.0 / RATE_HZ), 0.0)
        assert gain < 0.0 or len(tracker.reported)
    assert not len(tracker.reported)


def test_what_stands_keeps_its_length_when_a_part_of_it_is_left_in_view() -> None:
    tracker = SceneTracker(CONFIG)
    for length_m, seen in zip((9.0, 9.0, 1.0), stands(12.0), strict=False):
        seen.length_m[:] = length_m
        tracker.update(seen, 1.0, np.full(len(tracker.table), 1.0 / RATE_HZ), 0.0)
    assert tracker.table.length_m.tolist() == [9.0]


def test_what_is_passed_keeps_its_size() -> None:
    """A car at 12 m: its place is still reported while the vehicle passes it, and is then no longer seen."""
    tracker, looks = SceneTracker(CONFIG), ((0.0, 5.5, 2.0), (5.0, 5.5, 2.1), (10.0, 9.0, 2.4), (14.0, 9.0, 2.6))
    for (ego_m, length_m, width_m), seen in zip(looks, stands(12.0), strict=False):
        seen.length_m[:], seen.width_m[:] = length_m, width_m
        tracker.update(seen, 1.0, np.zeros(len(tracker.table)), ego_m)
    assert tracker.table.length_m.tolist() == [5.5]
    assert tracker.table.width_m.tolist() == [2.1]


def test_traffic_is_what_drives_along_the_road_in_our_direction() -> None:
    driving = track(Motion(10.0, along_mps=6.0), Motion(20.0, 4.0, across_mps=-1.5), Motion(60.0, -3.5, along_mps=-8.0))
    np.testing.assert_allclose([*driving.traffic_mps.values()], [6.0], atol=0.6)
    driving.table.length_m[:] = 0.6
    assert not driving.traffic_mps, "a pedestrian, or a handful of drops"


def test_what_appears_near_is_believed_after_some_way_only() -> None:
    """Looks in half a metre of way each, of which each adds 0.6 at most."""
    tracker, seen, looks = SceneTracker(CONFIG), stands(6.0, gain=0.6), 0
    while not len(tracker.reported):
        tracker.update(next(seen), 1.0, np.full(len(tracker.table), 1.0 / RATE_HZ), 0.0)
        looks += 1
    assert 3 <= looks <= 6


def test_repeated_observations_count_by_the_way_that_makes_them_new() -> None:
    """A car that stands looks at the same picture again and again."""
    tracker, looks = SceneTracker(CONFIG), stands(12.0)
    tracker.update(next(looks), 1.0, np.empty(0), 0.0)
    first = float(tracker.table.gain[0])
    for _ in range(10):
        tracker.update(next(looks), 0.0, np.zeros(1), 0.0)
    assert float(tracker.table.gain[0]) == first


def test_places_stay_in_the_world_when_the_road_is_estimated_anew() -> None:
    tracker = track(Motion(20.0, 2.0), seconds=0.5)
    straight, bend = road(), road(1.0 / 80.0)
    before = straight.world(*tracker.table.state[:, :2].T)
    tracker.carry(straight, bend)
    after = bend.world(*tracker.table.state[:, :2].T)
    np.testing.assert_allclose(after[:2], before[:2], atol=2e-3)


@pytest.mark.parametrize(("width_m", "stays"), [(5.5, True), (1.8, False)])
def test_two_that_are_seen_as_one_are_both_still_there(width_m: float, stays: bool) -> None:
    """Cars at d = -1.5 and 1.5, later found as one face of 5.5 m around 0; a narrow one between them is no proof."""
    tracker = track(Motion(8.0, -1.5), Motion(8.0, 1.5), seconds=2.0)
    known = set(tracker.table.identity[tracker.reported].tolist())
    assert len(known) == 2
    for _ in range(20):
        one = detected([np.array([8.0, 0.0, 0.0, 0.0])], np.random.Generator(np.random.PCG64(1)))
        one.state[:, 2:], one.width_m[:] = 0.0, width_m
        tracker.predict(1.0 / RATE_HZ)
        tracker.table.loss_per_s[:] = 20.0
        tracker.update(one, 0.0, np.full(len(tracker.table), 0.05), 0.0)
    assert (known <= set(tracker.table.identity[tracker.reported].tolist())) == stays
