"""Water added to a synthetic drive is detected, removed and scored."""

import numpy as np
import pytest
import recorded_street

from vpf_sim.envs.camera import weather
from vpf_sim.evaluation.weather import wet_glass
from vpf_sim.types import Camera

FRAMES = 13


@pytest.fixture(scope="module")
def drive() -> wet_glass.Drive:
    width, height, focal = recorded_street.WIDTH, recorded_street.HEIGHT, recorded_street.FOCAL
    camera = Camera(width, height, focal, focal, *recorded_street.CENTRE, height_m=1.65, forward_m=0.0)
    poses = recorded_street.poses(FRAMES, 8.0, 0.0, 0.0, 0.0)
    frames = [np.repeat(recorded_street.draw(pose)[..., None], 3, axis=2) for pose in poses]
    flat = np.column_stack([poses[:, 2, 3], poses[:, 0, 3], np.zeros(FRAMES)])
    truth = np.tile(recorded_street.CENTRE, (FRAMES, 1))
    return wet_glass.Drive(camera, recorded_street.RATE_HZ, flat, truth, frames)


def test_a_dry_drive_has_a_focus_and_no_water(drive: wet_glass.Drive) -> None:
    score = wet_glass.measure(drive, None, 0)
    assert np.isnan(score.iou)
    assert np.isnan(score.psnr_restored)
    assert score.foe_present == 1.0
    assert score.foe_px < 3.0
    assert score.foe_confidence > 0.3


def test_water_is_detected_and_partly_removed(drive: wet_glass.Drive) -> None:
    rain = weather.load("HardRainNoon").model_copy(update={"wiper_period_s": 0.0})
    score = wet_glass.measure(drive, rain, 0)
    assert 0.02 < score.cover < 0.5
    assert score.recall > 0.05
    assert score.precision > 2.0 * score.cover  # better than by chance
    assert score.psnr_wet < score.psnr_inpainted
    assert score.psnr_wet + 0.5 < score.psnr_restored
    assert score.masked_foe_px < 10.0


def test_gaps_are_left_out(drive: wet_glass.Drive) -> None:
    frames = [None if k == 7 else frame for k, frame in enumerate(drive.frames)]
    gapped = wet_glass.Drive(drive.camera, drive.rate_hz, drive.poses, drive.foe_px, frames)
    assert wet_glass.measure(gapped, None, 0).foe_present > 0.8


def test_psnr_is_over_the_given_pixels() -> None:
    truth, where = np.zeros((4, 4), np.uint8), np.zeros((4, 4), bool)
    image = truth.copy()
    image[0], where[0] = 255, True
    assert wet_glass.psnr(image, truth, where) == pytest.approx(0.0)
    image[0] = 51
    assert wet_glass.psnr(image, truth, where) == pytest.approx(20.0 * np.log10(5.0))
