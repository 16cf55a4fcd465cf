"""The sky turns with the yaw, is periodic, and matches the weather."""

from math import radians

import cv2
import numpy as np
import pytest

from vpf_sim.envs.camera import weather
from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.core.frames import Core
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.sky.content import add_sky
from vpf_sim.types import Camera, Floats, Image

CAMERA = Camera()
SUN_AZIMUTH_DEG = weather.load("ClearSunset").sun_azimuth_angle


def sky(name: str, seed: int = 3, camera: Camera = CAMERA) -> Core:
    of = weather.load(name)
    core = Core(camera, ground_top(camera))
    add_sky(core, Light.of(of), Atmosphere.of(of), seed)
    return core


def drawn(of: Core, yaw_rad: float, place: tuple[float, float] = (0.0, 0.0), camera: Camera = CAMERA) -> Image:
    """The rows above the horizon; what is below is left black."""
    frame = np.zeros((camera.height_px, camera.width_px, 3), np.uint8)
    of.begin(*place, yaw_rad, 0.0, np.empty((0, 4)))
    of.draw_backdrop(frame)
    return frame


def turned_px(points: Floats, turn_rad: float) -> Floats:
    """(..., 2) px of points at infinity before a turn to the right."""
    ray = np.stack([(points[..., 0] - 319.5) / 320.0, (points[..., 1] - 239.5) / 320.0, np.ones(points.shape[:-1])], -1)
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    right, ahead = c * ray[..., 0] + s * ray[..., 2], c * ray[..., 2] - s * ray[..., 0]
    return np.stack([319.5 + 320.0 * right / ahead, 239.5 + 320.0 * ray[..., 1] / ahead], axis=-1)


@pytest.mark.parametrize(
    ("name", "rows", "limit_px"), [("ClearNoon", (205, 240), 0.1), ("CloudyNoon", (15, 190), 0.15)]
)
@pytest.mark.parametrize("turn_deg", [0.05, 0.15, 0.31])
def test_hills_and_clouds_move_by_the_turn(name: str, rows: tuple[int, int], limit_px: float, turn_deg: float) -> None:
    of, turn = sky(name), radians(turn_deg)
    errors = []
    for yaw in (0.4, 2.2, 4.1):
        before, now = (cv2.cvtColor(drawn(of, at), cv2.COLOR_RGB2GRAY)[:240] for at in (yaw, yaw + turn))
        mask = np.zeros_like(now)
        mask[rows[0] : rows[1], 40:-40] = 255
        corners = cv2.goodFeaturesToTrack(now, 200, 0.02, 7, mask=mask)
        options = {"winSize": (25, 25), "maxLevel": 2, "criteria": (3, 50, 0.003)}
        back, status, _ = cv2.calcOpticalFlowPyrLK(now, before, corners, None, **options)
        kept = status[:, 0] == 1
        errors.append(np.hypot(*(back[kept, 0] - turned_px(corners[kept, 0].astype(float), turn)).T))
    everything = np.concatenate(errors)
    assert len(everything) > 60
    assert np.median(everything) < limit_px
    assert np.percentile(everything, 90) < 2.5 * limit_px


@pytest.mark.parametrize("name", ["ClearNoon", "CloudyNoon", "ClearSunset", "HardRainNoon"])
def test_the_sky_is_the_same_wherever_the_car_is_and_after_a_whole_turn(name: str) -> None:
    of = sky(name)
    first = drawn(of, 1.0)
    assert np.array_equal(first, drawn(of, 1.0, (300.0, -20.0)))
    assert np.array_equal(first, drawn(of, 1.0 + 2.0 * np.pi))
    assert np.array_equal(first, drawn(of, 1.0 - 4.0 * np.pi))
    assert not np.array_equal(first, drawn(of, 1.5))


@pytest.mark.parametrize("name", ["ClearNoon", "CloudyNoon", "ClearSunset"])
def test_panorama_is_periodic(name: str) -> None:
    """Across azimuth 0 neighbouring columns differ no more than elsewhere."""
    picture = drawn(sky(name), 0.0)[:240].astype(float)
    steps = np.abs(np.diff(picture, axis=1)).mean(axis=(0, 2))
    assert steps[315:325].max() < 1.5 * np.percentile(steps, 99) + 0.2


