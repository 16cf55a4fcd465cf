"""The scene from the simulator's world."""

import numpy as np
import pytest

from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.envs.world import World, build_world
from vpf_sim.scenarios import load
from vpf_sim.scene import Scene
from vpf_sim.scene.planned_lanes import PlannedLanes
from vpf_sim.scene.truth import TrueScene, road_of
from vpf_sim.types import Camera, VehicleModel

NO_IMAGE = np.zeros((0, 0, 3), np.uint8)


def world_of(scenario: str) -> World:
    return build_world(load(scenario).draw(1), 1)


def scene_of(world: World) -> Scene:
    ego = world.ego
    setup = DriverSetup(
        Camera(), VehicleModel(), 60.0, 5.55, world.route.goal_m, 1, world.route.waypoints(), world.road
    )
    x, y = ego.position.tolist()
    seen = Observation(NO_IMAGE, 0.0, x, y, ego.heading, ego.speed, ego.yaw_rate_radps, world.route.goal_m)
    return TrueScene(setup).at(seen)


@pytest.mark.parametrize("scenario", ["curve-left", "oncoming", "racetrack-v0", "roundabout-v0"])
def test_road_coordinates_are_the_networks(scenario: str) -> None:
    network = world_of(scenario).road.network
    road = road_of(network, 0.0)
    for s, d in ((5.0, 0.0), (30.0, 0.8), (61.3, -0.5)):
        x, y, _ = (float(value) for value in road.world(np.array(s), np.array(d)))
        assert network.place_at(x, y, s) == pytest.approx((s, d), abs=0.02)


def test_lanes_of_oncoming_traffic_are_left_of_the_own() -> None:
    world = world_of("oncoming")
    here = scene_of(world).road
    lanes = world.road.network.graph["start"]["end"]
    width_m = lanes[0].width_at(0.0)
    oncoming = sum(lane.oncoming for lane in lanes)
    assert oncoming
    assert here.left_m[200] == pytest.approx(-0.5 * width_m * len(lanes))
    assert here.own_left_m[200] - here.left_m[200] == pytest.approx(oncoming * width_m)
    assert len(here.lanes_m) == len(lanes) - oncoming


@pytest.mark.parametrize("scenario", ["traffic", "highway-v0", "intersection-v1"])
def test_tracks_are_the_objects_but_the_ego(scenario: str) -> None:
    world = world_of(scenario)
    scene = scene_of(world)
    x, y = world.ego.position.tolist()
    assert len(scene.tracks)
    assert np.hypot(scene.tracks.x_m - x, scene.tracks.y_m - y).min() > 1.0
    objects = {tuple(obj.position.tolist()): obj for obj in (*world.road.vehicles, *world.road.objects)}
    for k in range(len(scene.tracks)):
        obj = objects[scene.tracks.x_m[k], scene.tracks.y_m[k]]
        velocity = scene.tracks.speed_mps[k] * np.array(
            [np.cos(scene.tracks.heading_rad[k]), np.sin(scene.tracks.heading_rad[k])]
        )
        np.testing.assert_allclose(velocity, obj.velocity, atol=0.5)
        assert (scene.tracks.length_m[k], scene.tracks.width_m[k]) == (obj.LENGTH, obj.WIDTH)


def test_a_world_without_objects_has_no_tracks() -> None:
    assert len(scene_of(world_of("curve-left")).tracks) == 0


def test_the_world_is_needed() -> None:
    setup = DriverSetup(Camera(), VehicleModel(), 60.0, 5.55, (10.0, 0.0), 1)
    with pytest.raises(ValueError, match="expected a setup with the world and the route"):
        TrueScene(setup)


@pytest.mark.parametrize("scenario", ["roundabout-v0", "intersection-v1"])
def test_cars_of_highway_env_drive_in_their_lanes(scenario: str) -> None:
    """After two seconds each car is on the lanes that were planned for it: highway-env's cars cut bends by a metre."""
    world = world_of(scenario)
    lanes = PlannedLanes(world.road.network)
    cars = [car for car in world.road.vehicles if car is not world.ego and car.speed > 2.0]
    assert len(cars) > 1
    places = [lanes.place_of(car) for car in cars]
    for step in range(120):
        world.advance(step, 60.0)
    for car, place in zip(cars, places, strict=True):
        assert place is not None
        x, y, _ = place.line.at(np.arange(place.along_m, place.along_m + 40.0, 0.25))
        assert np.hypot(x - car.position[0], y - car.position[1]).min() < 1.5


def test_what_has_no_lane_of_highway_env_has_no_place() -> None:
    world = world_of("traffic")
    lanes = PlannedLanes(world.road.network)
    assert all(lanes.place_of(obj) is None for obj in (*world.road.vehicles, *world.road.objects))
