"""Static scenery: clear of the lanes, reproducible, and completely drawn."""

from itertools import pairwise

import cv2
import numpy as np
import pytest
from highway_env.road.road import Road
from highway_scenes import bent_road, straight_road
from scipy.spatial import cKDTree

from vpf_sim import scenarios
from vpf_sim.envs.camera import weather
from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.layout import LaneShape, lane_shapes
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.painter import paint
from vpf_sim.envs.camera.scenery.furniture import CLEARANCE_M, LAMP_HEIGHT_M, LAMP_POST, POST, gantry
from vpf_sim.envs.camera.scenery.roadside import Placement, Roadside
from vpf_sim.envs.camera.scenery.signs import SIGNS
from vpf_sim.envs.camera.scenery.static_scenery import StaticScenery
from vpf_sim.envs.camera.scenery.trees import RANGE_M as TREE_RANGE_M
from vpf_sim.envs.camera.scenery.trees import Trees, TreeStand
from vpf_sim.envs.camera.scenery.verge import Verge
from vpf_sim.envs.camera.view import View
from vpf_sim.envs.road import build_road
from vpf_sim.types import Camera, Floats

CAMERA = Camera()
CLEAR = weather.load("clear")
LIGHT = Light.of(CLEAR)
HAZE = Haze(CAMERA, Atmosphere.of(CLEAR), LIGHT)


def town() -> Road:
    return build_road(scenarios.load("town04"), np.random.default_rng(0))


ROADS = {"straight": straight_road, "bent": bent_road, "town04": town}


def standing(shapes: list[LaneShape], seed: int) -> list[Placement]:
    return Verge(shapes).furniture(np.random.default_rng(seed))


def in_world(item: Placement) -> Floats:
    """(n, 3) corners of an item."""
    mesh, (x, y, heading), _ = item
    c, s = np.cos(heading), np.sin(heading)
    return mesh.faces_m.reshape(-1, 3) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + (x, y, 0.0)


@pytest.mark.parametrize("name", ROADS)
def test_furniture_keeps_clear_of_the_lanes(name: str) -> None:
    shapes = lane_shapes(ROADS[name]())
    middles = np.concatenate([0.5 * (shape.left_m + shape.right_m) for shape in shapes])
    along = np.concatenate([np.linspace(a, b, 12) for a, b in pairwise(middles)])
    lanes, half = cKDTree(along), 0.5 * shapes[0].width_m
    over = 0
    for seed in range(4):
        for item in standing(shapes, seed):
            corners = in_world(item)
            beside = lanes.query(corners[:, :2])[0] > half
            assert corners[~beside, 2].min(initial=np.inf) > 5.0
            over += int((~beside).any())
    assert over > 0


def test_every_kind_of_furniture_stands_beside_some_road() -> None:
    shapes = lane_shapes(town())
    meshes = {id(mesh) for seed in range(8) for mesh, _, _ in standing(shapes, seed)}
    assert {id(POST), *map(id, LAMP_POST)} <= meshes
    assert len({id(sign) for sign in SIGNS} & meshes) >= 6


def test_gantry_spans_its_width_with_clearance_below() -> None:
    left, right, carried = gantry(18.0, (-5.25, -1.75, 1.75, 5.25), 1)
    assert left.faces_m[..., 1].max() < -8.5
    assert right.faces_m[..., 1].min() > 8.5
    assert carried.faces_m[..., 2].min() >= CLEARANCE_M
    assert carried.faces_m[..., 1].max() == pytest.approx(9.0)


def test_seed_determines_the_scenery() -> None:
    shapes = lane_shapes(town())
    view = View.at(CAMERA, np.array([-80.0, 365.0]), 2.2)
    pictures = []
    for seed in (1, 1, 2):
        scenery = StaticScenery(CAMERA, shapes, LIGHT, HAZE, seed)
        drawing, _ = scenery.visible(view)
        assert drawing is not None
        pictures.append((drawing.polygons_px, [(tree.x, tree.y) for tree in scenery.visible_sprites(view)]))
    assert np.array_equal(pictures[0][0], pictures[1][0])
    assert pictures[0][1] == pictures[1][1]
    assert pictures[0][1] != pictures[2][1]