def test_seeds_have_clouds_and_hills_of_their_own() -> None:
    one, two = (drawn(sky("CloudyNoon", seed), 0.0)[:240].astype(float) for seed in (1, 2))
    assert np.abs(one - two)[:180].mean() > 3.0
    assert np.abs(one - two)[215:].mean() > 3.0


def test_sky_fills_exactly_the_rows_above_the_horizon() -> None:
    for pitch, top in ((0.0, 240), (0.06, 221), (-0.2, 305)):
        camera = Camera(pitch_rad=pitch)
        picture = drawn(sky("CloudyNoon", camera=camera), 0.3, camera=camera)
        assert picture[:top].max(axis=2).min() > 10
        assert picture[top:].max() == 0


def test_camera_without_visible_sky_is_supported() -> None:
    camera = Camera(pitch_rad=0.45, cy_px=100.0)
    assert drawn(sky("ClearNoon", camera=camera), 0.0, camera=camera).max() == 0


def test_sun_is_drawn_at_its_direction() -> None:
    picture = drawn(sky("ClearSunset"), radians(SUN_AZIMUTH_DEG)).astype(float).sum(axis=2)
    rows, columns = np.nonzero(picture >= picture.max() - 3.0)
    assert columns.mean() == pytest.approx(319.5, abs=2.0)
    assert rows.mean() == pytest.approx(239.5 - 320.0 * np.tan(radians(15.0)), abs=2.0)
    away = drawn(sky("ClearSunset"), radians(SUN_AZIMUTH_DEG + 180.0))
    assert away.max() < 245


def test_hills_are_visible_when_clear_and_vanish_in_rain_and_fog() -> None:
    def contrast(name: str) -> float:
        picture = drawn(sky(name), 0.5)
        return float(np.abs(picture[239].astype(float) - Light.of(weather.load(name)).horizon).mean())

    assert contrast("ClearNoon") > 50.0
    assert contrast("HardRainNoon") < 4.0
    assert contrast("FoggyNoon") < 2.0


def test_clear_sky_is_blue_overcast_is_grey_and_broken_has_both() -> None:
    def blueness(name: str) -> Floats:
        picture = np.concatenate([drawn(sky(name, seed), seed)[:150] for seed in range(4)]).astype(float)
        return np.asarray(picture[..., 2] - picture[..., 0])

    assert blueness("ClearNoon").mean() > 40.0
    assert np.abs(blueness("HardRainNoon")).max() < 16.0
    broken = blueness("CloudyNoon")
    assert np.mean(broken > 30.0) > 0.1
    assert np.mean(broken < 18.0) > 0.1


def test_an_overcast_sky_is_brighter_overhead_than_at_the_horizon() -> None:
    picture = drawn(sky("HardRainNoon"), 0.0).astype(float).mean(axis=(1, 2))
    assert picture[:20].mean() > picture[220:239].mean() + 3.0


@pytest.mark.parametrize("yaw", [0.0, 1.234, 6.2, -3.3])
def test_panorama_maps_azimuth_and_elevation_to_pixels(yaw: float) -> None:
    columns, tall, camera = 512, 1.0, Camera(64, 48)
    azimuth = np.arange(columns) * 2.0 * np.pi / columns
    rows = np.linspace(tall, 0.0, 65)
    panorama = np.stack(np.broadcast_arrays(120 + 100 * np.cos(azimuth), 240 * rows[:, None], 0.0), axis=-1)
    turn, slope = np.meshgrid(np.linspace(-0.7, 0.7, 64), np.linspace(0.05, 0.95, 20))
    core = Core(camera, 20)
    per_rad = columns / (2.0 * np.pi)
    core.add_panorama(
        slice(0, 20), 1, np.rint(panorama).astype(np.uint8), per_rad, turn * per_rad, 64 * (1 - slope / tall)
    )
    picture = drawn(core, yaw, camera=camera)[:20]
    assert picture[..., 0] == pytest.approx(120 + 100 * np.cos(yaw + turn), abs=1.2)
    assert picture[..., 1] == pytest.approx(240 * slope, abs=1.2)
