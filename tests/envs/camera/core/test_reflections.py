"""Reflections on the wet road against mirror geometry and the reflectance of water; spray behind objects."""

import numpy as np
import pytest
from highway_scenes import WIDTH_M, add_ego, add_object, straight_road
from wet_scene import EGO, ROAD, SKY, WALL_M, WetScene

from vpf_sim.envs.camera import Renderer, Rig, weather
from vpf_sim.envs.camera.rain.wetness import reflectance
from vpf_sim.types import Camera, Image

CAMERA = Camera()
CAMERAS = {
    "default": CAMERA,
    "pitched": Camera(pitch_rad=0.06),
    "long": Camera(width_px=800, height_px=600, fx_px=700.0, fy_px=690.0, cx_px=410.0, cy_px=280.0, height_m=1.65),
}
WALL_AT_M = 12.0


def test_reflectance_matches_tables() -> None:
    depression = np.arctan2(1.4, [3.0, 5.0, 10.0, 20.0, 40.0])
    assert reflectance(np.sin(depression)) == pytest.approx([0.087, 0.200, 0.428, 0.648, 0.804], abs=1e-3)
    assert reflectance(np.array([1.0])) == pytest.approx([(0.333 / 2.333) ** 2])
    assert reflectance(np.array([0.0])) == pytest.approx([1.0])


def row_at(camera: Camera, up_m: float, depth_m: float = WALL_AT_M) -> float:
    """The image row of a height above the road straight ahead, at a depth along the road."""
    down, c, s = camera.height_m - up_m, np.cos(camera.pitch_rad), np.sin(camera.pitch_rad)
    return float(camera.cy_px + camera.fy_px * (down * c - depth_m * s) / (depth_m * c + down * s))


@pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)
def test_a_wall_is_mirrored_down_to_its_mirrored_top(camera: Camera, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vpf_sim.envs.camera.rain.wetness.FILM_SLOPE_DEG", 0.0)  # flat water
    monkeypatch.setattr("vpf_sim.envs.camera.rain.wetness.RIPPLE", 0.0)
    column = WetScene(camera, "HardRainNoon", WALL_AT_M).draw()[:, int(camera.cx_px), 0].astype(float)
    top, foot = row_at(camera, -WALL_M[1]), row_at(camera, 0.0)
    rows = np.arange(int(foot) + 2, int(top) + 12)
    assert rows[np.argmax(np.diff(column[rows]))] == pytest.approx(top, abs=2.5)
    sides = WetScene(camera, "HardRainNoon", WALL_AT_M).draw()[int(0.5 * (top + foot)), :, 0]
    dark = np.flatnonzero(sides < 0.5 * (float(sides.max()) + float(sides[int(camera.cx_px)])))
    assert np.ptp(dark[np.abs(dark - camera.cx_px) < 100]) + 1 == pytest.approx(2.0 * camera.fx_px / WALL_AT_M, abs=4.0)


def test_reflected_sky_has_the_fresnel_level() -> None:
    frame, distance_m = WetScene(CAMERA, "HardRainNoon").draw(), np.array([5.0, 10.0, 20.0])
    rows = np.rint(CAMERA.cy_px + CAMERA.fy_px * CAMERA.height_m / distance_m).astype(int)
    share = reflectance(np.sin(np.arctan2(1.4, distance_m)))
    covered = (frame[rows][:, 300:340, 0].mean(axis=1) - ROAD) / (share * (SKY - ROAD))
    assert np.all((covered > 0.8) & (covered < 1.03))  # the film of hard rain covers nine tenths of the road or more


def test_grass_does_not_reflect() -> None:
    frame = WetScene(CAMERA, "HardRainNoon").draw()
    row = int(CAMERA.cy_px + CAMERA.fy_px * CAMERA.height_m / 12.0)
    edge_px = int(CAMERA.cx_px + CAMERA.fx_px * (3.5 * WIDTH_M + 0.5 - EGO[1]) / 12.0)
    assert np.all(frame[row, edge_px + 8 :] == ROAD)
    assert np.all(frame[row, edge_px - 30 : edge_px - 8] > ROAD + 20)


def test_film_smears_reflections_downward_with_a_dark_foot() -> None:
    tip, foot, soft = row_at(CAMERA, -1.5), row_at(CAMERA, 0.0), {}
    for name in ("SoftRainNoon", "HardRainNoon"):
        frame, without = (WetScene(CAMERA, name, wall).draw().astype(float) for wall in (WALL_AT_M, None))
        darker = (without - frame)[:, 300:340, 0].mean(axis=1)
        strongest = darker.max()
        assert darker[int(foot) + 3] > 0.5 * strongest
        assert darker[int(tip) + 60] < 0.2 * strongest
        soft[name] = np.count_nonzero((darker > 0.1 * strongest) & (darker < 0.9 * strongest))
    assert soft["SoftRainNoon"] > soft["HardRainNoon"]


def test_hidden_is_where_items_are_reflected() -> None:
    scene = WetScene(CAMERA, "HardRainNoon", WALL_AT_M)
    scene.draw()
    hidden = scene.hidden()
    foot, tip = row_at(CAMERA, 0.0), row_at(CAMERA, -1.5)
    assert hidden.shape == (CAMERA.height_px, CAMERA.width_px)
    assert hidden[int(foot) + 3 : int(tip) - 12, 300:340].all()
    assert not hidden[: int(foot) - 2, 296:343].any()  # the wall itself
    assert not hidden[:, :288].any()
    assert not hidden[:, 352:].any()
    empty = WetScene(CAMERA, "HardRainNoon")
    empty.draw()
    assert not empty.hidden().any()


def test_dry_road_has_no_reflections() -> None:
    scene = WetScene(CAMERA, "ClearNoon", WALL_AT_M)
    assert set(np.unique(scene.draw()).tolist()) == {SKY, ROAD}
    assert not scene.hidden().any()


def test_reflections_depend_on_the_moment_alone() -> None:
    """Without rain not even on the time; drops shake what stands in puddles."""
    still, shaken = WetScene(CAMERA, "WetNoon", WALL_AT_M), WetScene(CAMERA, "HardRainNoon", WALL_AT_M)
    assert np.array_equal(still.draw(0.0), still.draw(0.1))
    first, second = shaken.draw(0.0), shaken.draw(0.1)
    assert not np.array_equal(first, second)
    assert np.array_equal(WetScene(CAMERA, "HardRainNoon", WALL_AT_M).draw(0.1), second)


@pytest.mark.parametrize("camera", [Camera(cy_px=20.0, pitch_rad=0.3), Camera(cy_px=470.0, pitch_rad=-0.3)])
def test_no_reflection_without_sky_or_road(camera: Camera) -> None:
    scene = WetScene(camera, "HardRainNoon")
    assert set(np.unique(scene.draw()).tolist()) <= {SKY, ROAD}
    assert not scene.hidden().any()


# A plume needs something to leave from: the wall, which drives away from the camera.


def plume(speed_mps: float, name: str = "HardRainNoon", time_s: float = 5.0, seed: int = 1) -> np.ndarray:
    """(H, W) what spray changes, grey levels."""
    frames = [WetScene(CAMERA, name, 20.0, seed).draw(time_s, speed).astype(float) for speed in (speed_mps, 0.0)]
    return np.asarray(np.abs(frames[0] - frames[1]).sum(axis=2))


def test_spray_grows_with_speed_from_nothing_to_full() -> None:
    at = [plume(speed).sum() for speed in (3.9, 6.0, 9.0, 11.0)]
    assert at[0] == 0.0
    assert 0.0 < at[1] < at[2] < at[3]


def test_spray_grows_with_wetness_and_needs_it() -> None:
    assert plume(15.0, "FoggyNoon").sum() == 0.0
    wet, rain = (plume(11.0, name, seed=seed).sum() for name, seed in (("WetNoon", 1), ("HardRainNoon", 1)))
    assert 0.0 < wet < rain


def test_spray_lies_behind_the_object() -> None:
    """Of the object's width or somewhat more, not above it, and down to where half its speed takes a puff."""
    rows, columns = np.nonzero(plume(12.0) > 6.0)
    nearest_m = 20.0 - 0.5 * 12.0 * 0.9
    assert columns.min() > CAMERA.cx_px - 1.6 * CAMERA.fx_px / nearest_m
    assert columns.max() < CAMERA.cx_px + 1.6 * CAMERA.fx_px / nearest_m
    assert rows.min() > row_at(CAMERA, 1.9, nearest_m)
    assert rows.max() < row_at(CAMERA, 0.0, nearest_m) + 2.0
    assert rows.max() > row_at(CAMERA, 0.0, 20.0) + 3.0


def test_spray_depends_on_time_and_seed() -> None:
    assert np.array_equal(plume(11.0), plume(11.0))
    assert not np.array_equal(plume(11.0), plume(11.0, seed=2))
    totals = {float(plume(11.0, time_s=time_s).sum()) for time_s in (5.0, 5.9, 6.8)}
    assert len(totals) == 3  # a puff's life apart


def test_dense_spray_hides_and_leaves_truth_alone() -> None:
    scene = WetScene(CAMERA, "HardRainNoon", 8.0)
    instances, hidden = [], []
    for k in range(20):
        scene.draw(0.05 * k, 14.0)
        hidden.append(scene.hidden())
        instances.append(scene.core.truth()[0])
    assert all(np.array_equal(instances[0], other) for other in instances)
    on_wall = instances[0] == 1
    assert max(mask[on_wall].mean() for mask in hidden) > 0.02
    assert min(mask[on_wall].mean() for mask in hidden) < max(mask[on_wall].mean() for mask in hidden)


@pytest.mark.parametrize("name", ["WetNoon", "HardRainNoon"])
def test_a_frame_drawn_alone_is_that_of_a_drive(name: str) -> None:
    """After others, after skipped ones, or as the first; at the speed that is assumed for the time before the first."""
    road = straight_road()
    ego, car = add_ego(road, [20.0, 5.0]), add_object(road, "car", [34.0, 5.0])
    rig = Rig(Camera(160, 120, 80.0, 80.0, 79.5, 59.5))
    drive, jump, alone = (Renderer(road, rig, weather.load(name), 1) for _ in range(3))

    def go(k: int, renderer: Renderer, how: str = "render") -> None:
        ego.position, car.position = np.array([20.0 + 5.5 / 60.0 * k, 5.0]), np.array([34.0 + 0.25 * k, 5.0])
        shot[renderer] = getattr(renderer, how)(ego, k / 60.0)

    shot: dict[Renderer, Image] = {}
    for k in range(40, 90):
        go(k, drive)
        go(k, jump, "render" if k in (40, 89) else "skip")
    go(88, alone, "skip")
    go(89, alone)
    assert np.array_equal(shot[jump], shot[drive])
    assert np.array_equal(shot[alone], shot[drive])
    for other in (jump, alone):
        assert np.array_equal(other.truth(("hidden",))["hidden"], drive.truth(("hidden",))["hidden"])
