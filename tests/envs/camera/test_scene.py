"""Painting of items: coverage, order, independence, haze."""

from dataclasses import replace
from itertools import pairwise

import cv2
import numpy as np
import pytest
from highway_scenes import add_ego, add_object, straight_road

from vpf_sim.envs.camera import Renderer, Rig, weather
from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.painter import Drawing, Sprite, drawing, paint
from vpf_sim.envs.camera.scenery.object_meshes import object_mesh
from vpf_sim.envs.camera.scenery.solid import FADED_IN_M, RANGE_M, SLIVER_PX, Solid
from vpf_sim.envs.camera.view import View
from vpf_sim.types import Camera, Floats, Image

VIEW = View.of(Camera(), np.zeros(3), 0.0, np.eye(3))  # in camera axes
FIRST = np.zeros(1, np.int64)


def rectangle(x0: float, y0: float, x1: float, y1: float, grey: float, depth_m: float = 10.0) -> Drawing:
    """An upright face with its corners at these pixel coordinates."""
    camera = VIEW.camera
    corners = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    rays = np.column_stack([(corners - (camera.cx_px, camera.cy_px)) / camera.fx_px, np.ones(4)])
    planes = np.array([[0.0, 0.0, 1.0 / depth_m]])
    return drawing(VIEW, depth_m * rays[None], [(grey, grey, grey, 0.0)], lambda: planes, FIRST)


def sprite(x: int, y: int, size: int, grey: int) -> Sprite:
    picture = np.full((size, size, 4), grey, np.uint8)
    picture[..., 3] = 0
    return Sprite(x, y, picture, 10.0)


def canvas(grey: int = 40) -> Image:
    return np.full((480, 640, 3), grey, np.uint8)


@pytest.mark.parametrize(("size", "fine"), [(6.0, 4), (30.0, 4), (150.0, 2)])
def test_the_brightness_of_an_edge_is_its_coverage(size: float, fine: int) -> None:
    errors = []
    for shift in np.linspace(0.0, 0.9, 7):
        frame = canvas(0)
        paint(frame, [rectangle(100.0 + shift, 100.0 + shift, 100.0 + shift + size, 100.0 + shift + size, 200.0)])
        seen = frame[..., 0].astype(float)
        weights = seen.sum(axis=0)
        errors.append((weights @ np.arange(640)) / weights.sum() - (100.0 + shift + 0.5 * size))
        # lines are filled up to and including the pixels that they touch: half a pixel of a layer at either side
        assert seen.sum() / 200.0 == pytest.approx(size**2, abs=(size + 2.0) * 4.0 / fine)
    assert np.abs(errors).max() < 0.5 / fine + 0.01
    assert np.abs(np.mean(errors)) < 0.05


def test_later_items_cover_earlier_ones_across_layers() -> None:
    frame = canvas()
    big, small = rectangle(50.0, 50.0, 400.0, 300.0, 90.0), rectangle(100.0, 100.0, 120.0, 120.0, 200.0)
    paint(frame, [small, big])
    assert np.all(frame[60:290, 60:390] == 90)
    paint(frame, [big, small, sprite(105, 105, 8, 150), rectangle(108.0, 108.0, 140.0, 140.0, 30.0)])
    assert frame[103, 103, 0] == 200
    assert frame[106, 106, 0] == 150
    assert frame[110, 110, 0] == 30
    assert frame[130, 130, 0] == 30


def test_item_is_drawn_the_same_with_and_without_others() -> None:
    items = [
        rectangle(100.3, 100.2, 130.7, 122.1, 180.0),
        rectangle(140.1, 100.0, 420.0, 260.5, 120.0),
        rectangle(131.2, 150.0, 138.9, 152.3, 220.0),
    ]
    together, alone = canvas(), canvas()
    paint(together, [*items])
    for item in items:
        paint(alone, [item])
    assert np.array_equal(together, alone)


def test_uncovered_pixels_do_not_change() -> None:
    rng = np.random.default_rng(1)
    frame = rng.integers(0, 256, (480, 640, 3)).astype(np.uint8)
    before = frame.copy()
    paint(frame, [rectangle(100.0, 100.0, 200.0, 200.0, 77.0), rectangle(230.0, 230.0, 233.0, 260.0, 99.0)])
    changed = (frame != before).any(axis=2)
    assert changed[105:195, 105:195].mean() > 0.9
    changed[98:203, 98:203] = changed[228:263, 228:236] = False
    assert not changed.any()


