"""What is fixed to the camera is distinguished from the scene, and does not outvote it."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import made_films
import numpy as np
import pytest
from flow_made import CAMERA, anywhere, driving, flow_of
from made_films import RATE_HZ, SPEED_MPS, Paint

from vpf_sim.errors import InputError
from vpf_sim.replay import fixed_structure, readers
from vpf_sim.replay.flow_derotation import moves
from vpf_sim.replay.recording import Frame
from vpf_sim.seeding import stream
from vpf_sim.types import Image

KNOWN = "field_of_view_deg = 60.0\nheight_m = 1.4"
SECONDS, STANDS = 2.0, 24  # of a film, and frames of a stop


def standing(image: Image, frames: int = STANDS) -> list[Image]:
    """A camera that stands: one picture with the noise of a sensor."""
    noise = stream(2, "sensor of a camera that stands")
    return [np.clip(image + noise.normal(0.0, 1.5, image.shape), 0, 255).astype(np.uint8) for _ in range(frames)]


def structure(images: Sequence[Image]) -> fixed_structure.FixedStructure | None:
    def frames() -> Iterator[Frame]:
        return (Frame(k, image) for k, image in enumerate(images))

    return fixed_structure.find(frames(), np.arange(len(images)) / RATE_HZ)


def painted(paint: Paint) -> list[Image]:
    images = [np.array(image) for image in made_films.film(seconds=SECONDS)]
    for image in images:
        paint(image)
    return images


@pytest.mark.parametrize("paint", [made_films.watermark, made_films.drops, made_films.cabin, made_films.date_stamp])
def test_what_is_painted_on_a_film_is_found_and_the_road_is_not(paint: Paint) -> None:
    blank = np.zeros((made_films.HEIGHT_PX, made_films.WIDTH_PX, 3), np.uint8)
    paint(blank)
    on_top = blank.any(axis=2)
    found, clean = structure(painted(paint)), structure(made_films.film(seconds=SECONDS))
    assert found is not None
    assert clean is not None
    assert found.mask[on_top].mean() > 0.75
    assert clean.mask.mean() < 0.01
    assert found.is_visible
    assert not clean.is_visible
    assert not clean.mask[made_films.HEIGHT_PX * 2 // 3 :].any()  # solid lines stay in place, too


@pytest.mark.parametrize(
    ("paints", "speed_mps"),
    [
        ((made_films.watermark,), SPEED_MPS),
        ((made_films.drops,), SPEED_MPS),
        ((made_films.cabin,), SPEED_MPS),
        ((made_films.date_stamp, made_films.drops), 14.0),
        ((made_films.watermark,), 3.0),
    ],
    ids=["watermark", "drops", "cabin", "stamp and drops", "slow"],
)
def test_speed_is_that_of_the_scene(paints: tuple[Paint, ...], speed_mps: float, tmp_path: Path) -> None:
    images = made_films.film(speed_mps=speed_mps, seconds=SECONDS)
    drive = readers.read(made_films.write(tmp_path / "drive", images, *paints, camera=KNOWN))
    assert np.median(drive.speed_mps) == pytest.approx(speed_mps, rel=0.08)
    assert drive.speed_mps.min() > 0.8 * speed_mps
    assert np.median(np.abs(drive.yaw_rate_radps)) < 0.02
    fixed = drive.fixed_to_camera()
    assert fixed is not None
    assert fixed.is_visible


def test_structure_is_where_the_frames_of_a_yawed_camera_show_it(tmp_path: Path) -> None:
    yawed, motion = f"{KNOWN}\npitch_deg = 1.0\nyaw_deg = 5.0", (SPEED_MPS, 0.0)
    images = made_films.film(seconds=SECONDS)
    drive = readers.read(made_films.write(tmp_path / "d", images, made_films.date_stamp, camera=yawed, motion=motion))
    fixed, seen = drive.fixed_to_camera(), fixed_structure.find(drive.frames(), drive.times_s)
    assert fixed is not None
    assert seen is not None
    assert fixed.mask.shape == (drive.camera.height_px, drive.camera.width_px)
    assert (fixed.mask & seen.mask).sum() > 0.7 * (fixed.mask | seen.mask).sum()


@pytest.mark.parametrize("kind", ["covered glass", "parked car"])
def test_motion_is_unknown_where_too_little_shows_the_scene(kind: str, tmp_path: Path) -> None:
    moving, parked = made_films.film(seconds=SECONDS), standing(made_films.film(seconds=SECONDS)[0], 40)
    images, paints = (moving, (made_films.covered,)) if kind == "covered glass" else (parked, ())
    folder = made_films.write(tmp_path / "drive", images, *paints, camera=KNOWN)
    with pytest.raises(InputError, match="too few points are not fixed to the camera"):
        readers.read(folder)


def test_stop_of_a_car_with_a_dirty_glass_is_a_stop(tmp_path: Path) -> None:
    images = [*made_films.film(seconds=SECONDS)]
    images += standing(images[-1])
    drive = readers.read(made_films.write(tmp_path / "drive", images, made_films.drops, camera=KNOWN))
    assert np.median(drive.speed_mps[:-STANDS]) == pytest.approx(SPEED_MPS, rel=0.08)
    assert drive.speed_mps[-STANDS // 2 :] == pytest.approx(np.zeros(STANDS // 2))


@pytest.mark.parametrize("speed_mps", [5.0, 12.0, 30.0])
def test_car_moves_although_most_points_are_on_drops(speed_mps: float) -> None:
    """87 of 100 points, as on a wet windscreen."""
    assert moves(driving(speed_mps, 40, anywhere(268)), CAMERA)


def test_noise_and_crossing_traffic_are_no_motion_of_the_car() -> None:
    points, noise = anywhere(300), stream(1, "noise").normal(0.0, 0.05, (300, 2))
    assert not moves(flow_of(points, points + noise, 1.0), CAMERA)
    crossing = (points[:, 1] > 150.0) & (points[:, 1] < 210.0)
    assert 0.1 < crossing.mean() < 0.5
    assert not moves(flow_of(points, points - np.outer(crossing, [6.0, 0.0]), 1.0), CAMERA)
