"""Sensor faults: effect and share of each, and nothing else."""

from contextlib import closing

import numpy as np
import pytest

from vpf_sim import scenarios
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.envs.sensors import CameraFaults, SignalFaults
from vpf_sim.scenarios.parts import SensorFaults
from vpf_sim.types import Floats, Image

RATE_HZ = 60.0
STATE = np.array([10.0, -20.0, 0.5, 5.0, 0.1])
BASED = 'base = "straight"\n'


def picture(k: int) -> Image:
    """(24, 32, 3) with its number encoded in every row."""
    frame = np.full((24, 32, 3), 40, np.uint8)
    frame[:, 0], frame[:, 1] = divmod(k, 200)
    return frame


def number(image: Image) -> int:
    return int(image[0, 0, 0]) * 200 + int(image[0, 1, 0])


def camera_outputs(faults: SensorFaults, count: int = 3000, seed: int = 1) -> list[tuple[Image, float]]:
    """What the driver has at each tick."""
    camera = CameraFaults(faults, RATE_HZ, seed)
    return [camera.frame(picture(k), k / RATE_HZ) for k in range(count)]


def is_intact(image: Image, k: int) -> bool:
    return bool((image == picture(k)).all())


def test_by_default_nothing_fails() -> None:
    assert not SensorFaults().affect_camera
    assert SignalFaults(SensorFaults(), 1).read(STATE, 3.0) is STATE


def test_dropped_frame_keeps_the_last_image_and_time_stamp() -> None:
    found = camera_outputs(SensorFaults(drop_share=0.2))
    stamps = np.rint([time_s * RATE_HZ for _, time_s in found]).astype(int)
    assert all(is_intact(image, stamp) for (image, _), stamp in zip(found, stamps, strict=True))
    dropped = stamps != np.arange(len(found))
    assert (np.diff(stamps)[dropped[1:]] == 0).all()
    assert dropped.mean() == pytest.approx(0.2, abs=0.03)


@pytest.mark.parametrize("latency_ms", [50.0, 100.0, 200.0])
def test_late_frame_has_its_exposure_time_stamp(latency_ms: float) -> None:
    found = camera_outputs(SensorFaults(latency_ms=latency_ms), 60)
    late = round(latency_ms * RATE_HZ / 1e3)
    expected = [max(k - late, 0) for k in range(60)]
    assert [number(image) for image, _ in found] == expected
    assert [time_s * RATE_HZ for _, time_s in found] == pytest.approx(expected)


def test_frozen_image_has_new_time_stamps_for_the_set_duration() -> None:
    found = camera_outputs(SensorFaults(freeze_share=0.3, freeze_s=0.1), 12000)
    assert [time_s * RATE_HZ for _, time_s in found] == pytest.approx(range(12000))
    numbers = np.array([number(image) for image, _ in found])
    frozen = numbers != np.arange(12000)
    assert frozen.mean() == pytest.approx(0.3, abs=0.05)
    starts = np.flatnonzero(~frozen[:-1] & frozen[1:])[:-1]
    assert all(frozen[start + 1 : start + 7].all() for start in starts)


def test_shares_of_corrupted_frames_match_and_others_are_intact() -> None:
    for key in ("black_share", "torn_share", "noise_rows_share", "exposure_jump_share"):
        found = camera_outputs(SensorFaults(**{key: 0.1}))
        corrupted = np.array([not is_intact(image, k) for k, (image, _) in enumerate(found)])
        assert corrupted.mean() == pytest.approx(0.1, abs=0.02), key
        assert not corrupted[0], key


def test_torn_frame_is_new_above_a_row_and_old_below() -> None:
    found = camera_outputs(SensorFaults(torn_share=1.0), 50)
    for k, (image, _) in enumerate(found[2:], start=2):
        new = (image == picture(k)).all(axis=(1, 2))
        row = int(np.argmin(new))
        assert 0 < row < len(new)
        assert not new[row:].any()
        assert (image[row:] == found[k - 1][0][row:]).all()


