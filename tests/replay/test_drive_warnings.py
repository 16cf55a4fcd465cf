"""Warnings about the reliability of a replayed drive."""

from typing import Any

import numpy as np
from flow_made import CAMERA, anywhere, driving
from test_replay_parts import recording

from vpf_sim.replay import drive_warnings
from vpf_sim.replay.camera_fixed_points import CameraFixedPoints
from vpf_sim.replay.mounting_estimate import Angle
from vpf_sim.replay.recording import IMAGES, Origin
from vpf_sim.replay.tables import warnings as warnings_table

CLEAN = CameraFixedPoints(CAMERA)
SURE, WIDE = Angle(0.002, 0.03, 10.0), Angle(0.05, -0.1, 0.2)


def record(flow: float | None = 1.0, lane: float | None = 1.0) -> dict[str, Any]:
    return {"perception": {"foe": {"share": flow}, "road_found_share": lane}}


def found_warnings(
    seen: dict[str, Any] | None = None, lanes_m: tuple[float, ...] = (), **changes: Any
) -> dict[str, str]:
    origins = {"camera": Origin("recorded"), "speed_mps": Origin("recorded"), **changes.pop("origins", {})}
    drive = recording(10.0, origins=origins, **changes)
    return dict(drive_warnings.collect(drive, seen or record(), CLEAN, lanes_m))


def test_fully_recorded_drive_has_no_warnings() -> None:
    assert found_warnings() == {}
    assert found_warnings(mounting_found={"pitch": SURE, "yaw": SURE}) == {}


def test_uncertain_mounting_has_a_warning_with_its_interval() -> None:
    warning = found_warnings(mounting_found={"pitch": SURE, "yaw": WIDE})["mounting"]
    assert "yaw -11.3 to -0.1 deg (not used, 0 assumed)" in warning
    assert "pitch" not in warning.split(":")[0]


def test_share_of_frames_without_flow_or_lane_has_a_warning() -> None:
    assert found_warnings(record(flow=0.97, lane=None)) == {}
    warning = found_warnings(record(flow=0.9, lane=0.4))
    assert "10 %" in warning["flow"]
    assert "60 %" in warning["lane"]


def test_assumed_lens_has_a_warning_with_its_range() -> None:
    warning = found_warnings(assumed=frozenset({"lens"}))["field of view"]
    assert "40 to 130 deg" in warning


def test_speed_by_flow_has_its_interval_and_an_unusual_lane_width() -> None:
    origins = {"speed_mps": Origin("derived", "from the road's flow", frozenset({IMAGES}))}
    seen = {lanes_m: found_warnings(lanes_m=lanes_m, origins=origins)["speed"] for lanes_m in ((2.5, 2.5), (3.4,))}
    assert "the truth may be 13.8 to 16.1" in seen[3.4,]
    assert "lanes come out" not in seen[3.4,]
    assert "lanes come out 2.5 m wide" in seen[2.5, 2.5]


def test_camera_fixed_points_have_a_warning_in_the_table() -> None:
    fixed_points = CameraFixedPoints(CAMERA)
    for _ in range(40):
        fixed_points.add(driving(12.0, 200, anywhere(400)))
    found = drive_warnings.collect(recording(10.0), record(), fixed_points, ())
    assert [what for what, _ in found] == ["reflections"]
    table = warnings_table([{"name": "a", "warnings": found}, {"name": "b", "warnings": []}])
    assert [row[:2] for row in table.rows] == [("a", "reflections")]
    assert np.all([row[2] for row in table.rows])
