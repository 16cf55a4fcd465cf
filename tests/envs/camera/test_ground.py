"""The ground: patches cover the view, are consistent, and can be tracked up to the horizon."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from highway_env.road.road import Road
from highway_scenes import bent_road, on_bend, straight_road

from vpf_sim.envs.camera import weather
from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.core.frames import Core, Polygons
from vpf_sim.envs.camera.ground.content import NO_POLYGONS, Grains, add_level, noise_tiles, set_ground
from vpf_sim.envs.camera.ground.even_gains import even_gains
from vpf_sim.envs.camera.ground.levels import RANGE_M, Level, levels
from vpf_sim.envs.camera.ground.paint import ASPHALT, GRASS, LINE
from vpf_sim.envs.camera.ground.palette import RAMP, ground_table
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.layout import lane_shapes
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.view import View
from vpf_sim.scenarios.parts import RoadAppearance
from vpf_sim.types import Camera, Floats, Image

NOON = Light.of(weather.load("clear"))
STEP_M = 5.55 / 60.0
CAMERAS = {
    "default": Camera(),
    "down": Camera(pitch_rad=0.49),
    "up": Camera(pitch_rad=-0.3),
    "long": Camera(width_px=800, height_px=600, fx_px=700.0, fy_px=690.0, cx_px=410.0, cy_px=280.0, height_m=1.65),
    "wide": Camera(fx_px=120.0, fy_px=120.0, pitch_rad=0.3),
    "small": Camera(width_px=64, height_px=48, fx_px=32.0, fy_px=32.0, cx_px=31.5, cy_px=23.5),
    "lorry": Camera(height_m=3.0),
}


def ground(road: Road, seed: int = 4) -> Core:
    core, camera = Core(Camera(), ground_top(Camera())), Camera()
    clear = Haze(camera, replace(Atmosphere.of(weather.load("clear")), extinction_per_m=0.0), NOON)
    set_ground(core, lane_shapes(road), NOON, 0.0, seed, RoadAppearance(), [], clear, even_gains(camera), None)
    return core


def drawn(ground: Core, view: View) -> Image:
    """(H, W) grey, 0 above the horizon."""
    frame = np.zeros((480, 640, 3), np.uint8)
    place = view.centre[:2] - view.camera.forward_m * np.array([np.cos(view.yaw_rad), np.sin(view.yaw_rad)])
    ground.begin(*place.tolist(), view.yaw_rad, 0.0, np.empty((0, 4)))
    ground.draw_backdrop(frame)
    return np.asarray(cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY), np.uint8)


def grey(camera: Camera, level: Level, polygons: Polygons) -> Core:
    """A core with one level of plain polygons, as grey as their values; 0 beside them."""
    core, ones = Core(camera, ground_top(camera)), np.ones(256, np.float32)
    greys = np.repeat(np.arange(256, dtype=np.uint8)[:, None], 3, axis=1)
    core.set_ground(greys, 1.0, 0, noise_tiles(), (ones, ones), np.empty((0, 4), np.uint8), polygons, NO_POLYGONS)
    sharp = replace(level, bands=[replace(band, faded=False) for band in level.bands])
    add_level(core, sharp, Grains.of(camera, level, 0), np.zeros((1, 2), np.float32))
    return core


@pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)
def test_patches_cover_every_row_for_any_camera_motion(camera: Camera) -> None:
    rng = np.random.default_rng(0)
    top = ground_top(camera)
    rows = np.arange(top, camera.height_px)
    falls = np.cos(camera.pitch_rad) * (rows - camera.cy_px) / camera.fy_px + np.sin(camera.pitch_rad)
    within = camera.height_m / falls < 0.95 * RANGE_M
    covered = np.zeros(len(rows), bool)
    square = 2000.0 * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    everything = np.array([0, 4]), square, np.array([200]), np.array([1e6])
    for level in levels(camera):
        core = grey(camera, level, everything)
        position, yaw = np.zeros(2), 0.0
        for _ in range(40):
            position, yaw = position + rng.uniform(-0.5, 1.5, 2), yaw + rng.normal(0.0, 0.08)
            frame = np.zeros((camera.height_px, camera.width_px, 3), np.uint8)
            core.begin(*position.tolist(), yaw, 0.0, np.empty((0, 4)))
            core.draw_backdrop(frame)
            for band in level.bands:
                target = frame[top + band.first : top + band.last, :, 0]
                assert (target[within[band.first : band.last]] == 200).all()
                covered[band.first : band.last] |= not band.faded
    assert covered.all()


def test_levels_blend_completely() -> None:
    farther = None
    for level in levels(Camera()):
        assert np.all(np.diff(level.weights[:, 0].astype(int)) > 0)
        first = level.bands[0].first
        assert len(level.weights) == sum(band.last - band.first for band in level.bands if band.faded)
        if farther is not None:
            assert first + len(level.weights) == farther.bands[-1].last  # where it is alone, the other ends
        farther = level


@pytest.mark.parametrize("width_px", [84, 640])
def test_a_strip_keeps_its_light_at_every_distance(width_px: int) -> None:
    """A line of 0.15 m along the road, near and far, at any place across: its area in each row is right on average."""
    camera = Camera(width_px, 3 * width_px // 4)
    for level in levels(camera):
        core_rows: list[Floats] = []
        for across in np.linspace(-3.0, 3.0, 25):
            strip = np.array([(-400.0, across), (400.0, across), (400.0, across + 0.15), (-400.0, across + 0.15)])
            core = grey(camera, level, (np.array([0, 4]), strip, np.array([240]), np.array([1e6])))
            frame = np.zeros((camera.height_px, camera.width_px, 3), np.uint8)
            core.begin(3.0 * across, 0.0, 0.02, 0.0, np.empty((0, 4)))
            core.draw_backdrop(frame)
            core_rows.append(frame[..., 0].sum(axis=1) / 240.0)
        for band in level.bands:
            rows = np.arange(band.first, band.last) + ground_top(camera)
            depth = camera.fy_px * camera.height_m / (rows - camera.cy_px)
            shown = (depth < 40.0) & (depth > 3.0 / (0.5 * camera.width_px / camera.fx_px) + 1.5)
            wide = camera.fx_px * 0.15 / depth
            light = np.mean(core_rows, axis=0)[rows]
            if shown.any():
                assert light[shown].sum() == pytest.approx(wide[shown].sum(), rel=0.12)


@pytest.mark.parametrize("beside_m", range(14, 28, 4))
@pytest.mark.parametrize("heading_deg", [70.0, 90.0, 110.0, 120.0])
def test_a_road_behind_the_camera_is_not_drawn(beside_m: int, heading_deg: float) -> None:
    """A car that left the road drives on across the grass."""
    view = View.at(Camera(), np.array([20.0, float(beside_m)]), np.radians(heading_deg))
    frame = drawn(ground(straight_road()), view)[300:]
    assert frame.min() > 0
    assert frame.max() < 130, "nothing of the road's paint"


def test_grain_has_the_same_gradient_in_all_rows() -> None:
    road = ground(straight_road())
    energies = []
    for k in range(8):
        frame = drawn(road, View.at(Camera(), np.array([20.0 + 9.0 * k, 90.0]), 0.0)).astype(float)
        energies.append(np.mean(np.diff(frame, axis=1) ** 2, axis=1))
    gradient = np.sqrt(np.mean(energies, axis=0))[262:470]  # of grass, 5 to 60 m ahead
    assert gradient.max() < 1.8 * gradient.min()


def flow_back(pixels: Floats, now: View, before: View) -> tuple[Floats, Floats]:
    """(N, 2) px, previous positions of ground points, and (N,) m, their depths."""
    ground_points = np.column_stack([pixels, np.ones(len(pixels))]) @ now.ground_homography().T
    world = np.column_stack([ground_points[:, :2] / ground_points[:, 2:], np.zeros(len(pixels))])
    return before.pixels(before.camera_axes(world)), now.camera_axes(world)[:, 2]


@pytest.mark.parametrize("bend", [False, True], ids=["straight", "bend"])
def test_distant_ground_can_be_tracked(bend: bool) -> None:
    """Less than 1 % of the tracks on the ground 10 to 60 m ahead have an error above one pixel."""
    none: None = None
    options = {"winSize": (25, 25), "maxLevel": 2, "criteria": (3, 30, 0.03)}
    errors = []
    for seed in (4, 11):
        road = ground(bent_road() if bend else straight_road(), seed)
        previous, before = none, none
        for k in range(31):
            place, heading = on_bend(2.0 + STEP_M * k, 1.75) if bend else ([20.0 + STEP_M * k, 7.0], 0.0)
            view = View.at(Camera(), np.array(place), heading)
            frame = drawn(road, view)
            if k % 3 == 0 and previous is not None:
                mask = np.zeros_like(frame)
                mask[246:298] = 255
                corners = cv2.goodFeaturesToTrack(frame, 300, 0.003, 8, mask=mask)
                back, _, _ = cv2.calcOpticalFlowPyrLK(frame, previous, corners, none, **options)
                forth, _, _ = cv2.calcOpticalFlowPyrLK(previous, frame, back, none, **options)
                kept = np.hypot(*(forth - corners)[:, 0].T) < 0.5
                true, depth = flow_back(corners[:, 0].astype(float), view, before)
                kept &= (depth > 10.0) & (depth < 60.0)
                errors.append(np.hypot(*(back[:, 0] - true)[kept].T))
            previous, before = frame, view
    everything = np.concatenate(errors)
    assert len(everything) > 800
    assert np.mean(everything > 1.0) < 0.01
    assert np.median(everything) < 0.12


def test_noon_shows_the_ramp_and_water_darkens_asphalt_more_than_paint() -> None:
    dry, wet = ground_table(NOON, 0.0)[:, 0].astype(float), ground_table(NOON, 1.0)[:, 0].astype(float)
    assert np.array_equal(dry[RAMP[:, 0].astype(int)], RAMP[:, 1:])
    assert wet[ASPHALT] / dry[ASPHALT] == pytest.approx(0.6, abs=0.01)  # Angstrom 1925
    assert (wet[LINE] / dry[LINE]).min() > 0.8
    saturation = [np.ptp(table[GRASS]) / table[GRASS].max() for table in (dry, wet)]
    assert saturation[1] > saturation[0]


def test_the_table_follows_the_light() -> None:
    half = replace(NOON, direct=0.5 * NOON.direct, sky=0.5 * NOON.sky)
    assert np.abs(ground_table(half, 0.0) - 0.5 * ground_table(NOON, 0.0)).max() <= 1.0
