"""The ground: patches cover the view, are consistent, and can be tracked up to the horizon."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from highway_env.road.road import Road
from highway_scenes import bent_road, on_bend, straight_road

from vpf_sim.envs.camera import weather
from vpf_sim.envs.camera.ground.gains import GRADIENT, even_gains
from vpf_sim.envs.camera.ground.grain import Grain
from vpf_sim.envs.camera.ground.ground import Ground
from vpf_sim.envs.camera.ground.levels import RANGE_M, levels
from vpf_sim.envs.camera.ground.paint import ASPHALT, GRASS, LINE, Batch
from vpf_sim.envs.camera.ground.palette import RAMP, ground_table
from vpf_sim.envs.camera.ground.patches import patch_of, sample
from vpf_sim.envs.camera.ground.raster import Raster
from vpf_sim.envs.camera.ground.surface import Polygons, Surface
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.layout import lane_shapes
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.view import View
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


def ground(road: Road, seed: int = 4) -> Ground:
    return Ground(Camera(), lane_shapes(road), NOON, 0.0, seed)


def drawn(ground: Ground, view: View) -> Image:
    """(H, W) grey, 0 above the horizon."""
    frame = np.zeros((480, 640, 3), np.uint8)
    ground.draw(view, frame)
    return np.asarray(cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY), np.uint8)


def white(raster: Raster) -> Image:
    return np.full((raster.rows, raster.columns), 200, np.uint8)


@pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)
def test_patches_cover_every_row_for_any_camera_motion(camera: Camera) -> None:
    rng = np.random.default_rng(0)
    top = ground_top(camera)
    rows = np.arange(top, camera.height_px)
    falls = np.cos(camera.pitch_rad) * (rows - camera.cy_px) / camera.fy_px + np.sin(camera.pitch_rad)
    within = camera.height_m / falls < 0.95 * RANGE_M
    covered = np.zeros(len(rows), bool)
    for level in levels(camera):
        patch = patch_of(camera, level, white)
        position, yaw = np.zeros(2), 0.0
        for k in range(40):
            position, yaw = position + rng.uniform(-0.5, 1.5, 2), yaw + rng.normal(0.0, 0.08)
            view = View.at(camera, position, yaw)
            patch.update(view, may_defer=k % 3 == 0)
            for band in level.bands:
                target = np.zeros((band.last - band.first, camera.width_px), np.uint8)
                sample(patch, band, view.ground_homography(), target)
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


@pytest.mark.parametrize("fine", [(2, 2), (2, 4)])
def test_a_strip_keeps_its_width(fine: tuple[int, int]) -> None:
    """On average over many directions its area on a raster is right to 3 %; plain filling adds half a pixel all
    around."""
    lattice = np.array([[20.0, 0.0, -0.5], [0.0, 10.0, -0.5], [0.0, 0.0, 1.0]])
    raster = Raster(100, 200, lattice, 0.05, 0.1)  # 10 m square
    areas = []
    for turn in np.linspace(0.0, np.pi, 23):
        along, across = np.array([np.sin(turn), np.cos(turn)]), 0.1 * np.array([np.cos(turn), -np.sin(turn)])
        spine = np.array([5.0, 5.0]) + np.linspace(-4.0, 4.0, 4)[:, None] * along
        polygon = np.concatenate([spine - across, (spine + across)[::-1]])
        batch = Batch(polygon[None], np.array([245]), np.array([0]), thin=True)
        picture = Surface(Polygons([batch]), 1.0, fine).paint(raster).astype(float) - GRASS
        areas.append(picture.sum() / (245 - GRASS) * raster.across_m * raster.along_m)
    assert np.mean(areas) == pytest.approx(8.0 * 0.2, rel=0.03)
    assert np.std(areas) < 0.1


@pytest.mark.parametrize("beside_m", range(14, 28, 4))
@pytest.mark.parametrize("heading_deg", [70.0, 90.0, 110.0, 120.0])
def test_a_road_behind_the_camera_is_not_drawn(beside_m: int, heading_deg: float) -> None:
    """A car that left the road drives on across the grass."""
    view = View.at(Camera(), np.array([20.0, float(beside_m)]), np.radians(heading_deg))
    frame = drawn(ground(straight_road()), view)[300:]
    assert frame.min() > 0
    assert frame.max() < 130, "nothing of the road's paint"


@pytest.mark.parametrize("road", [straight_road(), bent_road()], ids=["straight", "bend"])
def test_ground_does_not_depend_on_the_camera_history(road: Road) -> None:
    """A frame hardly depends on earlier views; the sampling of patches differs."""
    travelled = ground(road)
    for k in range(61):
        place, heading = on_bend(2.0 + 0.3 * k, 1.75)
        view = View.at(Camera(), np.array(place), heading)
        frame = drawn(travelled, view)
        if k % 20 == 0:
            difference = np.abs(frame.astype(int) - drawn(ground(road), view))[240:]
            assert difference.mean() < 1.2
            assert np.percentile(difference, 99) < 12.0


def test_grain_has_the_same_gradient_in_all_rows() -> None:
    camera = Camera()
    for level, gain in zip(levels(camera), even_gains(camera), strict=True):
        patch = patch_of(camera, level, Grain(level, 5).draw)
        energy = []
        for k in range(6):
            view = View.at(camera, np.array([31.0 * k, 7.0 * k]), 0.0)
            patch.update(view, may_defer=False)
            target = np.zeros((level.bands[-1].last - level.bands[0].first, camera.width_px), np.uint8)
            for band in level.bands:
                first = band.first - level.bands[0].first
                rows = target[first : first + band.last - band.first]
                sample(patch, band, view.ground_homography(), rows)
            energy.append(np.mean(np.diff(target.astype(float), axis=1) ** 2, axis=1))
        if level.steep:
            gradient = gain[0, 0] * np.sqrt(np.mean(energy, axis=0))
            assert np.all((gradient > 0.6 * GRADIENT) & (gradient < 1.6 * GRADIENT))


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
