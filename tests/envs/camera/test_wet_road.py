"""Reflections on the wet road against mirror geometry and the reflectance of water."""

import numpy as np
import pytest
from highway_scenes import WIDTH_M, add_ego, add_object, straight_road

from vpf_sim.envs.camera import Renderer, Rig, weather
from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.layout import lane_shapes
from vpf_sim.envs.camera.painter import Drawing
from vpf_sim.envs.camera.painter import drawing as drawing_of
from vpf_sim.envs.camera.rain.mirror import mirrored_faces, mirrored_points, reflectance
from vpf_sim.envs.camera.rain.wet_road import EVERY, WetRoad
from vpf_sim.envs.camera.truth import Drawn
from vpf_sim.envs.camera.view import View
from vpf_sim.geometry import horizon_px
from vpf_sim.types import Camera, Image

CAMERAS = {
    "default": Camera(),
    "pitched": Camera(pitch_rad=0.06),
    "long": Camera(width_px=800, height_px=600, fx_px=700.0, fy_px=690.0, cx_px=410.0, cy_px=280.0, height_m=1.65),
}
EGO = np.array([20.0, 1.5 * WIDTH_M])
SKY, ROAD = 200, 40


def wall(camera: Camera, ahead_m: float) -> tuple[View, Drawn]:
    """An upright rectangle 2 m wide and 1.5 m high that faces the camera, as a drawn item."""
    view = View.at(camera, EGO, 0.0)
    x = view.centre[0] + ahead_m
    corners = np.array([[x, EGO[1] + side, up] for side, up in ((-1.0, 0.0), (-1.0, 1.5), (1.0, 1.5), (1.0, 0.0))])
    points = view.camera_axes(corners)
    normal = view.axes @ np.array([-1.0, 0.0, 0.0])
    planes = (normal / (normal @ points[0]))[None]
    drawing = drawing_of(view, corners[None], [(10.0, 10.0, 10.0, 0.0)], lambda: planes, np.array([0]))
    assert isinstance(drawing, Drawing)
    return view, Drawn(drawing, 1)


def plain(camera: Camera) -> Image:
    """A frame of even sky and even road."""
    frame = np.full((camera.height_px, camera.width_px, 3), SKY, np.uint8)
    frame[int(np.floor(horizon_px(camera))) + 1 :] = ROAD
    return frame


def wet_road(camera: Camera, name: str) -> WetRoad:
    atmosphere = Atmosphere.of(weather.load(name))
    return WetRoad(camera, lane_shapes(straight_road()), atmosphere, 1)


def test_reflectance_matches_tables() -> None:
    depression = np.arctan2(1.4, [3.0, 5.0, 10.0, 20.0, 40.0])
    assert reflectance(np.sin(depression)) == pytest.approx([0.087, 0.200, 0.428, 0.648, 0.804], abs=1e-3)
    assert reflectance(np.array([1.0])) == pytest.approx([(0.333 / 2.333) ** 2])
    assert reflectance(np.array([0.0])) == pytest.approx([1.0])


@pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)
def test_points_are_mirrored_about_the_road(camera: Camera) -> None:
    view = View.at(camera, EGO, 0.1)
    rng = np.random.default_rng(0)
    world = np.column_stack([rng.uniform(30.0, 60.0, 50), rng.uniform(-5.0, 15.0, 50), rng.uniform(0.0, 5.0, 50)])
    points = view.camera_axes(world)
    planes = points / np.einsum("ij,ij->i", points, points)[:, None]  # of faces that look at the camera
    image, height = mirrored_points(view, view.pixels(points), planes)
    assert image == pytest.approx(view.pixels(view.camera_axes(world * [1.0, 1.0, -1.0])), abs=1e-6)
    assert height == pytest.approx(world[:, 2], abs=1e-9)


def test_upward_faces_are_not_mirrored() -> None:
    view, upright = wall(Camera(), 10.0)
    roof = np.array([[30.0, 4.0, 1.0], [34.0, 4.0, 1.0], [34.0, 6.0, 1.0], [30.0, 6.0, 1.0]])
    normal = view.axes[:, 2]
    planes = (normal / (normal @ view.camera_axes(roof[0])))[None]
    drawing = drawing_of(view, roof[None], [(9.0, 9.0, 9.0, 0.0)], lambda: planes, np.array([0]))
    assert isinstance(drawing, Drawing)
    assert mirrored_faces(view, [Drawn(drawing, 1)]).corners == []
    assert len(mirrored_faces(view, [upright]).corners) == 1


@pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)
def test_a_wall_is_mirrored_down_to_its_mirrored_top(camera: Camera, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vpf_sim.envs.camera.rain.wetness.FILM_SLOPE_DEG", 0.0)  # flat water
    view, item = wall(camera, 12.0)
    frame = plain(camera)
    wet_road(camera, "HardRainNoon").draw(frame, view, [item])
    column = frame[:, int(camera.cx_px), 0].astype(float)
    mirrored_top = view.pixels(view.camera_axes(np.array([view.centre[0] + 12.0, EGO[1], -1.5])))[1]
    foot = view.pixels(view.camera_axes(np.array([view.centre[0] + 12.0, EGO[1], 0.0])))[1]
    rows = np.arange(int(foot) + 2, int(mirrored_top) + 12)
    edge = rows[np.argmax(np.diff(column[rows]))]
    assert edge == pytest.approx(mirrored_top, abs=2.5)


def test_reflected_sky_has_the_fresnel_level() -> None:
    camera = Camera()
    view, frame = View.at(camera, EGO, 0.0), plain(camera)
    wet_road(camera, "HardRainNoon").draw(frame, view, [])
    distance_m = np.array([5.0, 10.0, 20.0])
    rows = np.rint(camera.cy_px + camera.fy_px * camera.height_m / distance_m).astype(int)
    share = reflectance(np.sin(np.arctan2(1.4, distance_m)))
    seen = frame[rows][:, 300:340, 0].mean(axis=1)
    covered = (seen - ROAD) / (share * (SKY - ROAD))
    assert np.all((covered > 0.8) & (covered < 1.03))  # the film of hard rain covers nine tenths of the road or more


def test_grass_does_not_reflect() -> None:
    camera = Camera()
    frame = plain(camera)
    wet_road(camera, "HardRainNoon").draw(frame, View.at(camera, EGO, 0.0), [])
    row = int(camera.cy_px + camera.fy_px * camera.height_m / 12.0)
    edge_m = 3.5 * WIDTH_M + 0.5
    edge_px = camera.cx_px + camera.fx_px * (edge_m - EGO[1]) / 12.0
    assert np.all(frame[row, int(edge_px) + 8 :] == ROAD)
    assert np.all(frame[row, int(edge_px) - 30 : int(edge_px) - 8] > ROAD + 20)


def test_film_smears_reflections_downward_with_a_dark_foot() -> None:
    camera = Camera()
    view, item = wall(camera, 12.0)
    mirrored_top = camera.cy_px + camera.fy_px * (1.4 + 1.5) / 12.0
    foot = camera.cy_px + camera.fy_px * 1.4 / 12.0
    soft = {}
    for name in ("SoftRainNoon", "HardRainNoon"):
        frame, without = plain(camera), plain(camera)
        wet_road(camera, name).draw(frame, view, [item])
        wet_road(camera, name).draw(without, view, [])
        darker = (without.astype(float) - frame)[:, 300:340, 0].mean(axis=1)
        strongest = darker.max()
        assert darker[int(foot) + 3] > 0.5 * strongest
        assert darker[int(mirrored_top) + 60] < 0.2 * strongest
        soft[name] = np.count_nonzero((darker > 0.1 * strongest) & (darker < 0.9 * strongest))
    assert soft["SoftRainNoon"] > soft["HardRainNoon"]


def test_hidden_is_where_items_are_reflected() -> None:
    camera = Camera()
    view, item = wall(camera, 12.0)
    road = wet_road(camera, "HardRainNoon")
    road.draw(plain(camera), view, [item])
    hidden = road.hidden()
    foot, tip = (camera.cy_px + camera.fy_px * (1.4 + up) / 12.0 for up in (0.0, 1.5))
    assert hidden.shape == (camera.height_px, camera.width_px)
    assert hidden[int(foot) + 3 : int(tip) - 12, 300:340].all()
    assert not hidden[: int(foot) - 2, 296:343].any()  # the wall itself
    assert not hidden[:, :288].any()
    assert not hidden[:, 352:].any()
    road = wet_road(camera, "HardRainNoon")
    road.draw(plain(camera), view, [])
    assert not road.hidden().any()


def test_dry_road_has_no_reflections() -> None:
    camera = Camera()
    view, item = wall(camera, 12.0)
    frame = plain(camera)
    road = wet_road(camera, "ClearNoon")
    road.draw(frame, view, [item])
    assert np.array_equal(frame, plain(camera))
    assert not road.hidden().any()


def test_reflections_without_rain_are_static() -> None:
    road = straight_road()
    ego = add_ego(road, [20.0, 5.0])
    add_object(road, "car", [34.0, 7.0])
    renderer = Renderer(road, Rig(noise_sd=0.0), weather.load("WetNoon"), 1)
    assert np.array_equal(renderer.render(ego, 0.0), renderer.render(ego, 0.1))


@pytest.mark.parametrize("camera", [Camera(cy_px=20.0, pitch_rad=0.3), Camera(cy_px=470.0, pitch_rad=-0.3)])
def test_no_reflection_without_sky_or_road(camera: Camera) -> None:
    frame = np.full((camera.height_px, camera.width_px, 3), ROAD, np.uint8)
    road = wet_road(camera, "HardRainNoon")
    road.draw(frame, View.at(camera, EGO, 0.0), [])
    assert np.all(frame == ROAD)
    assert not road.hidden().any()


def test_rippled_reflection_is_updated_every_few_frames() -> None:
    camera = Camera()
    (view, item), frames = wall(camera, 12.0), [plain(camera) for _ in range(EVERY + 1)]
    road = wet_road(camera, "HardRainNoon")
    for k, frame in enumerate(frames):
        road.draw(frame, view, [item] if k == 0 else [])
    foot = int(camera.cy_px + camera.fy_px * 1.4 / 12.0) + 3
    dark = [frame[foot, 310:330, 0].mean() < frame[foot, 400:420, 0].mean() - 20.0 for frame in frames]
    assert dark == [True] * EVERY + [False]
