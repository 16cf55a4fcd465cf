"""Painting of items: coverage, order, independence, haze."""

from dataclasses import replace

import numpy as np
import pytest
from highway_scenes import add_ego, add_object, straight_road

from vpf_sim.envs.camera import Renderer, Rig, weather
from vpf_sim.envs.camera.core.frames import Core
from vpf_sim.envs.camera.horizon import ground_top
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.scenery.cars import upright
from vpf_sim.envs.camera.scenery.content import add_mesh
from vpf_sim.envs.camera.scenery.mesh import Mesh, MeshBuilder
from vpf_sim.types import Camera, Image

RANGE_M, FADED_IN_M = 220.0, 180.0  # of objects: where they appear, and are opaque
CAMERA = Camera()


def card(width_m: float, height_m: float, grey: float) -> Mesh:
    """An upright face, seen from behind the object."""
    builder = MeshBuilder()
    builder.whole(upright(0.0, 0.5 * width_m, 0.0, height_m, "rear"), (grey, grey, grey), lit=False)
    return builder.build()


def painted(places: list[tuple[float, ...]], grey: int = 0) -> Image:
    """A frame of cards (ahead, right, width, height in m, level) before even grey."""
    core, light = Core(CAMERA, ground_top(CAMERA)), Light.of(weather.load("clear"))
    factors = light.sky, light.direct
    core.set_light(0.0 * light.horizon, light.sun, factors, (1.0, 1.0), np.zeros(2), np.ones(9))
    numbers = [add_mesh(core, card(*size, level), (0.01, *size)) for _, _, *size, level in places]
    objects = np.array([(ahead, right, 0.0, 0.0) for ahead, right, *_ in places])
    objects.view(np.int64)[:, 3] = numbers
    core.begin(-CAMERA.forward_m, 0.0, 0.0, 0.0, objects)
    frame = np.full((CAMERA.height_px, CAMERA.width_px, 3), grey, np.uint8)
    core.draw_scene(frame)
    return frame


@pytest.mark.parametrize(("size", "fine"), [(6.0, 4), (30.0, 4), (150.0, 2)])
def test_the_brightness_of_an_edge_is_its_coverage(size: float, fine: int) -> None:
    errors, areas = [], []
    for shift in np.linspace(0.0, 0.9, 7):
        width = 10.0 * size / CAMERA.fx_px
        seen = painted([(10.0, 10.0 * shift / CAMERA.fx_px, width, width, 200.0)])[..., 0].astype(float)
        weights = seen.sum(axis=0)
        errors.append((weights @ np.arange(640)) / weights.sum() - (CAMERA.cx_px + shift))
        areas.append(seen.sum() / 200.0)
    assert np.mean(areas) == pytest.approx(size**2, rel=0.02, abs=1.5 * size / fine)
    assert np.abs(errors).max() < 0.5 / fine + 0.01
    assert np.abs(np.mean(errors)) < 0.06


def test_thin_faces_keep_their_light() -> None:
    """A post three quarters of a pixel wide, wherever it stands between the pixels."""
    width = 20.0 * 0.75 / CAMERA.fx_px
    shifts = np.linspace(0.0, 1.0, 16, endpoint=False) + 0.03
    lights = [painted([(20.0, 20.0 * shift / CAMERA.fx_px, width, 2.0, 200.0)]).astype(float).sum() for shift in shifts]
    assert np.mean(lights) / 3 / 200 == pytest.approx(0.75 * 2.0 * CAMERA.fy_px / 20.0, rel=0.1)


def test_nearer_faces_cover_farther_ones_and_others_do_not_change() -> None:
    both, near, far = (painted(places, 40) for places in ([NEAR, FAR], [NEAR], [FAR]))
    covered = (near == 200).all(axis=2)
    assert covered.sum() > 1000
    assert np.array_equal(both[covered], near[covered])
    edge = (near != 40).any(axis=2)
    assert np.array_equal(both[~edge], far[~edge])


def test_faces_behind_the_camera_are_clipped() -> None:
    frame = painted([(0.6, 0.0, 8.0, 1.0, 200.0)])
    assert frame[-1].min() == 200
    assert painted([(-5.0, 0.0, 2.0, 1.0, 200.0)]).max() == 0


NEAR, FAR = (10.0, 0.2, 1.0, 1.2, 200.0), (14.0, -0.3, 2.0, 2.0, 90.0)


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