def test_faces_behind_the_camera_are_clipped() -> None:
    wall: Floats = np.array([[[-2.0, -1.0, -5.0], [-2.0, -1.0, 40.0], [-2.0, 1.4, 40.0], [-2.0, 1.4, -5.0]]])
    seen = drawing(VIEW, wall, [(10.0, 10.0, 10.0, 0.0)], lambda: np.array([[-0.5, 0.0, 0.0]]), FIRST)
    frame = canvas(200)
    paint(frame, [seen])
    dark = frame[..., 0] < 100
    assert dark[239, :300].all()  # the wall ends at 319.5 - 320 * 2 / 40
    assert not dark[239, 306:].any()


@pytest.mark.parametrize("kind", ["van", "barrier"])
def test_cached_faces_of_an_object_match_fresh_ones(kind: str) -> None:
    clear = weather.load("clear")
    light = Light.of(clear)
    haze = Haze(Camera(), Atmosphere.of(clear), light)
    size = {"van": (5.0, 2.0, 2.3), "barrier": (0.5, 3.0, 1.0)}[kind]
    kept, fresh = (Solid(object_mesh(kind, size, np.random.default_rng(0)), light, haze) for _ in range(2))
    caches, missed_px = [], []
    for ahead in (np.linspace(80.0, 8.0, 30)[:, None] - 0.09 * np.arange(4)).ravel():
        view = View.at(Camera(), np.array([-ahead, 0.04 * ahead - 1.0]), 0.01 * np.sin(ahead))
        fresh.cached = None
        drawings = [solid.visible(view, np.array([0.0, 0.0, 0.7])) for solid in (kept, fresh)]
        frames = [canvas(), canvas()]
        for frame, drawn in zip(frames, drawings, strict=True):
            assert drawn is not None
            paint(frame, [drawn])
        caches.append(kept.cached)
        off = cv2.absdiff(*frames).max(axis=2)
        missed_px.append(off.sum() / 255.0 / np.ptp(drawn.polygons_px[..., 1]))
    assert sum(now is not before for before, now in pairwise(caches)) < 0.7 * len(caches)
    assert 0.0 < max(missed_px) < SLIVER_PX


def scene(distance_m: float, name: str = "clear") -> tuple[Image, Image]:
    """Frames of a road with a truck at a distance, and without it."""
    camera = replace(Camera(), fx_px=1500.0, fy_px=1500.0)
    frames = []
    for objects in (True, False):
        road = straight_road()
        ego = add_ego(road, [20.0, 7.0])
        if objects:
            add_object(road, "truck", [20.0 + camera.forward_m + distance_m, 7.0])
        frames.append(Renderer(road, Rig(camera, noise_sd=0.0), weather.load(name), 1).render(ego, 0.0))
    return frames[0], frames[1]


def contrast(distance_m: float, name: str = "clear") -> float:
    """Contrast of a truck at a distance, grey levels."""
    with_object, without = (frame.astype(float) for frame in scene(distance_m, name))
    return float(np.percentile(np.abs(with_object - without).max(axis=2), 99.9))


def test_distant_objects_fade_in() -> None:
    far = [contrast(distance) for distance in (RANGE_M + 1.0, RANGE_M - 1.0, 0.5 * (RANGE_M + FADED_IN_M), FADED_IN_M)]
    assert far[0] == 0.0
    assert 0.0 < far[1] < 8.0
    assert 0.3 * far[3] < far[2] < 0.7 * far[3]


def test_fog_lowers_the_contrast_of_distant_objects() -> None:
    assert contrast(120.0, "FoggyNoon") < 0.5 * contrast(40.0, "FoggyNoon")


def test_planes_of_faces_give_depth() -> None:
    road = straight_road()
    ego = add_ego(road, [20.0, 7.0])
    obj = add_object(road, "van", [40.0, 7.0])
    renderer = Renderer(road, Rig(Camera(), noise_sd=0.0), weather.load("clear"), 1)
    renderer.render(ego, 0.0)
    depth = renderer.truth(("depth", "instance"))
    mine = depth["instance"] == renderer.objects.index(obj) + 1
    rear = obj.position[0] - 0.5 * obj.LENGTH - ego.position[0] - Camera().forward_m
    assert np.median(depth["depth"][mine]) == pytest.approx(rear, abs=0.05)
