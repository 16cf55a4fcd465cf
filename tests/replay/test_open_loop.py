"""Predictions of a driver on rendered recordings, against the truth."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import rendered_drive as rendered

from vpf_sim.replay import frame_table, open_loop
from vpf_sim.replay.frame_table import FrameTable
from vpf_sim.replay.recording import ABSENT, Frame, Recording
from vpf_sim.seeding import stream
from vpf_sim.types import VehicleModel

SETTLED = 16  # frame from which the model vehicle is settled in a bend
BEND_M = 100.0
TRUE_STEERING = float(np.arctan(VehicleModel().wheelbase_m / BEND_M) / VehicleModel().steering_limit_rad)  # 0.039


def replayed(recording: Recording, out: Path, driver: str = "vpf") -> tuple[dict[str, Any], FrameTable]:
    record, _ = open_loop.run(recording, driver, out, with_video=False)
    return record.as_json(), frame_table.read(out / "frames" / "rendered.parquet")


@pytest.fixture(scope="module")
def bend(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], FrameTable]:
    """The bend to the right."""
    return replayed(rendered.recording(BEND_M), tmp_path_factory.mktemp("bend"))


def test_steering_in_a_right_bend_is_predicted(bend: tuple[dict[str, Any], FrameTable]) -> None:
    _, table = bend
    assert np.mean(table.road_found[SETTLED:]) > 0.9
    assert np.median(table.steering[SETTLED:]) == pytest.approx(TRUE_STEERING, abs=0.008)
    assert np.abs(table.throttle).max() < 0.02  # at its initial speed


def test_steering_in_a_left_bend_is_predicted(tmp_path: Path) -> None:
    _, table = replayed(rendered.recording(-BEND_M), tmp_path)
    assert np.median(table.steering[SETTLED:]) == pytest.approx(-TRUE_STEERING, abs=0.008)
    assert np.abs(table.throttle).max() < 0.02


def test_scene_is_planned_at_the_speed_of_the_model_vehicle(tmp_path: Path) -> None:
    """The human leaves the speed that is to be kept; the prediction does not follow, nor brake back to it."""
    drive = rendered.recording(np.inf)
    faster = replace(drive, speed_mps=drive.speed_mps + np.linspace(0.0, 3.0, len(drive)))
    _, table = replayed(faster, tmp_path)
    assert np.mean(table.road_found[SETTLED:]) > 0.9
    assert np.abs(table.throttle).max() < 0.05


def test_driven_lane_is_the_lane_to_keep(tmp_path: Path) -> None:
    """The driven lane is not the second from the right, which the driver prefers.

    The human drives 0.5 m right of the middle. The model vehicle corrects that and then drives straight on.
    """
    _, table = replayed(rendered.recording(np.inf, lane=3, right_m=0.5, frames=60), tmp_path)
    assert table.steering.min() < -0.005
    assert np.abs(table.steering).max() < 0.05
    assert np.abs(table.steering[-4:]).max() < 0.005


def test_scores_have_idle_scores_beside_them(bend: tuple[dict[str, Any], FrameTable]) -> None:
    record, _ = bend
    scores = record["accuracy"]
    assert scores["steering"]["range"] > scores["idle"]["steering"]["range"] > 0.97
    assert scores["steering"]["tolerance"] == scores["throttle"]["tolerance"] == 1.0
    count = rendered.FRAMES
    assert scores["frames"] == {"whole": count, "clear_of_obstacles": count, "with_obstacles": 0}
    assert scores["with_obstacles"] == {"throttle": None, "steering": None}
    lane = scores["lane"]
    assert lane["found"]["frames"] + lane["not_found"]["frames"] == count
    assert lane["found"]["steering"]["mae"] < lane["found"]["idle"]["mae"]
    assert record["goal"] == "the last pose of each segment"
    assert record["signal_checks"]["yaw_rate"]["gain"] == pytest.approx(1.0, abs=1e-3)


def test_ego_motion_by_flow_is_correct(bend: tuple[dict[str, Any], FrameTable]) -> None:
    record, _ = bend
    seen = record["perception"]
    assert seen["speed_scale"]["median"] == pytest.approx(1.0, abs=0.05)
    assert seen["yaw_rate_median_error_radps"] < 0.01  # of 0.08
    assert seen["foe"]["share"] > 0.95
    for key in ("foe_median_error_px", "foe_median_error_own_derotation_px"):
        assert max(record[key].values()) < 2.0, key


def test_car_in_the_lane_makes_a_part_with_obstacles(tmp_path: Path) -> None:
    _, table = replayed(rendered.recording(np.inf, body_s_m=48.0), tmp_path)
    assert table.obstacle_detected[:3].max() == 0.0
    assert table.obstacle_detected[-10:].mean() > 0.8
    assert np.abs(table.steering[-10:]).max() > 0.02 or table.throttle[-10:].min() < 0.0, "it must do something"


def test_labels_override_own_detection(tmp_path: Path) -> None:
    labels = np.zeros(rendered.FRAMES)
    labels[10:30] = 1.0
    record, _ = replayed(rendered.recording(np.inf, obstacle=labels), tmp_path, "neutral")
    assert record["obstacles_by"] == "label"
    assert record["segments"] == 3
    assert record["accuracy"]["frames"] == {"whole": 36, "clear_of_obstacles": 16, "with_obstacles": 20}


def test_gaps_hold_the_prediction_and_are_noted(bend: tuple[dict[str, Any], FrameTable], tmp_path: Path) -> None:
    whole = rendered.recording(BEND_M)
    missing = (24, 25, 26)
    gaps = replace(
        whole, frames=lambda: (Frame(f.index, None, "lost") if f.index in missing else f for f in whole.frames())
    )
    record, table = replayed(gaps, tmp_path)
    assert record["gaps"] == 3
    assert record["notes"][-1] == "gaps: lost, and 2 more"
    assert table.image[[23, 24, 27]].tolist() == [1.0, 0.0, 1.0]
    assert table.steering[:24].tolist() == bend[1].steering[:24].tolist()
    assert table.steering[24] == table.steering[23]
    assert np.isnan(table.foe_x_px[25])
    assert np.abs(table.steering[27:] - bend[1].steering[27:]).max() < 0.02  # effect of the gap alone


def test_covered_lens_holds_the_prediction_and_is_noted(tmp_path: Path) -> None:
    drive, dark = rendered.recording(BEND_M), range(20, 24)

    def frames() -> Iterator[Frame]:
        for frame in drive.frames():
            assert frame.image is not None
            yield replace(frame, image=np.full_like(frame.image, 40)) if frame.index in dark else frame

    _, table = replayed(replace(drive, frames=frames), tmp_path)
    held = table.held == 1.0
    assert held[list(dark)].all()
    assert not held[: dark.start].any()
    assert np.ptp(table.steering[dark.start - 1 : dark.stop]) == 0.0
    assert np.isnan(table.foe_x_px[list(dark)]).all()


def test_frames_without_lane_hold_course_and_speed_unscored(tmp_path: Path) -> None:
    """A road without lines, with texture for the flow."""
    grain = stream(0, "asphalt").integers(60, 160, (480, 640, 1))
    soft = cv2.GaussianBlur(grain.astype(np.float32), (0, 0), 2.0)[..., None]
    images = [np.roll(soft, 3 * k, axis=0).repeat(3, axis=2).astype(np.uint8) for k in range(20)]
    whole = rendered.recording(BEND_M, frames=20)
    record, table = replayed(
        replace(whole, frames=lambda: (Frame(k, image) for k, image in enumerate(images))), tmp_path
    )
    assert record["perception"]["road_found_share"] == 0.0
    assert np.abs(table.throttle).max() < 0.02
    assert record["restarts"] == 0
    found = record["accuracy"]
    assert (found["throttle"], found["steering"], found["frames"]["whole"]) == (None, None, 0)
    assert "lane" in [what for what, _ in record["warnings"]]


def test_without_road_the_driver_goes_straight(tmp_path: Path) -> None:
    whole = rendered.recording(np.inf)
    grey = replace(
        whole,
        frames=lambda: (Frame(f.index, np.full_like(f.image, 120)) for f in whole.frames() if f.image is not None),
    )
    record, table = replayed(grey, tmp_path)
    assert record["perception"]["road_found_share"] == 0.0
    assert np.abs(table.steering).max() < 2e-3
    assert record["perception"]["foe"]["share"] == 0.0


def test_goal_without_poses_is_ahead(tmp_path: Path) -> None:
    known = rendered.recording(np.inf)
    lost = replace(known, origins={**known.origins, "poses": ABSENT})
    record, _ = replayed(lost, tmp_path, "neutral")
    assert record["goal"] == "100 m ahead on the course at the start of each segment"
