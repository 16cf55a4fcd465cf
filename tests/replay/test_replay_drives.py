"""The recorded drives of the shared folder, from the folder to the table."""

import os
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from vpf_sim.replay import open_loop, readers
from vpf_sim.replay.real_table import summary
from vpf_sim.replay.records import DriveRecord

SHARED = os.environ.get("VPF_SIM_SHARED")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(not SHARED, reason="needs the recorded drives; set VPF_SIM_SHARED")]


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("replay")


@cache
def record(name: str, out: Path) -> dict[str, Any]:
    found, _ = open_loop.run(readers.read(Path(SHARED or "") / "drives" / name), "vpf", out, with_video=False)
    return found.as_json()


def test_lane_is_found_on_a_highway_without_metadata(out: Path) -> None:
    found = record("carnd_highway", out)
    assert found["origins"]["camera"]["kind"] == "assumed"
    assert 1.1 < found["camera"]["height_m"] < 1.3  # by lanes of 3.5 m; 1.18 m by marks of 3.66 m
    assert found["perception"]["road_found_share"] > 0.9
    assert found["perception"]["foe"]["share"] > 0.9
    assert found["accuracy"]["steering"]["mae"] < 0.01


def test_a_street_without_lines_gets_no_lane_and_a_warning(out: Path) -> None:
    found = record("kitti_vo_seq1", out)
    assert found["perception"]["road_found_share"] < 0.2
    assert "lane" in dict(found["warnings"])


def test_foe_and_speed_are_found_on_a_street_without_lines(out: Path) -> None:
    found = record("kitti_vo_seq1", out)
    assert max(found["foe_median_error_px"].values()) <= 2.0
    assert max(found["foe_median_error_own_derotation_px"].values()) <= 4.0
    assert found["perception"]["speed_scale"]["median"] == pytest.approx(1.0, abs=0.1)


def test_lead_vehicle_is_an_obstacle_with_ttc(out: Path) -> None:
    found = record("kitti_raw_leadcar", out)
    assert found["obstacles_by"] == "label"
    assert found["perception"]["ttc"]["median_error"] < 0.25
    assert found["perception"]["ttc"]["within_25_percent"] > 0.9


def test_foe_is_found_in_fog(out: Path) -> None:
    found = record("radiate_fog", out)
    assert found["weather"] == "fog"
    assert found["perception"]["foe"]["share"] >= 0.9
    spread_px = found["perception"]["foe"]["interquartile_range_px"]
    assert spread_px["y"] <= 3.0
    assert spread_px["x"] <= 20.0  # the yaw rate is that of lidar odometry, whose noise moves the focus sideways


@pytest.mark.parametrize("name", ["comma2k19_example", "udacity_hmb1"])
def test_signals_without_images_are_checked(name: str, out: Path) -> None:
    found = record(name, out)
    assert not found["driven"]
    assert found["accuracy"] is None
    assert "missing" in found["no_images"]
    assert 0.4 < found["signal_checks"]["yaw_rate"]["gain"] < 1.0  # cars that understeer
    assert found["signal_checks"]["yaw_rate"]["correlation"] > 0.7


def test_no_shared_drive_is_in_a_paper_cell(out: Path) -> None:
    drives = ("carnd_highway", "kitti_vo_seq1", "kitti_raw_leadcar", "radiate_fog")
    found = [DriveRecord.model_validate(record(name, out)) for name in drives]
    assert all(row.frames == 0 for row in summary(found).rows if row.paper)
