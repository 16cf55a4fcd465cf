"""The recorded drives of the shared folder: image statistics, and rendered copies of their streets."""

import os
from pathlib import Path

import numpy as np
import pytest

from vpf_sim.evaluation.rendering import reference_streets
from vpf_sim.evaluation.rendering.frame_statistics import FrameStatistics, measure, scaled_grey
from vpf_sim.evaluation.rendering.street import START_M
from vpf_sim.replay import readers
from vpf_sim.replay.recording import Recording
from vpf_sim.replay.twins import twin
from vpf_sim.types import Camera, Image

SHARED = os.environ.get("VPF_SIM_SHARED")
DRIVES = Path(SHARED or "") / "drives"
needs_drives = pytest.mark.skipif(not SHARED, reason="needs the recorded drives; set VPF_SIM_SHARED")

# Corners in the upper, middle and lower third; gradient percentiles; contrast; tracks alive after 1 and 6 frames.
KNOWN = {
    "kitti_vo_seq1": (182, 189, 29, 4.4, 26, 65, 26, 0.74, 0.39),
    "kitti_raw_leadcar": (128, 168, 104, 2.6, 28, 89, 34, 0.96, 0.87),
    "carnd_highway": (45, 287, 24, 0.6, 7, 36, 3.6, 0.94, 0.80),
    "radiate_fog": (79, 50, 22, 0.6, 2.9, 10, 5.5, 0.64, 0.27),
}

FLAT = {"kitti_raw_leadcar": {"gradient_p50"}}  # half of its frames is vehicles, whose sides have one colour here


def greys(recording: Recording) -> list[Image]:
    """The measured frames of a drive."""
    return [scaled_grey(frame.image) for frame in recording.frames() if frame.image is not None]


@needs_drives
@pytest.mark.parametrize("name", ["kitti_vo_seq1", "radiate_fog"])
def test_drive_statistics_match_earlier_measurements(name: str) -> None:
    seen = measure(greys(readers.read(DRIVES / name)), every=8)
    for key, ratio in seen.ratio(FrameStatistics(*KNOWN[name])).items():
        assert ratio == pytest.approx(1.0, abs=0.3), key


@pytest.mark.parametrize("name", reference_streets.STREETS)
def test_street_starts_at_the_start_of_the_drive(name: str) -> None:
    street = reference_streets.STREETS[name]
    scenario = street.scenario()
    assert name in KNOWN
    starts_m = [body.s_m - START_M for body in scenario.bodies]
    assert starts_m == pytest.approx([body["s_m"] for body in street.objects])
    drive = street.drive(Camera(), 10.0, np.full(2, 5.0))
    assert drive.path.offset_m(0.0) == scenario.road.lane_offset_m(street.lane) + street.lateral_m


def test_odd_width_frames_lose_their_last_column() -> None:
    drive = reference_streets.STREETS["carnd_highway"].drive(Camera(width_px=161, height_px=91), 25.0, np.full(2, 25.0))
    (shot,) = drive.shots(reference_streets.STREETS["carnd_highway"].modified_weather(), 0, 1)
    assert shot.image.shape == (91, 160, 3)


def test_drive_along_a_street_keeps_its_speed() -> None:
    street = reference_streets.STREETS["carnd_highway"]
    drive = street.drive(Camera(), 25.0, np.full(3, 25.0))
    places = np.array([shot.pose[:2] for shot in drive.shots(street.modified_weather(), 0, 3)])
    assert np.hypot(*np.diff(places, axis=0).T) == pytest.approx([1.0, 1.0])


@needs_drives
@pytest.mark.slow
@pytest.mark.parametrize("name", ["kitti_vo_seq1", "kitti_raw_leadcar", "carnd_highway"])
def test_rendered_frames_are_within_a_factor_of_two_of_a_dry_drive(name: str, tmp_path: Path) -> None:
    recording, street = twin.recorded(DRIVES / name, tmp_path / name), reference_streets.STREETS[name]
    real = greys(recording)[:60]
    drive = street.drive(recording.camera, recording.rate_hz, recording.speed_mps, recording.lead_gap_m)
    rendered = [
        measure([scaled_grey(shot.image) for shot in drive.shots(street.modified_weather(), seed, len(real))], every=5)
        for seed in range(3)
    ]
    ratios = FrameStatistics.mean(rendered).ratio(measure(real, every=5))
    assert {key for key, ratio in ratios.items() if not 0.5 <= ratio <= 2.0} <= FLAT.get(name, set())
