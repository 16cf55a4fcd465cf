"""The camera on highway-env's own environments: frames match lanes and cars of the state."""

import warnings

import cv2
import gymnasium as gym
import highway_env
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from highway_env.road.lane import LineType

import vpf_sim
from vpf_sim.envs.camera import Rig
from vpf_sim.geometry import project, vehicle_from_world
from vpf_sim.types import Camera

ENVIRONMENTS = {"highway-v0": 1, "merge-v0": 1, "racetrack-v0": np.zeros(1, np.float32)}  # id, an action
QUIET = Rig(noise_sd=0.0)

assert highway_env  # registers the environments


def make(name, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return vpf_sim.CameraObservation(gym.make(name), **options)


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_frame_is_added_to_the_observation(name):
    env = make(name)
    plain = gym.make(name)
    observation, _ = env.reset(seed=5)
    expected, _ = plain.reset(seed=5)
    assert np.array_equal(observation["state"], expected)
    assert observation["image"].shape == (480, 640, 3)
    assert env.observation_space["image"] == gym.spaces.Box(0, 255, (480, 640, 3), np.uint8)
    assert env.observation_space["state"] == plain.observation_space
    for _ in range(2):
        observation, reward, terminated, truncated, _ = env.step(ENVIRONMENTS[name])
        expected, expected_reward, *_ = plain.step(ENVIRONMENTS[name])
        assert np.array_equal(observation["state"], expected)
        assert reward == expected_reward
        assert env.observation_space["image"].contains(observation["image"])
        if terminated or truncated:
            break


def test_dictionaries_are_merged_flat():
    env = make("parking-v0")
    observation, _ = env.reset(seed=1)
    assert set(observation) == {"observation", "achieved_goal", "desired_goal", "image"}
    assert set(observation) == set(env.observation_space.spaces)


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_markings_are_bright_where_the_lanes_have_lines(name):
    env = make(name, rig=QUIET)
    observation, _ = env.reset(seed=2)
    picture = cv2.cvtColor(observation["image"], cv2.COLOR_RGB2GRAY).astype(float)
    world = env.unwrapped
    truth = env.renderer.truth(("instance",))["instance"]
    pose = np.array([*world.vehicle.position, world.vehicle.heading])
    contrasts = []
    for lane in world.road.network.lanes_list():
        for side, kind in enumerate(lane.line_types):
            if kind not in (LineType.CONTINUOUS, LineType.CONTINUOUS_LINE):
                continue
            for s in np.arange(0.0, lane.length, 0.5):
                edge = (side - 0.5) * lane.width_at(s)
                laterals = (edge, edge - 0.35, edge + 0.35)
                local = vehicle_from_world(np.array([lane.position(s, lateral) for lateral in laterals]), pose)
                if not (3.0 < local[0, 0] < 18.0 and abs(local[0, 1]) < 0.8 * local[0, 0]):
                    continue
                columns, rows = np.rint(project(Camera(), np.column_stack([local, np.zeros(3)]))).astype(int).T
                if (columns < 0).any() or (columns > 639).any() or (rows > 479).any() or truth[rows, columns].any():
                    continue
                line, left, right = picture[rows, columns]
                contrasts.append(line - max(left, right))
    assert len(contrasts) >= 5
    assert np.median(contrasts) > 40.0


@pytest.mark.parametrize("name", ["highway-v0", "merge-v0", "racetrack-v0"])
def test_cars_are_rendered_at_their_state(name):
    env = make(name, rig=QUIET)
    found = 0
    for seed in range(6):
        observation, _ = env.reset(seed=seed)
        world = env.unwrapped
        pose = np.array([*world.vehicle.position, world.vehicle.heading])
        truth = env.renderer.truth(("instance", "depth"))
        for index, obj in enumerate(env.renderer.objects):
            centre = vehicle_from_world(np.array(obj.position), pose)
            if not (8.0 < centre[0] < 45.0 and abs(centre[1]) < 0.7 * centre[0]):
                continue
            column, row = np.rint(project(Camera(), np.array([*centre, 0.7]))).astype(int)
            owner = truth["instance"][row, column]
            if owner != index + 1:  # occluded by a nearer object
                assert truth["depth"][row, column] < centre[0]
                continue
            found += 1
            assert abs(truth["depth"][row, column] + 0.8 - centre[0]) < 3.5
            mine = truth["instance"] == index + 1
            below = observation["image"][mine].astype(float)
            assert below.std() > 8.0  # windows, lamps, wheels: not a blank shape
    assert found >= 1


def test_reset_draws_a_new_road_and_a_seed_repeats_it():
    env = make("racetrack-v0")
    first = env.reset(seed=3)[0]["image"]
    renderer = env.renderer
    other = env.reset()[0]["image"]
    assert env.renderer is not renderer
    again = env.reset(seed=3)[0]["image"]
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def checker_warnings(env):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check_env(env, skip_render_check=True)
    return [str(warning.message).replace(str(env), "it") for warning in caught]


def test_gymnasiums_checker_finds_nothing_new_with_the_camera():
    plain = checker_warnings(gym.make("racetrack-v0"))
    assert plain, "expected warnings about the environment itself"
    assert checker_warnings(make("racetrack-v0")) == plain


def test_only_highway_environments_are_accepted():
    with pytest.raises(TypeError, match=r"expected a highway-env environment .* got CartPoleEnv"):
        vpf_sim.CameraObservation(gym.make("CartPole-v1"))
