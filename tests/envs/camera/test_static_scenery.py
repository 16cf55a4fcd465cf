"""Static scenery: clear of the lanes, reproducible, and completely drawn."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from highway_env.road.road import Road
from highway_scenes import bent_road, straight_road
from scipy.spatial import cKDTree

from vpf_sim import scenarios
from vpf_sim.envs.camera import weather
from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.core.frames import Core
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.layout import LaneShape, lane_shapes
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.scenery.content import set_light
from vpf_sim.envs.camera.scenery.furniture import CLEARANCE_M, LAMP_HEIGHT_M, LAMP_POST, POST, gantry
from vpf_sim.envs.camera.scenery.roadside import Placement, group_of, shadow_polygons
from vpf_sim.envs.camera.scenery.signs import SIGNS
from vpf_sim.envs.camera.scenery.static_scenery import StaticScenery
from vpf_sim.envs.camera.scenery.tree_content import plant
from vpf_sim.envs.camera.scenery.trees import RANGE_M as TREE_RANGE_M
from vpf_sim.envs.camera.scenery.trees import Trees
from vpf_sim.envs.camera.scenery.verge import Verge
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
    places = []
    for seed in (1, 1, 2):
        scenery = StaticScenery(CAMERA, shapes, seed)
        places.append((scenery.trees.feet_m, np.array([pose for _, pose, _ in scenery.furniture])))
    for one, again, other in zip(*places, strict=True):
        assert np.array_equal(one, again)
        assert one.shape != other.shape or not np.array_equal(one, other)


def drawn(core: Core, x: float) -> Floats:
    """(H, W) what a core draws over black."""
    frame = np.zeros((CAMERA.height_px, CAMERA.width_px, 3), np.uint8)
    core.begin(x - CAMERA.forward_m, 0.0, 0.0, 0.0, np.empty((0, 4)))
    core.draw_scene(frame)
    return frame.astype(float).sum(axis=2)


def test_lamp_post_shadow_matches_the_sun() -> None:
    items: list[Placement] = [(mesh, np.array([10.0, 5.0, 0.3]), 200.0) for mesh in LAMP_POST]
    shade = np.concatenate(shadow_polygons(group_of(items, CAMERA), LIGHT, CAMERA))
    away = -LIGHT.sun[:2] / np.hypot(*LIGHT.sun[:2])
    length = LAMP_HEIGHT_M / np.tan(np.arcsin(LIGHT.sun[2]))
    reach = (shade - (10.0, 5.0)) @ away
    assert reach.max() == pytest.approx(length, abs=3.0)  # the arm reaches 2.5 m to one side
    assert reach.min() > -0.3


def test_a_small_camera_has_the_shadows_of_a_large_one() -> None:
    shapes = lane_shapes(town())
    large, small = (
        StaticScenery(camera, shapes, 3).shadow_polygons(LIGHT) for camera in (CAMERA, Camera.of(84, 84, 90.0))
    )
    assert len(large) > 500
    assert all(np.array_equal(one, other) for one, other in zip(large, small, strict=True))


def test_trees_fade_with_distance_and_move_with_subpixel_accuracy() -> None:
    core = Core(CAMERA, ground_top(CAMERA))
    dark = replace(LIGHT, horizon=np.zeros(3))
    set_light(core, dark, HAZE)
    plant(core, Trees(np.array([[60.0, 6.0]]), np.array([9.0]), np.array([0])), dark, HAZE)

    def visible(ahead_m: float) -> Floats:
        seen = drawn(core, 60.0 - ahead_m)
        rows, columns = np.mgrid[0 : CAMERA.height_px, 0 : CAMERA.width_px]
        total = max(seen.sum(), 1e-9)
        return np.array([(seen * columns).sum() / total, (seen * rows).sum() / total, total])

    for distance in (20.0, 45.0, 70.0):
        x, y, _ = visible(distance)
        nearer_x, nearer_y, _ = visible(distance - 0.05)
        scale = distance / (distance - 0.05)
        assert nearer_x - CAMERA.cx_px == pytest.approx((x - CAMERA.cx_px) * scale, abs=0.1)
        assert nearer_y - CAMERA.cy_px == pytest.approx((y - CAMERA.cy_px) * scale, abs=0.1)
    assert visible(TREE_RANGE_M - 0.3)[2] < 0.1 * visible(70.0)[2]
