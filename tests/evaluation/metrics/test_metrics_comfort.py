"""Comfort on motions whose derivatives are known in closed form."""

import numpy as np
import pytest
from scipy.signal import savgol_filter

from vpf_sim.evaluation.metrics.comfort import BOUNDS, comfort, nuplan_signals, raw_percentiles
from vpf_sim.evaluation.steps import Step, StepTable
from vpf_sim.types import Floats

TIME_S = np.arange(0.0, 6.0 + 1e-9, 1.0 / 60.0)


def drive(speed_mps: Floats | float, yaw_rate_radps: float = 0.0, ttc_s: float = np.inf) -> StepTable:
    """A drive at a speed over time, turning at a constant rate."""
    speed = np.broadcast_to(speed_mps, TIME_S.shape)
    return StepTable.of(
        [
            Step(t, 0.0, 0.0, yaw_rate_radps * t, v, yaw_rate_radps, 0.0, 0.0, np.inf, ttc_s=ttc_s, steering=0.0)
            for t, v in zip(TIME_S, speed, strict=True)
        ]
    )


def signals(table: StepTable) -> dict[str, Floats]:
    found = nuplan_signals(table.time_s, table.speed_mps, table.yaw_rad, table.yaw_rate_radps)
    assert found is not None
    return found


def test_a_circle_at_constant_speed_has_lateral_acceleration_v_times_yaw_rate_and_nothing_else() -> None:
    found = signals(drive(5.0, yaw_rate_radps=0.4))
    assert found["lateral_acceleration_mps2"] == pytest.approx(2.0)
    assert found["yaw_rate_radps"] == pytest.approx(0.4)
    for name in ("longitudinal_acceleration_mps2", "jerk_mps3", "longitudinal_jerk_mps3", "yaw_acceleration_radps2"):
        assert found[name] == pytest.approx(0.0, abs=1e-9)


def test_constant_braking_is_its_acceleration() -> None:
    found = signals(drive(20.0 - 3.0 * TIME_S))
    assert found["longitudinal_acceleration_mps2"] == pytest.approx(-3.0)
    assert found["longitudinal_jerk_mps3"] == pytest.approx(0.0, abs=1e-9)


def test_a_ramp_of_acceleration_is_its_jerk() -> None:
    found = signals(drive(5.0 + 0.5 * TIME_S**2))
    inside = slice(15, -15)  # at both ends the acceleration is a one-sided difference
    assert found["longitudinal_jerk_mps3"][inside] == pytest.approx(1.0, abs=1e-6)
    assert found["jerk_mps3"][inside] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("samples", [6, 7, 8, 9, 14, 15, 16, 40])
def test_the_filters_are_scipys(samples: int) -> None:
    """Also at both ends, and where a drive is shorter than their windows."""
    chance = np.random.default_rng(samples)
    time_s = np.arange(samples) / 10.0
    speed, yaw = chance.normal(5.0, 1.0, samples), chance.uniform(-1.0, 1.0, samples)
    found = nuplan_signals(time_s, speed, yaw, np.zeros(samples))
    assert found is not None
    along = savgol_filter(np.gradient(speed, time_s), min(8, samples), 2)
    jerk = savgol_filter(along, min(15, samples), 2, deriv=1, delta=0.1)
    assert found["longitudinal_acceleration_mps2"] == pytest.approx(along)
    assert found["longitudinal_jerk_mps3"] == pytest.approx(jerk)
    assert found["yaw_acceleration_radps2"] == pytest.approx(savgol_filter(yaw, 5, 3, deriv=2, delta=0.1))


def test_yaw_is_unwrapped() -> None:
    table = drive(1.0, yaw_rate_radps=0.9)
    wrapped = (table.yaw_rad + np.pi) % (2.0 * np.pi) - np.pi
    found = nuplan_signals(table.time_s, table.speed_mps, wrapped, table.yaw_rate_radps)
    assert found is not None
    assert found["yaw_rate_radps"] == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("table", "broken"),
    [
        (drive(5.55), None),
        (drive(40.0 - 4.0 * TIME_S), None),
        (drive(40.0 - 4.1 * TIME_S), "longitudinal_acceleration_mps2"),
        (drive(2.39 * TIME_S), None),
        (drive(2.41 * TIME_S), "longitudinal_acceleration_mps2"),
        (drive(5.0, yaw_rate_radps=0.94), None),
        (drive(5.0, yaw_rate_radps=-0.96), "yaw_rate_radps"),
        (drive(12.0, yaw_rate_radps=0.41), "lateral_acceleration_mps2"),
    ],
)
def test_each_bound(table: StepTable, broken: str | None) -> None:
    found = comfort(table)
    assert [name for name, row in found["signals"].items() if not row["within"]] == ([broken] if broken else [])  # type: ignore[attr-defined]
    assert found["comfortable"] is (broken is None)


@pytest.mark.parametrize(("ttc_s", "comfortable"), [(0.95, True), (0.94, False), (np.inf, True)])
def test_a_time_to_collision_below_its_bound_is_no_comfort(ttc_s: float, comfortable: bool) -> None:
    found = comfort(drive(5.0, ttc_s=ttc_s))
    assert found["comfortable"] is found["ttc_within"] is comfortable


def test_an_episode_that_is_too_short_to_filter_has_no_comfort() -> None:
    table = StepTable(drive(5.0).rows[:20])
    assert comfort(table) == dict.fromkeys(("comfortable", "signals", "min_ttc_s", "ttc_within", "raw_p95"))


def test_raw_percentiles_include_unfiltered_peaks() -> None:
    chattering = np.where(np.arange(len(TIME_S)) % 2 == 0, 5.0, 5.05)  # +-3 m/s2 at 60 Hz
    table = drive(chattering)
    assert raw_percentiles(table)["longitudinal_acceleration_mps2"] == pytest.approx(3.0)
    assert raw_percentiles(table)["longitudinal_jerk_mps3"] == pytest.approx(360.0)
    assert np.abs(signals(table)["longitudinal_acceleration_mps2"]).max() < 3.0


def test_the_bounds_are_nuplans() -> None:
    assert BOUNDS["longitudinal_acceleration_mps2"] == (-4.05, 2.40)
    assert [BOUNDS[name].high for name in list(BOUNDS)[1:]] == [4.89, 8.37, 4.13, 0.95, 1.93]
