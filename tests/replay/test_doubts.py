"""What a reader is told to doubt of a replayed drive."""

from typing import Any

import numpy as np
import pytest
from flow_made import CAMERA, anywhere, driving
from test_replay_parts import recording

from vpf_sim.replay import doubts
from vpf_sim.replay.glass_points import RidingPoints
from vpf_sim.replay.mounting_estimate import Angle
from vpf_sim.replay.recording import Origin
from vpf_sim.replay.tables import doubts as doubt_table

CLEAN = RidingPoints(CAMERA)
SURE, WIDE = Angle(0.002, 0.03, 10.0, 100.0), Angle(0.05, -0.1, 0.2, 2.0)


def record(flow: float | None = 1.0, lane: float | None = 1.0) -> dict[str, Any]:
    return {"perception": {"foe": {"share": flow}, "road_found_share": lane}}


def told(seen: dict[str, Any] | None = None, lanes_m: tuple[float, ...] = (), **changes: Any) -> dict[str, str]:
    origins = {"camera": Origin("recorded"), "speed_mps": Origin("recorded"), **changes.pop("origins", {})}
    drive = recording(10.0, origins=origins, **changes)
    return dict(doubts.lines(drive, seen or record(), CLEAN, lanes_m))


def test_a_recorded_drive_that_is_seen_well_leaves_none() -> None:
    assert told() == {}
    assert told(mounting_found={"pitch": SURE, "yaw": SURE}) == {}


def test_a_mounting_that_is_not_known_is_told_with_its_interval() -> None:
    said = told(mounting_found={"pitch": SURE, "yaw": WIDE})["mounting"]
    assert "yaw -11.3 to -0.1 deg (not used, 0 taken)" in said
    assert "pitch" not in said.split(":")[0]


def test_shares_of_frames_without_flow_or_lane_are_told() -> None:
    assert told(record(flow=0.97, lane=None)) == {}
    said = told(record(flow=0.9, lane=0.4))
    assert "10 %" in said["flow"]
    assert "60 %" in said["lane"]


@pytest.mark.parametrize(
    ("camera", "words"),
    [
        ("1.4 m above the road assumed; f = 831 px", "0.71 to 1.57 times"),
        ("1.40 m above the road by its lanes, taken to be 3.5 m wide", "0.86 to 1.14 times"),
        ("drive.toml", "as exact as the camera's height"),
    ],
)
def test_a_speed_by_the_flow_is_as_sure_as_the_height(camera: str, words: str) -> None:
    origins = {"camera": Origin("assumed", camera), "speed_mps": Origin("derived", "from the road's flow")}
    assert words in told(origins=origins)["speed"]


def test_lanes_of_an_unlikely_width_count_against_the_speed() -> None:
    how = Origin("assumed", "1.4 m above the road assumed")
    origins = {"camera": how, "speed_mps": Origin("derived", "from the road's flow")}
    assert "lanes come out 2.6 m wide" in told(lanes_m=(2.6, 2.6, 2.7), origins=origins)["speed"]
    assert "lanes come out" not in told(lanes_m=(3.4,), origins=origins)["speed"]


def test_what_rides_along_is_told_and_stands_in_the_table() -> None:
    riding = RidingPoints(CAMERA)
    for _ in range(40):
        riding.add(driving(12.0, 200, anywhere(400)))
    found = doubts.lines(recording(10.0), record(), riding, ())
    assert [what for what, _ in found] == ["reflections"]
    table = doubt_table([{"name": "a", "doubts": found}, {"name": "b", "doubts": []}])
    assert [row[:2] for row in table.rows] == [("a", "reflections")]
    assert np.all([row[2] for row in table.rows])
