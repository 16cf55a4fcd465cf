"""The interval of a speed by the images contains the truth of films whose speed, lens and height are known."""

from pathlib import Path
from typing import Any

import made_films
import numpy as np
import pytest
from test_replay_parts import recording

from vpf_sim.replay import readers, speed_interval
from vpf_sim.replay.mounting_estimate import Angle
from vpf_sim.replay.recording import IMAGES, Origin

BY_FLOW = {"speed_mps": Origin("derived", "by the flow", frozenset({IMAGES})), "camera": Origin("recorded")}


@pytest.mark.parametrize(
    ("made", "camera", "remedy"),
    [
        ({"across_deg": 90.0, "speed_mps": 5.0}, "", "field_of_view_deg"),
        pytest.param({"across_deg": 45.0, "speed_mps": 12.0}, "", "field_of_view_deg", marks=pytest.mark.slow),
        ({"height_m": 2.3, "lines": False}, "field_of_view_deg = 60.0", "height_m"),
        ({"across_deg": 90.0}, "field_of_view_deg = 90.0\nheight_m = 1.4", ""),
    ],
    ids=["wide lens", "narrow lens", "van", "all known"],
)
def test_interval_contains_the_speed_at_which_a_film_was_made(
    made: dict[str, Any], camera: str, remedy: str, tmp_path: Path
) -> None:
    folder = made_films.write(tmp_path / "drive", made_films.film(**made, seconds=2.0), camera=camera)
    found = speed_interval.of(readers.read(folder))
    assert found is not None
    least, most = found.range_mps
    assert least < made.get("speed_mps", made_films.SPEED_MPS) < most
    if remedy:
        assert found.parts[0].remedy == remedy
        assert f"{remedy} would narrow it most" in speed_interval.text(found)
    else:
        assert found.high / found.low < 1.6


def test_recorded_speed_has_no_interval() -> None:
    assert speed_interval.of(recording(10.0, origins={"speed_mps": Origin("recorded")})) is None


def test_parts_multiply_and_the_widest_comes_first() -> None:
    drive = recording(10.0, origins=BY_FLOW, assumed=frozenset({"lens", "height"}))
    found = speed_interval.of(drive)
    assert found is not None
    assert [part.remedy for part in found.parts][:2] == ["field_of_view_deg", "height_m"]
    assert found.low == pytest.approx(np.prod([part.low for part in found.parts]))
    assert found.range_mps[1] == pytest.approx(found.mean_mps * found.high)


def test_frames_without_flow_widen_the_interval_by_what_a_car_can_do() -> None:
    """A car at 10 m/s may have braked to a stop and come back in a gap of six seconds."""
    count, unknown = 100, slice(20, 80)
    times = 0.1 * np.arange(count)
    bridged = np.zeros(count, np.bool_)
    bridged[unknown] = True
    drive = recording(10.0, origins=BY_FLOW, bridged={"speed_mps": bridged}, times_s=times)
    whole, gappy = (speed_interval.of(one) for one in (recording(10.0, origins=BY_FLOW), drive))
    assert whole is not None
    assert gappy is not None
    assert gappy.low < 0.7 * whole.low
    assert gappy.high > 1.2 * whole.high
    assert "60 % of the frames without flow" in speed_interval.text(gappy)


def test_pitch_that_is_assumed_although_the_images_give_another_widens_the_interval() -> None:
    narrow, unused = Angle(0.002, 0.1, 10.0), Angle(0.05, 0.1, 10.0)
    sure, doubtful = (
        speed_interval.of(recording(10.0, origins=BY_FLOW, mounting_found={"pitch": one})) for one in (narrow, unused)
    )
    assert sure is not None
    assert doubtful is not None
    assert doubtful.parts[0].remedy == "pitch_deg and yaw_deg"
    assert doubtful.high / doubtful.low > 2.0 * sure.high / sure.low
