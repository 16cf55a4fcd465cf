"""Camera height by the lanes of a rendered road."""

from dataclasses import replace

import numpy as np
import pytest
import rendered_drive as rendered
from driver_settings import ROBUST

from vpf_sim.replay import lane_height
from vpf_sim.replay.recording import Frame

CONFIG = ROBUST.road_edges


def test_height_by_lanes_is_independent_of_the_assumed_height() -> None:
    recording = rendered.recording(100.0)
    camera = replace(recording.camera, height_m=2.0)
    found = lane_height.height_m(recording.frames(), camera, recording.times_s, CONFIG)
    assert found == pytest.approx(rendered.CAMERA.height_m, rel=0.03)


def test_image_without_lanes_gives_no_height() -> None:
    recording = rendered.recording(np.inf)
    noise = np.random.default_rng(1).integers(0, 255, (480, 640, 3)).astype(np.uint8)
    grain = [Frame(k, np.roll(noise, 7 * k, axis=1)) for k in range(len(recording))]
    assert lane_height.height_m(iter(grain), recording.camera, recording.times_s, CONFIG) is None


def test_drive_of_gaps_gives_no_height() -> None:
    recording = rendered.recording(np.inf)
    gaps = iter([Frame(k, None, "lost") for k in range(len(recording))])
    assert lane_height.height_m(gaps, recording.camera, recording.times_s, CONFIG) is None
