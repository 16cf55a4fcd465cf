"""Rendered twins: their truth by construction, and the measures that recording and twin share."""

import os
from dataclasses import replace
from math import nan
from pathlib import Path

import ideal
import numpy as np
import pytest

from vpf_sim.errors import InputError
from vpf_sim.evaluation.rendering import reference_streets
from vpf_sim.evaluation.rendering.street import START_M, Street, street_object
from vpf_sim.geometry import horizon_px
from vpf_sim.replay.frame_table import FrameRow, FrameTable
from vpf_sim.replay.recording import Recording
from vpf_sim.replay.reported_objects import columns
from vpf_sim.replay.twins import twin
from vpf_sim.replay.twins.measures import Measures
from vpf_sim.types import Camera, Floats, Obstacles, RoadEdges

SHARED = os.environ.get("VPF_SIM_SHARED")
DRIVES = Path(SHARED or "") / "drives"
needs_drives = pytest.mark.skipif(not SHARED, reason="needs the recorded drives; set VPF_SIM_SHARED")

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
    for shot in drive.shots(STREET.modified_weather(), 0, COUNT):
        truth = shot.renderer.truth(("depth", "instance"))
        depth_m = truth["depth"][truth["instance"] > 0].astype(float)
        level = np.cos(CAMERA.pitch_rad)  # depth is along the tilted axis
        assert depth_m.min() / level == pytest.approx(GAPS_M[shot.index], abs=0.35)


def test_focus_of_expansion_of_a_straight_street_is_its_vanishing_point() -> None:
    drive = STREET.drive(CAMERA, RATE_HZ, SPEEDS_MPS, GAPS_M)
    found = [shot.renderer.truth(("foe",))["foe"] for shot in drive.shots(STREET.modified_weather(), 0, 4)]
    for foe in found[1:]:
        assert foe == pytest.approx([CAMERA.cx_px, horizon_px(CAMERA)], abs=1e-6)


def test_traffic_keeps_its_speed_behind_a_slower_car() -> None:
    cars = (street_object("car", 20.0, 2, speed_mps=8.0), street_object("car", 27.0, 2, speed_mps=2.0))
    drive = replace(STREET, objects=cars, lead=None).drive(CAMERA, RATE_HZ, SPEEDS_MPS)
    for shot in drive.shots(STREET.modified_weather(), 0, 6):
        behind, ahead = (vehicle.place[0] for vehicle in shot.renderer.objects)
        time_s = shot.index / RATE_HZ
        assert (behind, ahead) == pytest.approx((START_M + 20.0 + 8.0 * time_s, START_M + 27.0 + 2.0 * time_s))


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


@pytest.mark.usefixtures("street")
def test_without_a_recorded_gap_the_lead_vehicle_keeps_its_speed(tmp_path: Path) -> None:
    made = twin.rendered(recording(np.full(COUNT, nan)), 0, tmp_path / "twin")
    assert np.isnan(made.lead_gap_m).all()


def test_a_drive_without_a_street_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^home: expected a drive with a street, kitti_vo_seq1, .*radiate_fog$"):
        twin.recorded(tmp_path / "home", tmp_path / "scratch")


def test_a_drive_without_its_video_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"carnd_highway: expected one video, found 0$"):
        twin.recorded(tmp_path / "carnd_highway", tmp_path / "scratch")


@needs_drives
def test_a_drive_of_unknown_camera_gets_the_estimated_one(tmp_path: Path) -> None:
    found, street = twin.recorded(DRIVES / "carnd_highway", tmp_path / "scratch"), twin.street_of("carnd_highway")
    assert (len(found), found.name) == (221, "carnd_highway")
    assert found.rate_hz == pytest.approx(25.0)
    assert street.camera is not None
    assert found.camera.fx_px == pytest.approx(street.camera.fx_px)
    assert horizon_px(found.camera) == pytest.approx(304.0, abs=0.1)  # where the lines of the lane meet
    assert np.all(found.speed_mps == street.speed_mps)


@needs_drives
def test_twin_of_the_lead_car_drive_has_its_frames_and_gaps(tmp_path: Path) -> None:
    drive = twin.recorded(DRIVES / "kitti_raw_leadcar", tmp_path / "recorded")
    made = twin.rendered(drive, 0, tmp_path / "twin")
    assert len(made) == len(drive) == 50
    assert made.rate_hz == pytest.approx(10.0)
    assert made.lead_gap_m == pytest.approx(drive.lead_gap_m)


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


def test_the_mean_of_measures_skips_what_is_unknown() -> None:
    one, other = Measures.of(FrameTable.of([row(0)])), Measures.of(FrameTable.of([row(0, lead_gap_m=8.0, lane_m=nan)]))
    mean = Measures.mean([one, other])
    assert (mean.lead, mean.lane_width) == (0.0, 3.5)
    assert {line["measure"]: line["recorded"] for line in one.rows(other)}["lead"] == "-"


def test_reported_objects_are_counted_by_their_place() -> None:
    edges = RoadEdges(-5.0, 5.0, 0.0, 0.0, 0.05, 1.0, 0.5, 3.0)  # the own lane from -1 to 2 m
    # forward, left, right, identity: in the lane and moving; on its left line; beside it; wide, on its right line.
    places = np.array([(12.0, 0.0, 1.6, -1.0), (7.0, -1.5, -0.9, 1.0), (9.0, -4.0, -3.0, 2.0), (30.0, 0.0, 4.4, 3.0)])
    forward, left, right, identity = places.T
    sure = np.full(4, 0.1)
    obstacles = Obstacles(forward, left, right, sure, np.full(4, 2.0), identity.astype(np.int64))
    found = columns(ideal.perception(edges, obstacles), Camera(forward_m=0.8))
    assert found["nearest_in_lane_m"] == pytest.approx(11.2)
    counts = {key.removeprefix("obstacles_"): value for key, value in found.items() if key.startswith("obstacles_")}
    assert counts == {"standing": 3, "in_lane": 1, "on_line": 2, "wide": 1}
    assert (found["obstacles"], found["flow_points"]) == (4, 0)


def test_the_own_lane_bends_with_the_road() -> None:
    edges = RoadEdges(-5.0, 5.0, 0.0, 0.01, 0.05, 1.0, 0.0, 3.0)  # 2 m to the right at 20 m
    ahead = Obstacles(*(np.array([value]) for value in (20.0, 1.5, 2.5, 0.1, 2.0)), np.array([1]))
    assert columns(ideal.perception(edges, ahead), Camera())["obstacles_in_lane"] == 1
    straight = replace(edges, curvature_per_m=0.0)
    assert columns(ideal.perception(straight, ahead), Camera())["obstacles_in_lane"] == 0
