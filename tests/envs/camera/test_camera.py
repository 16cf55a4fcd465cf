"""Frames against pinhole geometry; frames are reproducible to the byte."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from highway_scenes import WIDTH_M, add_ego, add_object, bent_road, straight_road

from vpf_sim.envs.camera import Renderer, Rig, weather
from vpf_sim.errors import InputError
from vpf_sim.geometry import project, vehicle_from_world
from vpf_sim.types import Camera

CLEAR = weather.load("clear")
CAMERAS = {
    "default": Camera(),
    "pitched": Camera(pitch_rad=0.06),
    "long": Camera(width_px=800, height_px=600, fx_px=700.0, fy_px=690.0, cx_px=410.0, cy_px=280.0, height_m=1.65),
}


def grey(renderer, ego, time_s=0.0):
    return cv2.cvtColor(renderer.render(ego, time_s), cv2.COLOR_RGB2GRAY).astype(float)


def stripes_ahead(first, last):
    """(n, 2) world start and end of the stripes on the line between lanes 1 and 2 of the straight road."""
    starts = np.arange(np.ceil(first / 9.0), np.floor((last - 3.0) / 9.0) + 1.0) * 9.0
    return np.stack([starts, starts + 3.0], axis=1)


def half_level_crossing(profile, rising):
    """Sub-sample position at which a profile crosses the middle between its extremes."""
    level = 0.5 * (profile.min() + profile.max())
    above = profile > level
    k = int(np.argmax(above if rising else ~above))
    return k - 1 + (level - profile[k - 1]) / (profile[k] - profile[k - 1])


@pytest.fixture
def unworn(monkeypatch):
    """Markings without missing pieces, with exact edges."""
    monkeypatch.setattr("vpf_sim.envs.camera.ground.paint.flakes", lambda *_: np.empty((0, 4, 2)))


@pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)
def test_sides_of_stripes_lie_where_projected(camera, unworn):  # noqa: ARG001
    road = straight_road()
    ego = add_ego(road, [20.0, WIDTH_M * 1.5 - 0.7])
    renderer = Renderer(road, Rig(camera, noise_sd=0.0), CLEAR, 1)
    picture = grey(renderer, ego)
    pose = np.array([*ego.position, ego.heading])
    errors = []
    for start, end in stripes_ahead(26.0, 47.0):
        for share in (0.3, 0.5, 0.7):
            x = start + share * (end - start)
            sides = vehicle_from_world(np.array([[x, 1.5 * WIDTH_M - 0.075], [x, 1.5 * WIDTH_M + 0.075]]), pose)
            (left, row), (right, _) = project(camera, np.column_stack([sides, np.zeros(2)]))
            if not 0 < row < camera.height_px - 1:
                continue
            margin = 3.0 + 0.5 * (right - left)
            columns = np.arange(int(left - margin), int(right + margin) + 2)
            low = int(np.floor(row))
            profile = picture[low, columns] + (row - low) * (picture[low + 1, columns] - picture[low, columns])
            middle = len(columns) // 2
            errors.append(columns[0] + half_level_crossing(profile[: middle + 1], True) - left)
            errors.append(columns[0] + middle + half_level_crossing(profile[middle:], False) - right)
    assert len(errors) >= 6
    assert np.abs(np.median(errors)) < 0.25
    assert np.percentile(np.abs(errors), 90) < 0.5


def test_ends_of_stripes_lie_where_projected(unworn):  # noqa: ARG001
    camera, road = Camera(), straight_road()
    errors = []
    for x in np.arange(20.0, 29.0, 1.3):
        ego = add_ego(road, [x, WIDTH_M * 1.5])  # the line runs straight down the middle of the picture
        picture = grey(Renderer(road, Rig(camera, noise_sd=0.0), CLEAR, 1), ego)
        road.vehicles.clear()
        for start, end in stripes_ahead(x + 3.0, x + 12.0):
            ends = np.array([[end - x, 0.0, 0.0], [start - x, 0.0, 0.0]])
            top, bottom = project(camera, ends)[:, 1]
            column = picture[:, 319:321].mean(axis=1)
            for edge, rising in ((top, True), (bottom, False)):
                first, last = int(edge) - 4, int(edge) + 5
                if last < camera.height_px:
                    errors.append(first + half_level_crossing(column[first:last], rising) - edge)
    assert len(errors) > 8
    assert np.abs(np.median(errors)) < 0.3
    assert np.percentile(np.abs(errors), 90) < 0.5


@pytest.mark.parametrize("distance", [8.0, 15.0, 30.0])
def test_object_silhouette_matches_its_projected_corners(distance):
    camera = Camera()
    road, empty = straight_road(), straight_road()
    add_object(road, "van", [20.0 + distance, 3.5])
    ego = add_ego(road, [20.0, 3.5])
    with_object = Renderer(road, Rig(camera, noise_sd=0.0), CLEAR, 1).render(ego, 0.0)
    without = Renderer(empty, Rig(camera, noise_sd=0.0), CLEAR, 1).render(ego, 0.0)
    changed = cv2.absdiff(with_object, without).max(axis=2) > 2  # in any channel: its grey may be that of the scenery
    rear = distance - 0.5 * 5.5
    (left, top), (right, _) = project(camera, np.array([[rear, -1.05, 2.3], [rear, 1.05, 2.3]]))
    # a pixel's square reaches half a pixel beyond its centre, so the outermost changed pixel lies within 1 of the edge
    middle = (int(top) + 240) // 2
    columns = np.flatnonzero(changed[middle])
    rows = np.flatnonzero(changed[:230, 320])
    assert left - 1.0 < columns[0] < left + 1.0
    assert right - 1.0 < columns[-1] < right + 1.0
    assert top - 1.0 < rows[0] < top + 1.0


def test_motionless_camera_renders_the_same_frame():
    road = straight_road()
    add_object(road, "car", [40.0, 3.5])
    ego = add_ego(road, [20.0, 7.0])
    renderer = Renderer(road, Rig(Camera(), noise_sd=0.0), CLEAR, 1)
    first, second = renderer.render(ego, 0.0), renderer.render(ego, 1.0)
    assert np.array_equal(first, second)
    assert not np.shares_memory(first, second)


def test_noise_has_its_sd_and_is_new_in_each_frame():
    road = straight_road()
    ego = add_ego(road, [20.0, 7.0])
    quiet = Renderer(road, Rig(Camera(), noise_sd=0.0), CLEAR, 1).render(ego, 0.0).astype(float)
    renderer = Renderer(road, Rig(Camera(), noise_sd=2.0), CLEAR, 1)
    first, second = (renderer.render(ego, time_s).astype(float) for time_s in (0.0, 0.05))
    assert (first - quiet)[:400].std() == pytest.approx(2.0, abs=0.15)
    assert np.corrcoef((first - quiet).ravel(), (second - quiet).ravel())[0, 1] == pytest.approx(0.0, abs=0.01)


def test_seeds_differ_in_scenery_and_ground_not_in_markings():
    road = straight_road()
    ego = add_ego(road, [20.0, 7.0])
    one, two = (
        Renderer(road, Rig(Camera(), noise_sd=0.0), CLEAR, seed).render(ego, 0.0).astype(int) for seed in (1, 2)
    )
    assert np.abs(one - two)[250:].mean() > 2.0
    assert np.abs(one - two)[180:240].mean() > 2.0


def test_the_ground_has_grain_at_every_distance():
    road = bent_road()
    ego = add_ego(road, [1.0, -1.75])
    picture = grey(Renderer(road, Rig(Camera(), noise_sd=0.0), CLEAR, 3), ego)
    for row in (252, 262, 275, 290, 320, 360, 420, 470):  # 35 m to 2 m ahead
        asphalt = picture[row, 315:375]
        assert 2.0 < asphalt.std() < 16.0, row


def test_grain_has_no_seam_between_its_levels():
    """Averaged over many places, brightness has no step from row to row."""
    road = straight_road()
    ego = add_ego(road, [0.0, 3.5])
    renderer = Renderer(road, Rig(Camera(), noise_sd=0.0), CLEAR, 3)
    frames = []
    for k in range(24):
        ego.position = np.array([20.0 + 7.7 * k, 3.5])
        frames.append(grey(renderer, ego)[260:470, 300:340])
    profile = np.mean(frames, axis=(0, 2))
    steps = np.abs(np.diff(np.convolve(profile, np.full(3, 1.0 / 3.0), mode="valid")))
    assert steps.max() < 3.0  # grey levels


def test_frames_do_not_shimmer_in_the_distance():
    """A millimetre of travel changes distant pixels only slightly."""
    road = straight_road()
    ego = add_ego(road, [20.0, 3.5])
    renderer = Renderer(road, Rig(Camera(), noise_sd=0.0), CLEAR, 3)
    first = grey(renderer, ego)
    ego.position = ego.position + np.array([0.001, 0.0])
    assert np.abs(grey(renderer, ego) - first)[242:300].mean() < 0.35


def test_the_sky_turns_with_the_yaw_and_does_not_move_with_the_car():
    road = straight_road()
    ego = add_ego(road, [20.0, 7.0])
    renderer = Renderer(road, Rig(Camera(), noise_sd=0.0), CLEAR, 4)  # no tree rises into these rows
    first = renderer.render(ego, 0.0)[:100]
    ego.position = ego.position + np.array([30.0, 1.0])
    assert np.array_equal(renderer.render(ego, 0.1)[:60], first[:60])


@pytest.mark.parametrize(
    ("camera", "key"),
    [
        (replace(Camera(), k1=-0.2), "k1, k2: expected a distortion that is invertible"),
        (replace(Camera(), height_m=0.0), "height_m: expected at least 0.1, got 0.0"),
        (replace(Camera(), width_px=641), "width_px: expected an even number, got 641"),
    ],
)
def test_unsupported_cameras_are_rejected(camera, key):
    with pytest.raises(InputError, match=key):
        Rig(camera)


def test_weather_files_change_single_factors(tmp_path):
    path = tmp_path / "evening.toml"
    path.write_text('base = "ClearNoon"\nsun_altitude_angle = 20.0\n')
    assert weather.load(str(path)).sun_altitude_angle == 20.0
    assert weather.load(str(path)).name == "evening"