def test_culling_misses_no_visible_face() -> None:
    shapes = lane_shapes(town())
    items = standing(shapes, 3)
    roadside = Roadside(CAMERA, items, LIGHT, HAZE)
    lane = town().network.get_lane(("start", "end", 1))
    for s in np.linspace(5.0, 500.0, 23):
        view = View.at(CAMERA, lane.position(s, 0.0), lane.heading_at(s) + 0.3 * np.sin(s))
        seen, depths = roadside.visible(view)
        assert depths == sorted(depths, reverse=True)
        expected = sum(_shows(view, item) for item in items)
        shown = 0 if seen is None else sum(x0 < x1 and y0 < y1 for x0, y0, x1, y1 in seen.boxes)
        assert shown >= expected


def test_cached_faces_of_the_roadside_match_fresh_ones() -> None:
    items = standing(lane_shapes(town()), 3)
    kept, fresh = (Roadside(CAMERA, items, LIGHT, HAZE) for _ in range(2))
    lane = town().network.get_lane(("start", "end", 1))
    off = []
    for s in (np.linspace(60.0, 300.0, 30)[:, None] + 0.09 * np.arange(4)).ravel():
        view = View.at(CAMERA, lane.position(s, 0.0), lane.heading_at(s))
        fresh.cached = None
        frames = [np.full((CAMERA.height_px, CAMERA.width_px, 3), 90, np.uint8) for _ in range(2)]
        for frame, (seen, depths) in zip(frames, (kept.visible(view), fresh.visible(view)), strict=True):
            assert seen is not None
            assert depths == sorted(depths, reverse=True)
            paint(frame, [seen])
        off.append(cv2.absdiff(*frames).max(axis=2))
    assert 0.0 < np.mean(off) < 0.002
    assert np.sum(np.array(off) > 20, axis=(1, 2)).max() < 60


def _shows(view: View, item: Placement) -> bool:
    """Whether an item is surely visible: well within its range and the image, and large."""
    points = view.camera_axes(in_world(item))
    depth = points[:, 2]
    if depth.min() < 2.0 or depth.max() > 0.8 * item[2]:
        return False
    pixels = view.pixels(points)
    inside = (pixels > 8.0).all() and (pixels < (632.0, 472.0)).all()
    return bool(inside and np.ptp(pixels, axis=0).min() > 2.0)


def test_lamp_post_shadow_matches_the_sun() -> None:
    items: list[Placement] = [(mesh, np.array([10.0, 5.0, 0.3]), 200.0) for mesh in LAMP_POST]
    shade = np.concatenate(Roadside(CAMERA, items, LIGHT, HAZE).shadow_polygons(LIGHT))
    away = -LIGHT.sun[:2] / np.hypot(*LIGHT.sun[:2])
    length = LAMP_HEIGHT_M / np.tan(np.arcsin(LIGHT.sun[2]))
    reach = (shade - (10.0, 5.0)) @ away
    assert reach.max() == pytest.approx(length, abs=3.0)  # the arm reaches 2.5 m to one side
    assert reach.min() > -0.3


def test_a_small_camera_has_the_shadows_of_a_large_one() -> None:
    shapes = lane_shapes(town())
    large, small = (
        StaticScenery(camera, shapes, LIGHT, HAZE, 3).shadow_polygons(LIGHT)
        for camera in (CAMERA, Camera.of(84, 84, 90.0))
    )
    assert len(large) > 500
    assert all(np.array_equal(one, other) for one, other in zip(large, small, strict=True))


def test_trees_fade_with_distance_and_move_with_subpixel_accuracy() -> None:
    stand = TreeStand(CAMERA, Trees(np.array([[60.0, 6.0]]), np.array([9.0]), np.array([0])), LIGHT, HAZE)

    def visible(ahead_m: float) -> Floats:
        (tree,) = stand.visible(View.at(CAMERA, np.array([60.0 - ahead_m, 0.0]), 0.0))
        opacity = 255.0 - tree.through[..., 0].astype(float)
        rows, columns = np.mgrid[0 : opacity.shape[0], 0 : opacity.shape[1]]
        total = opacity.sum()
        return np.array([tree.x + (opacity * columns).sum() / total, tree.y + (opacity * rows).sum() / total, total])

    for distance in (20.0, 45.0, 75.0):
        x, y, _ = visible(distance)
        nearer_x, nearer_y, _ = visible(distance - 0.05)
        ahead = distance - CAMERA.forward_m
        scale = ahead / (ahead - 0.05)
        assert nearer_x - CAMERA.cx_px == pytest.approx((x - CAMERA.cx_px) * scale, abs=0.1)
        assert nearer_y - CAMERA.cy_px == pytest.approx((y - CAMERA.cy_px) * scale, abs=0.1)
    assert visible(TREE_RANGE_M)[2] < 0.1 * visible(80.0)[2]
