"""Spray behind moving objects: place, growth with speed, and no effect on truth."""

import numpy as np
import pytest
from highway_scenes import WIDTH_M, add_ego, add_object, straight_road

from vpf_sim.envs.camera import Renderer, Rig, weather
from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.layout import lane_shapes
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.rain.spray import Puff, Spray
from vpf_sim.envs.camera.scenery.scene import Scene
from vpf_sim.envs.camera.snapshot import Snapshot
from vpf_sim.envs.camera.truth import Drawn
from vpf_sim.envs.camera.view import View
from vpf_sim.types import Camera

CAMERA = Camera()


class MovingCar:
    """A moving car ahead and its drawn items."""

    def __init__(self, name: str = "HardRainNoon", seed: int = 1) -> None:
        self.road = straight_road()
        self.car = add_object(self.road, "car", [40.0, 2.0 * WIDTH_M])
        chosen = weather.load(name)
        light, atmosphere = Light.of(chosen), Atmosphere.of(chosen)
        self.spray = Spray(CAMERA, atmosphere, light, seed)
        self.scene = Scene(CAMERA, lane_shapes(self.road), light, Haze(CAMERA, atmosphere, light), seed)

    def snapshot(self, x: float, time_s: float) -> Snapshot:
        view = View.at(CAMERA, np.array([20.0, 2.0 * WIDTH_M]), 0.0)
        return Snapshot(view, time_s, [self.car], {self.car: np.array([x, 2.0 * WIDTH_M, 0.0])})

    def drawn(self, speed: float, time_s: float = 5.0, x: float = 40.0) -> list[Drawn]:
        now, before = self.snapshot(x, time_s), self.snapshot(x - speed / 60.0, time_s - 1.0 / 60.0)
        return self.spray.added(self.scene.visible(now), now, before)


def puffs(drawn: list[Drawn]) -> list[Puff]:
    return [item.drawing for item in drawn if isinstance(item.drawing, Puff)]


def thickness(drawn: list[Drawn]) -> float:
    return sum(float((255 - puff.through[..., 0].astype(int)).sum()) for puff in puffs(drawn))


def test_puffs_lie_behind_the_object_and_are_drawn_after_it() -> None:
    drawn = MovingCar().drawn(12.0)
    obj = next(i for i, item in enumerate(drawn) if item.instance == 1)
    rear_m = 40.0 - 2.5 - (20.0 + CAMERA.forward_m)
    for i, item in enumerate(drawn):
        if isinstance(item.drawing, Puff):
            assert i > obj
            assert rear_m - 0.5 * 12.0 <= item.drawing.depth_m < rear_m + 0.5
    depths = [puff.depth_m for puff in puffs(drawn)]
    assert len(depths) == 3
    assert depths == sorted(depths, reverse=True)


def test_puffs_are_about_as_wide_as_the_object() -> None:
    for puff in puffs(MovingCar().drawn(12.0)):
        wide_m = puff.through.shape[1] * puff.depth_m / CAMERA.fx_px
        assert 0.8 * 2.0 < wide_m < 1.6 * 2.0


def test_spray_grows_with_speed_from_nothing_to_full() -> None:
    scene = MovingCar()
    at = [thickness(scene.drawn(speed)) for speed in (0.0, 3.9, 6.0, 9.0, 11.0)]
    assert at[:2] == [0.0, 0.0]
    assert 0.0 < at[2] < at[3] < at[4]


@pytest.mark.parametrize("name", ["ClearNoon", "FoggyNoon"])
def test_dry_road_gives_no_spray(name: str) -> None:
    assert not puffs(MovingCar(name).drawn(15.0))


def test_spray_grows_with_wetness() -> None:
    assert thickness(MovingCar("WetNoon").drawn(11.0)) < thickness(MovingCar("HardRainNoon").drawn(11.0))


def test_spray_is_reproducible_by_seed() -> None:
    one, again, other = (thickness(MovingCar(seed=seed).drawn(11.0)) for seed in (1, 1, 2))
    assert one == again
    assert one != other
    scene = MovingCar()
    assert len({thickness(scene.drawn(11.0, time_s)) for time_s in (5.0, 5.9, 6.8)}) == 3  # a puff's life apart


def test_puffs_stay_behind_at_half_the_speed() -> None:
    scene, speed = MovingCar(), 12.0
    first, second = (puffs(scene.drawn(speed, 5.0 + k / 60.0, 40.0 + speed * k / 60.0)) for k in (0, 6))
    moved = second[0].depth_m - first[0].depth_m
    assert min(abs(b.depth_m - a.depth_m - 0.5 * speed * 0.1) for a in first for b in second) < 0.01
    assert moved < speed * 0.1


def test_spray_is_hidden_but_not_in_depth() -> None:
    road = straight_road()
    ego = add_ego(road, [20.0, 2.0 * WIDTH_M])
    car = add_object(road, "car", [32.0, 2.0 * WIDTH_M])
    renderer = Renderer(road, Rig(noise_sd=0.0), weather.load("HardRainNoon"), 1)
    for k in range(20):
        car.position = np.array([32.0 + 12.0 * k / 60.0, 2.0 * WIDTH_M])
        renderer.render(ego, k / 60.0)
    depth = renderer.truth(("depth",))["depth"]
    dry = Renderer(road, Rig(noise_sd=0.0), weather.load("ClearNoon"), 1)
    dry.render(ego, 0.0)
    assert np.isclose(depth, dry.truth(("depth",))["depth"], rtol=1e-3).mean() > 0.99


def test_hidden_lies_on_and_behind_the_car() -> None:
    scene = MovingCar()
    for time_s in np.arange(5.0, 6.0, 0.05):
        drawn = scene.drawn(14.0, float(time_s), 30.0)
        hidden = scene.spray.hidden()
        if hidden.any():
            break
    rows, columns = np.nonzero(hidden)
    boxes = [(p.x, p.y, p.x + p.through.shape[1], p.y + p.through.shape[0]) for p in puffs(drawn)]
    assert all(any(a <= x < c and b <= y < d for a, b, c, d in boxes) for x, y in zip(columns, rows, strict=True))
    assert not scene.spray.hidden()[: int(CAMERA.cy_px) - 60].any()
