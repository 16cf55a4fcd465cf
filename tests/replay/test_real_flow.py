"""Flow, focus of expansion and time to contact on the recorded drives, if available."""

import os
from pathlib import Path

import numpy as np
import pytest

from vpf_sim.perception.egomotion import focus_of_expansion as expansion
from vpf_sim.perception.egomotion.flow import FlowTracker, grey
from vpf_sim.planning import variant
from vpf_sim.replay import readers
from vpf_sim.replay.obstacles_ahead import LeadVehicle, closing_mps
from vpf_sim.replay.recording import Recording
from vpf_sim.replay.scores import ALARM_S
from vpf_sim.seeding import stream
from vpf_sim.types import Expansion

SHARED = os.environ.get("VPF_SIM_SHARED")
pytestmark = pytest.mark.skipif(not SHARED, reason="needs the recorded drives; set VPF_SIM_SHARED")


def recording(name: str) -> Recording:
    return readers.read(Path(SHARED or "") / "drives" / name)


def foci(drive: Recording) -> list[Expansion]:
    """Of every frame but the first."""
    robust, random = variant.load("robust"), stream(0, "focus of expansion")
    tracker = FlowTracker(drive.camera, robust.flow, drive.rate_hz)
    seen: list[Expansion] = []
    for frame in drive.frames():
        assert frame.image is not None
        flow = tracker.update(grey(frame.image), drive.poses[frame.index])
        before = seen[-1] if seen else None
        seen.append(expansion.estimate(flow, drive.camera, robust.focus_of_expansion, random, before))
    return seen[1:]


def test_foe_agrees_with_the_poses_within_their_error() -> None:
    """Within two pixels; without the rotation between pose and camera axes, one in the later half."""
    drive = recording("kitti_vo_seq1")
    error = np.array([[foe.x_px, foe.y_px] for foe in foci(drive)]) - drive.foe_px[1:]
    x, y = np.nanmedian(np.abs(error), axis=0)
    assert max(x, y) <= 2.0
    offset = np.nanmedian(error[10:30], axis=0)
    assert np.nanmedian(np.abs(error[30:] - offset), axis=0).max() < 1.2


def test_wet_lens_in_fog_leaves_a_foe() -> None:
    seen = foci(recording("radiate_fog"))
    assert np.mean([foe.confidence > 0.0 for foe in seen]) >= 0.9
    place = np.array([[foe.x_px, foe.y_px] for foe in seen if foe.confidence > 0.0])
    # The drive is too short for a mounting, so the pitch is 0; a pitch from six frames would give 12 px.
    assert np.subtract(*np.quantile(place, [0.75, 0.25], axis=0)).max() <= 14.0
    dry = foci(recording("kitti_vo_seq1"))
    assert np.median([foe.confidence for foe in seen]) < 0.5 * np.median([foe.confidence for foe in dry])


def test_ttc_of_lead_vehicle_matches_lidar() -> None:
    drive = recording("kitti_raw_leadcar")
    lead, closing = LeadVehicle(drive.camera, drive.rate_hz), closing_mps(drive.lead_gap_m, drive.times_s)
    images = [frame.image for frame in drive.frames()]
    ratio = []
    for image, gap_m, speed in zip(images, drive.lead_gap_m, closing, strict=True):
        assert image is not None
        ttc_s = lead.ttc_s(grey(image), float(gap_m))
        if speed > 0.5 and not np.isnan(ttc_s):
            ratio.append(ttc_s * speed / gap_m)
    assert len(ratio) > 40
    assert np.all(np.abs(np.array(ratio) - 1.0) < 0.25)
    assert np.median(np.abs(np.array(ratio) - 1.0)) < 0.1


def test_standing_behind_a_lead_vehicle_is_no_alarm() -> None:
    """The drive ends at half a metre a second; its last image is repeated with sensor noise and flicker."""
    drive = recording("kitti_raw_leadcar")
    images = [grey(frame.image).astype(float) for frame in drive.frames() if frame.image is not None]
    noise = stream(1, "standing")
    standing = [images[-1] + noise.normal(0.0, 3.0, images[-1].shape) + noise.normal(0.0, 2.0) for _ in range(30)]
    lead = LeadVehicle(drive.camera, drive.rate_hz)
    gaps = drive.lead_gap_m[np.isfinite(drive.lead_gap_m)]
    shown = [np.clip(image, 0.0, 255.0).astype(np.uint8) for image in (*images[-10:], *standing)]
    times_s = [lead.ttc_s(image, float(gap)) for image, gap in zip(shown, [*gaps[-10:], *[gaps[-1]] * 30], strict=True)]
    assert min(times_s[5:10]) < 20.0  # it nears the car
    assert all(ttc > ALARM_S for ttc in times_s[10:])
    assert all(np.isinf(ttc) for ttc in times_s[16:])  # once the baseline has passed
