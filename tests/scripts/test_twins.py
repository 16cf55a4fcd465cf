"""The twins of recorded drives: truth by construction, and the measures that a recording and its twin share."""

import os
import sys
from math import nan
from pathlib import Path

import numpy as np
import pytest

from vpf_sim.envs.camera import weather as weathers
from vpf_sim.replay.frame_table import FrameRow, FrameTable
from vpf_sim.replay.recording import Recording
from vpf_sim.types import Camera, Floats

sys.path.append(str(Path(__file__).parents[2] / "scripts" / "studies" / "twins"))
import reference_streets
import twin
from frame_statistics import FrameStatistics, measure, scaled_grey
from measures import Measures
from street import Street, street_object

SHARED = os.environ.get("VPF_SIM_SHARED")
DRIVES = Path(SHARED or "") / "drives"
needs_drives = pytest.mark.skipif(not SHARED, reason="needs the recorded drives; set VPF_SIM_SHARED")
FLAT = {"kitti_raw_leadcar": {"gradient_p50"}}  # half of its frames is vehicles, whose sides have one colour here

CAMERA = Camera(160, 120, 120.0, 120.0, 79.5, 55.5, height_m=1.2, forward_m=0.0, pitch_rad=0.05)
RATE_HZ, COUNT = 10.0, 12
GAPS_M = 9.0 - 0.4 * np.arange(COUNT)
SPEEDS_MPS = np.linspace(3.0, 1.0, COUNT)
STREET = Street(lanes=3, lane=2, weather="ClearNoon", objects=(street_object("car", 12.0, 2, speed_mps=1.0),), lead=0)


def recording(gaps_m: Floats = GAPS_M) -> Recording:
    """A recording of which only the signals matter."""
    return Recording(
        name="street",
        layout="made",
        camera=CAMERA,
        times_s=np.arange(COUNT) / RATE_HZ,
        poses=np.zeros((COUNT, 3)),
        speed_mps=SPEEDS_MPS,
        yaw_rate_radps=np.full(COUNT, 0.01),
        frames=lambda: iter(()),
        origins={},
        lead_gap_m=gaps_m,
    )


@pytest.fixture
def street(monkeypatch: pytest.MonkeyPatch) -> None:
    """The drive "street" has a street."""
    monkeypatch.setitem(reference_streets.STREETS, "street", STREET)


def test_lead_vehicle_is_drawn_at_the_recorded_gap() -> None:
    drive = STREET.drive(CAMERA, RATE_HZ, SPEEDS_MPS, GAPS_M)
    for shot in drive.shots(weathers.load(STREET.weather), 0, COUNT):
        truth = shot.renderer.truth(("depth", "instance"))
        depth_m = truth["depth"][truth["instance"] > 0].astype(float)
        level = np.cos(CAMERA.pitch_rad)  # depth is along the tilted axis
        assert depth_m.min() / level == pytest.approx(GAPS_M[shot.index], abs=0.35)


@pytest.mark.usefixtures("street")
def test_twin_is_a_recording_with_the_signals_of_the_drive(tmp_path: Path) -> None:
    made = twin.rendered(recording(), 0, tmp_path / "twin")
    assert len(made) == sum(frame.image is not None for frame in made.frames()) == COUNT
    assert made.rate_hz == pytest.approx(RATE_HZ)
    assert made.lead_gap_m == pytest.approx(GAPS_M)
    assert made.speed_mps == pytest.approx(SPEEDS_MPS)
    assert np.all(made.yaw_rate_radps == 0.0)  # the street is straight, the drive was not
    for key in ("width_px", "height_px", "fx_px", "cx_px", "cy_px", "height_m", "pitch_rad"):
        assert getattr(made.camera, key) == pytest.approx(getattr(CAMERA, key), abs=1e-6), key


def row(number: int, **values: float) -> FrameRow:
    """A frame with an image; what is not given of the driver's reports is 0."""
    known = {
        "obstacles": 0.0,
        "obstacles_standing": 0.0,
        "obstacles_in_lane": 0.0,
        "obstacles_on_line": 0.0,
        "obstacles_wide": 0.0,
        "nearest_in_lane_m": np.inf,
        "throttle": 0.0,
        "road_found": 1.0,
        "lane_m": 0.0,
        "lane_width_m": 3.5,
        "held": 0.0,
        "flow_points": 100.0,
    }
    gap_m = values.pop("lead_gap_m", nan)
    return FrameRow(number, number / 10.0, 0, 1.0, 5.0, 0.0, 0.0, 0.0, nan, gap_m, **{**known, **values})


def test_measures_are_means_over_the_frames_with_an_image() -> None:
    rows = [
        row(0, obstacles=2.0, obstacles_on_line=1.0, throttle=-0.5, lane_m=-0.2, foe_x_px=300.0),
        row(1, obstacles=1.0, obstacles_standing=1.0, throttle=-0.05, lane_m=0.2, foe_x_px=304.0),
        row(2, obstacles_wide=3.0, road_found=0.0, lane_m=nan, lane_width_m=nan, held=1.0, flow_points=40.0),
        row(3, obstacles=50.0)._replace(image=0.0),
    ]
    seen = Measures.of(FrameTable.of(rows))
    assert (seen.objects, seen.standing, seen.on_line, seen.wide) == pytest.approx((1.0, 1 / 3, 1 / 3, 1.0))
    assert (seen.braking, seen.lane, seen.held) == pytest.approx((100 / 3, 200 / 3, 100 / 3))
    assert (seen.lane_width, seen.lane_spread, seen.foe_x, seen.flow) == pytest.approx((3.5, 0.2, 2.0, 100.0))
    assert np.isnan([seen.lead, seen.lead_error]).all()


def test_lead_vehicle_counts_only_at_its_true_distance() -> None:
    gaps = {"lead_gap_m": 8.0}
    rows = [row(0, nearest_in_lane_m=8.4, **gaps), row(1, nearest_in_lane_m=5.0, **gaps), row(2, **gaps), row(3)]
    seen = Measures.of(FrameTable.of(rows))
    assert (seen.lead, seen.lead_error) == pytest.approx((100 / 3, 0.4))


@needs_drives
@pytest.mark.slow
@pytest.mark.parametrize("name", ["kitti_raw_leadcar", "carnd_highway"])
def test_rendered_frames_are_within_a_factor_of_two_of_a_dry_drive(name: str, tmp_path: Path) -> None:
    recording, street = twin.recorded(DRIVES / name, tmp_path / name), reference_streets.STREETS[name]
    real = [scaled_grey(frame.image) for frame in recording.frames() if frame.image is not None][:60]
    drive = street.drive(recording.camera, recording.rate_hz, recording.speed_mps, recording.lead_gap_m)
    rendered = [
        measure(
            [scaled_grey(shot.image) for shot in drive.shots(weathers.load(street.weather), seed, len(real))], every=5
        )
        for seed in range(3)
    ]
    ratios = FrameStatistics.mean(rendered).ratio(measure(real, every=5))
    assert {key for key, ratio in ratios.items() if not 0.5 <= ratio <= 2.0} <= FLAT.get(name, set())
