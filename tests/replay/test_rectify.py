"""Rotated and distorted cameras, rectified to look straight ahead."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
import recorded_street as street

from vpf_sim.geometry import project
from vpf_sim.replay import rectify
from vpf_sim.replay.rectify import Lens, Mounting
from vpf_sim.types import Floats

LENS = Lens(street.WIDTH, street.HEIGHT, street.FOCAL, street.FOCAL, *street.CENTRE)
MOUNTING = Mounting(pitch_rad=0.05, yaw_rad=0.06, roll_rad=-0.04, height_m=1.65)
# In vehicle axes: forward, right, up; well inside the image.
PLACES = np.array([[20.0, 0.0, 0.0], [15.0, -3.0, 1.0], [30.0, 6.0, 3.0], [12.0, 2.5, 0.5], [60.0, 1.0, 1.65]])


def seen(lens: Lens, mounting: Mounting) -> Floats:
    """(N, 2) px of the points in the recorded frame, by OpenCV's own models."""
    rays = np.stack([PLACES[:, 1], mounting.height_m - PLACES[:, 2], PLACES[:, 0]], axis=1) @ rectify.rotation(mounting)
    still = np.zeros(3)
    if lens.model == "fisheye":
        points, _ = cv2.fisheye.projectPoints(rays.reshape(1, -1, 3), still, still, lens.matrix, lens.coefficients)
    else:
        points, _ = cv2.projectPoints(rays, still, still, lens.matrix, lens.coefficients)
    return np.asarray(points, float).reshape(-1, 2)


@pytest.mark.parametrize(
    "lens",
    [
        LENS,
        replace(LENS, distortion=(-0.25, 0.05, 0.002, -0.001)),
        replace(LENS, distortion=(-0.25, 0.05, 0.002, -0.001, 0.01)),
        replace(LENS, distortion=(0.02, -0.005, 0.001, 0.0), model="fisheye"),
    ],
)
def test_rectified_points_match_the_rectified_camera(lens: Lens) -> None:
    camera, rectify_image = rectify.rectified(lens, MOUNTING)
    assert (camera.k1, camera.k2, camera.pitch_rad, camera.height_m) == (0.0, 0.0, 0.05, 1.65)
    expected = project(camera, PLACES)
    for spot, place in zip(seen(lens, MOUNTING), expected, strict=True):
        frame = np.zeros((lens.height_px, lens.width_px, 3), np.uint8)
        cv2.circle(frame, np.rint(spot * 16).astype(int).tolist(), 4 * 16, (255, 255, 255), -1, shift=4)
        light = rectify_image(frame)[..., 0].astype(float)
        rows, columns = np.nonzero(light > 20)
        weights = light[rows, columns]
        centre = [np.average(columns, weights=weights), np.average(rows, weights=weights)]
        assert centre == pytest.approx(place, abs=0.5)


@pytest.mark.parametrize("lens", [LENS, replace(LENS, distortion=(-0.25, 0.05, 0.002, -0.001))])
def test_rectified_frame_has_no_blind_border(lens: Lens) -> None:
    """A fixed border would look like dirt on the windscreen."""
    camera, rectify_image = rectify.rectified(lens, MOUNTING)
    frame = rectify_image(np.full((lens.height_px, lens.width_px, 3), 200, np.uint8))
    assert frame.shape == (camera.height_px, camera.width_px, 3)
    assert frame.min() == 200
    assert camera.width_px * camera.height_px > 0.75 * lens.width_px * lens.height_px


def test_yawed_camera_is_rectified_to_the_straight_view() -> None:
    level = Mounting(0.05, 0.0, 0.0, 1.65)
    frames = [street.draw(np.column_stack([rectify.rotation(mounting), np.zeros(3)])) for mounting in (MOUNTING, level)]
    camera, rectify_image = rectify.rectified(LENS, MOUNTING)
    turned = rectify_image(np.repeat(frames[0][..., None], 3, axis=2))[..., 0].astype(float)
    left, top = round(LENS.cx_px - camera.cx_px), round(LENS.cy_px - camera.cy_px)
    rows = slice(max(0, -top), min(camera.height_px, LENS.height_px - top))
    columns = slice(max(0, -left), min(camera.width_px, LENS.width_px - left))
    straight = frames[1][rows.start + top : rows.stop + top, columns.start + left : columns.stop + left].astype(float)
    assert np.abs(turned[rows, columns] - straight).mean() < 0.2 * np.abs(straight - straight.mean()).mean()


def test_level_radial_camera_is_not_remapped() -> None:
    camera, rectify_image = rectify.rectified(replace(LENS, distortion=(-0.2, 0.03)), Mounting(0.03))
    frame = np.zeros((LENS.height_px, LENS.width_px, 3), np.uint8)
    assert rectify_image(frame) is frame
    assert (camera.k1, camera.k2, camera.pitch_rad) == (-0.2, 0.03, 0.03)


def test_large_frames_are_reduced_in_place() -> None:
    lens = Lens(2704, 1520, 1500.0, 1500.0, 1351.5, 759.5)
    camera, rectify_image = rectify.rectified(lens, Mounting())
    assert (camera.width_px, camera.height_px, camera.fx_px) == (901, 506, 500.0)
    frame = np.zeros((1520, 2704, 3), np.uint8)
    frame[300:303, 600:603] = 255  # a whole pixel of the reduced frame
    assert np.argwhere(rectify_image(frame)[..., 0]).tolist() == [[100, 200]]
    before = (np.array([601.0, 301.0]) - [lens.cx_px, lens.cy_px]) / lens.fx_px
    after = (np.array([200.0, 100.0]) - [camera.cx_px, camera.cy_px]) / camera.fx_px
    assert after == pytest.approx(before)


def test_mounting_inverts_rotation_and_direction() -> None:
    found = rectify.mounting_from_rotation(rectify.rotation(MOUNTING), 1.65)
    assert [found.pitch_rad, found.yaw_rad, found.roll_rad] == pytest.approx([0.05, 0.06, -0.04])
    ahead = rectify.rotation(replace(MOUNTING, roll_rad=0.0)).T @ np.array([0.0, 0.0, 1.0])
    assert ahead[0] < 0.0 < -ahead[1]  # looks right and down, so straight ahead is left and above
    seeing = rectify.mounting_from_direction(3.0 * ahead, 1.65)
    assert [seeing.pitch_rad, seeing.yaw_rad] == pytest.approx([0.05, 0.06])
