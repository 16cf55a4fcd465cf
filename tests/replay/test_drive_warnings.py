"""Warnings about the reliability of a replayed drive."""

from collections.abc import Callable
from typing import Any

import made_films
import numpy as np
import pytest
from test_replay_parts import record, recording

from vpf_sim.replay import drive_record
from vpf_sim.replay.fixed_structure import FixedStructure
from vpf_sim.replay.mounting_estimate import Angle
from vpf_sim.replay.recording import IMAGES, Origin
from vpf_sim.replay.records import DriveWarning, Foe, PerceptionScores
from vpf_sim.replay.tables import warnings as warnings_table
from vpf_sim.types import Bools

SURE, WIDE = Angle(0.002, 0.03, 10.0), Angle(0.05, -0.1, 0.2)
BY_FLOW = {"speed_mps": Origin("derived", "from the road's flow", frozenset({IMAGES}))}
SHAPE = (made_films.HEIGHT_PX, made_films.WIDTH_PX)


def found_warnings(
    flow: float | None = 1.0,
    lane: float | None = 1.0,
    lanes_m: tuple[float, ...] = (),
    fixed: Bools | None = None,
    **changes: Any,
) -> dict[str, str]:
    origins = {"camera": Origin("recorded"), "speed_mps": Origin("recorded"), **changes.pop("origins", {})}
    drive = recording(10.0, origins=origins, **changes)
    perceived = PerceptionScores(
        foe=Foe(share=flow, interquartile_range_px=None),
        yaw_rate_median_error_radps=None,
        speed_scale=None,
        ttc=None,
        road_found_share=lane,
    )
    structure = None if fixed is None else FixedStructure(fixed)
    return dict(drive_record.of_recording(drive, perceived, np.array(lanes_m), structure))


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, {}),
        ({"mounting_found": {"pitch": SURE, "yaw": SURE}}, {}),
        ({"mounting_found": {"pitch": SURE, "yaw": WIDE}}, {"mounting": "yaw -11.3 to -0.1 deg (not used, 0 assumed)"}),
        ({"flow": 0.97, "lane": None}, {}),
        ({"flow": 0.9, "lane": 0.4}, {"flow": "none in 10 %", "lane": "none in 60 %"}),
        ({"assumed": frozenset({"lens"})}, {"field of view": "60 deg across, assumed; cameras have 40 to 130 deg"}),
        (
            {"origins": BY_FLOW, "lanes_m": (3.4,)},
            {"speed": "from the road's flow: 14.9 m/s in the mean, the truth may be 13.8"},
        ),
    ],
)
def test_a_drive_has_the_warnings_that_it_needs(changes: dict[str, Any], expected: dict[str, str]) -> None:
    found = found_warnings(**changes)
    assert found.keys() == expected.keys()
    assert all(found[what].startswith(why) for what, why in expected.items()), found


def test_an_unusual_lane_width_is_in_the_warning_of_the_speed() -> None:
    assert "lanes come out 2.5 m wide" in found_warnings(origins=BY_FLOW, lanes_m=(2.5, 2.5))["speed"]
    assert "lanes come out" not in found_warnings(origins=BY_FLOW, lanes_m=(3.4,))["speed"]


def painted(paint: Callable[[Any], None]) -> Bools:
    image = np.zeros((*SHAPE, 3), np.uint8)
    paint(image)
    return np.asarray(image.any(axis=2))


@pytest.mark.parametrize(
    ("paint", "third"),
    [(made_films.date_stamp, "lower"), (made_films.cabin, "lower"), (made_films.drops, ""), (made_films.watermark, "")],
)
def test_what_is_fixed_to_the_camera_is_warned_of(paint: Callable[[Any], None], third: str) -> None:
    warning = found_warnings(fixed=painted(paint))["fixed to the camera"]
    assert f"most of it in the {third}" in warning


def test_a_lead_vehicle_and_specks_are_not_warned_of() -> None:
    """A lead vehicle at a constant distance stays in place, too, as does the far end of a road."""
    mask = np.zeros(SHAPE, np.bool_)
    assert found_warnings(fixed=mask) == {}
    mask[60:200, 100:380] = True
    mask[-10:, 100:112] = True
    assert found_warnings(fixed=mask) == {}
    mask[:8, 10:34] = True  # a clock
    assert "most of it in the upper third" in found_warnings(fixed=mask)["fixed to the camera"]


def test_warnings_are_rows_of_a_table() -> None:
    warned = record("a", "").model_copy(update={"warnings": (DriveWarning("speed", "rough"),)})
    assert warnings_table([warned, record("b", "")]).rows == (("a", "speed", "rough"),)