def test_an_exposure_jump_is_a_factor_of_two_a_stop() -> None:
    levels = {
        int(image[0, 5, 0])
        for image, _ in camera_outputs(SensorFaults(exposure_jump_share=0.5, exposure_jump_stops=1.0))
    }
    assert levels == {20, 40, 80}


def signal_readings(faults: SensorFaults, count: int = 3000, seed: int = 1) -> Floats:
    """(n, 5) readings of a car that accelerates."""
    signals = SignalFaults(faults, seed)
    faster = np.array([0.0, 0.0, 0.0, 0.01, 0.0])
    return np.array([signals.read(STATE + k * faster, k / RATE_HZ) for k in range(count)])


def test_stuck_speedometer_repeats_its_reading_only() -> None:
    readings = signal_readings(SensorFaults(speed_stuck_after_s=2.0), 240)
    assert readings[:, 3] == pytest.approx(5.0 + 0.01 * np.minimum(np.arange(240), 120))
    assert (readings[:, [0, 1, 2, 4]] == STATE[[0, 1, 2, 4]]).all()


def test_yaw_rate_spikes_have_the_configured_size_and_share() -> None:
    readings = signal_readings(SensorFaults(yaw_rate_spike_share=0.05, yaw_rate_spike_radps=2.0))
    off = readings[:, 4] - STATE[4]
    assert set(np.round(off, 9)) == {-2.0, 0.0, 2.0}
    assert (off != 0.0).mean() == pytest.approx(0.05, abs=0.015)
    assert (readings[:, :3] == STATE[:3]).all()


def test_seed_determines_the_faults() -> None:
    faults = SensorFaults(
        drop_share=0.1, torn_share=0.1, noise_rows_share=0.1, black_share=0.1, exposure_jump_share=0.1
    )
    first, again, other = (np.array([image for image, _ in camera_outputs(faults, 200, seed)]) for seed in (1, 1, 2))
    assert (first == again).all()
    assert (first != other).any()


def test_faults_have_independent_draws() -> None:
    alone, together = (
        [time_s for _, time_s in camera_outputs(SensorFaults(drop_share=0.1, black_share=share), 500)]
        for share in (0.0, 0.3)
    )
    assert alone == together


def scenario(faults: str) -> scenarios.Scenario:
    loaded = scenarios.parse(f"{BASED}[ego.sensor_faults]\n{faults}\n", "my.toml")
    assert isinstance(loaded, scenarios.Scenario)
    return loaded


def test_scenario_with_a_base_overrides_only_its_keys() -> None:
    base, changed = scenarios.load("straight"), scenario("drop_share = 0.1")
    assert changed.ego.sensor_faults == SensorFaults(drop_share=0.1)
    assert changed.model_copy(update={"ego": base.ego}) == base


def test_camera_faults_do_not_end_the_episode() -> None:
    with closing(FourLane(scenario("black_share = 1.0"))) as env:
        env.reset(seed=1)
        for _ in range(3):
            observed, _, terminated, truncated, info = env.step(np.zeros(2, np.float32))
        assert not observed["image"].any()
        assert observed["frame_time"] == observed["time"]
        assert observed in env.observation_space
        assert (terminated, truncated, info["status"]) == (False, False, "running")


def test_signal_faults_do_not_change_frames_and_true_state() -> None:
    found = []
    for one in (scenarios.load("straight"), scenario("speed_stuck_after_s = 0.02\nyaw_rate_spike_share = 1.0")):
        with closing(FourLane(one)) as env:
            env.reset(seed=1)
            for _ in range(4):
                observed, *_, info = env.step(np.array([1.0, 0.2], np.float32))
            found.append((observed["image"], info.get("ego", observed["ego"]), observed["ego"]))
    (image, true, read), (failing_image, failing_true, failing_read) = found
    assert (image == failing_image).all()
    assert (true == failing_true).all()
    assert (read != failing_read).tolist() == [False, False, False, True, True]
