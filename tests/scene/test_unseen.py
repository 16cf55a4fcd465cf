"""Traffic that a camera does not see: beside the car and behind it, on a road of three lanes."""

from dataclasses import replace

import driver_settings
import numpy as np
import pytest
from made_scene import LANE_M, followed, planner, road, scene
from made_scene import tracks as made_tracks

from vpf_sim.planning.spacetime import settings
from vpf_sim.scene.scene import EgoState
from vpf_sim.scene.tracks import Tracks
from vpf_sim.scene.unseen import UnseenTraffic

TRAFFIC_MPS = 5.0
HERE = EgoState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def unseen_traffic() -> UnseenTraffic:
    return UnseenTraffic(driver_settings.scene().unseen)


def tracks(own_mps: float, seen_mps: float = TRAFFIC_MPS, seconds: float = 2.0, d_m: float = 0.0) -> Tracks:
    """After some seconds at a speed, of which the first 1.5 s showed traffic."""
    unseen = unseen_traffic()
    for time_s in np.arange(0.0, seconds, 0.05).tolist():
        unseen.update(time_s, own_mps, {7: seen_mps} if time_s < 1.5 and seen_mps else {})
    return unseen.tracks(road(), HERE._replace(y_m=d_m, d_m=d_m, speed_mps=own_mps), seconds)


def test_a_car_that_is_slower_than_the_traffic_may_be_overtaken_in_each_lane_beside_it() -> None:
    found = tracks(2.0)
    np.testing.assert_allclose(np.unique(found.d_m), [-LANE_M, LANE_M])
    np.testing.assert_allclose(found.speed_mps, TRAFFIC_MPS)
    for d_m in (-LANE_M, LANE_M):
        begin, end = (found.x_m[found.d_m == d_m] + sign * 0.5 * found.length_m[0] for sign in (-1.0, 1.0))
        assert begin.min() < -5.0 * TRAFFIC_MPS, "who is beside it within a plan's five seconds"
        assert end.max() > 1.0
        assert (np.sort(begin)[1:] - np.sort(end)[:-1] < 4.5).all(), "no room for a car between them"
    np.testing.assert_allclose(np.unique(tracks(2.0, d_m=LANE_M).d_m), [0.0])


@pytest.mark.parametrize("seen_mps", [3.0, 30.0, 1e6])
def test_fast_traffic_is_no_more_vehicles_and_comes_for_as_long_as_a_plan_reaches(seen_mps: float) -> None:
    found = tracks(0.0, seen_mps)
    horizon_s = settings.load().candidates.horizon_s
    assert len(found) < 15
    assert (found.s_m - 0.5 * found.length_m).min() < -min(seen_mps, 40.0) * horizon_s


def test_vehicles_that_the_car_has_overtaken_must_catch_up() -> None:
    """7 s at 5 m/s past traffic of 3 m/s, which counts after 1 s, gain 14 m; a second of standing loses 3 m."""
    unseen, front_m = unseen_traffic(), []
    for time_s in np.arange(0.0, 11.001, 0.1).tolist():
        unseen.update(time_s, 5.0 if time_s <= 8.0 else 0.0, {7: 3.0})
        if time_s >= 8.5:
            found = unseen.tracks(road(), HERE, time_s)
            front_m.append((found.s_m + 0.5 * found.length_m).max())
    beside_m = tracks(0.0, seconds=1.5)
    touching_m = (beside_m.s_m + 0.5 * beside_m.length_m).max()
    assert front_m[0] == pytest.approx(touching_m - 14.0 + 1.5, abs=0.7)
    assert np.diff(front_m) == pytest.approx(0.3)


def test_a_scene_that_begins_later_counts_standing_from_there() -> None:
    unseen = unseen_traffic()
    for time_s in np.arange(300.0, 302.0, 0.1).tolist():
        unseen.update(time_s, 0.0, {7: TRAFFIC_MPS})
    assert len(unseen.tracks(road(), HERE, 302.0))


def test_what_drives_for_a_moment_only_is_no_traffic() -> None:
    """Drops on the windscreen do: each a track of its own, seen half a second."""
    unseen = unseen_traffic()
    for step in range(100):
        unseen.update(0.1 * step, 2.0, {step // 5: TRAFFIC_MPS})
    assert not len(unseen.tracks(road(), HERE._replace(speed_mps=2.0), 10.0))


def test_a_car_that_stands_aslant_may_go_on_in_its_lane() -> None:
    here = scene(road(), tracks(0.3), 0.0, -0.7, 0.3)
    aslant = replace(here, ego=here.ego._replace(yaw_rad=-0.17))
    assert planner().plan(aslant).speed_at(4.0) > 3.0


def test_it_waits_straight_in_its_lane_behind_what_has_stopped() -> None:
    """The traffic could overtake it at any time: it does not begin to turn out, little by little, while it waits."""
    on, plans, unseen = road(), planner(), unseen_traffic()
    stopped, now, stood_s = made_tracks(on, (28.0, 0.0, 0.0, 0.0, 4.5, 1.9)), scene(on, made_tracks(on)), 0.0
    while stood_s < 3.0:
        assert now.time_s < 20.0
        unseen.update(now.time_s, now.ego.speed_mps, {7: 9.0})
        motion = plans.plan(replace(now, tracks=stopped.concatenate(unseen.tracks(on, now.ego, now.time_s))))
        now = followed(now, motion, now.time_s + 0.1)
        stood_s = stood_s + 0.1 if now.ego.speed_mps < 0.3 else 0.0
    assert abs(now.ego.d_m) < 0.2
    assert abs(now.ego.yaw_rad) < 0.05
    assert 28.0 - 4.5 - now.ego.s_m > 1.5


@pytest.mark.parametrize(
    ("own_mps", "seen_mps", "seconds"),
    [(5.5, TRAFFIC_MPS, 2.0), (2.0, 0.0, 2.0), (2.0, TRAFFIC_MPS, 30.0), (0.0, TRAFFIC_MPS, 15.0)],
)
def test_no_traffic_is_expected(own_mps: float, seen_mps: float, seconds: float) -> None:
    """Of a fast car, without traffic, long after it, and of a car that has long been standing."""
    assert not len(tracks(own_mps, seen_mps, seconds))
