"""The world as the core draws it: its frames depend on pose, objects and time alone."""

from types import SimpleNamespace

import numpy as np
from highway_env.road.road import Road
from highway_scenes import add_ego, add_object, bent_road, on_bend, straight_road

from vpf_sim.envs.camera import Renderer, Rig, weather
from vpf_sim.types import Camera, Image


def bend_with_traffic() -> Road:
    road = bent_road()
    for kind, s, right in (("car", 16.0, 3.5), ("van", 22.0, -3.5), ("truck", 45.0, 2.0), ("cone", 12.0, 0.5)):
        add_object(road, kind, *on_bend(s, right))
    return road


def at(s: float) -> SimpleNamespace:
    position, heading = on_bend(s, 1.75)
    return SimpleNamespace(position=np.array(position), heading=heading)


def frames_of(places: list[float]) -> dict[float, Image]:
    """Frames of a new renderer at places along the bend, in that order."""
    renderer = Renderer(bend_with_traffic(), Rig(Camera(160, 120)), weather.load("clear"), 4)
    return {s: renderer.render(at(s), 0.1 * s) for s in places}


def test_a_frame_does_not_depend_on_the_frames_before() -> None:
    along = [float(s) for s in np.arange(0.0, 40.0, 0.7)]
    driven, back, alone = frames_of(along), frames_of(along[::-1]), frames_of(along[33:34])
    assert all(np.array_equal(driven[s], back[s]) for s in along)
    assert np.array_equal(driven[along[33]], alone[along[33]])


def test_a_car_looks_the_same_whether_it_was_far_away_before() -> None:
    """Meshes are made when objects come near, here the second one first."""
    road = straight_road()
    for x in (320.0, 25.0):
        add_object(road, "car", [x, 3.5])
    places = [SimpleNamespace(position=np.array([x, 3.5]), heading=0.0) for x in (0.0, 300.0)]
    driven, alone = (Renderer(road, Rig(Camera(160, 120)), weather.load("clear"), 4) for _ in range(2))
    driven.render(places[0], 0.0)
    assert np.array_equal(driven.render(places[1], 1.0), alone.render(places[1], 1.0))


def test_a_truck_before_a_car_hides_it_whatever_their_middles() -> None:
    """The long truck's middle is farther than the car behind its rear; the car is drawn over it only where it shows."""
    road = straight_road()
    ego = add_ego(road, [0.0, 3.5])
    truck = add_object(road, "truck", [20.0, 3.5])
    car = add_object(road, "car", [20.0 - 0.5 * truck.LENGTH - 3.5, 3.7])
    renderer = Renderer(road, Rig(Camera(320, 240), noise_sd=0.0), weather.load("clear"), 1)
    renderer.render(ego, 0.0)
    instance = renderer.truth(("instance",))["instance"]
    numbers = {obj: number + 1 for number, obj in enumerate(renderer.objects)}
    assert (instance == numbers[car]).sum() > 500
    before = (instance == numbers[car]).sum()
    car.position = np.array([20.0 + 0.5 * truck.LENGTH + 3.5, 3.7])
    renderer.render(ego, 0.1)
    instance = renderer.truth(("instance",))["instance"]
    assert (instance == numbers[car]).sum() < 0.05 * before
