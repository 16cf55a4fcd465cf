"""Planning and control are total: whatever is perceived or requested, the command is finite and in its limits."""

import re
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from typing import Any

import ideal
import numpy as np
import pytest
import total_scenes as scenes
from examples_of import MANY, check
from hypothesis import strategies as st

from vpf_sim import drivers
from vpf_sim.controllers.gtsmc import Gtsmc, load_gains
from vpf_sim.driver_interface import Command, DriverSetup, Observation
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.episode.episode import setup_for
from vpf_sim.perception.obstacles.prediction import none
from vpf_sim.planning.planner import create_planner
from vpf_sim.replay.model_vehicle import Interval, ModelVehicle
from vpf_sim.scene.evidence import NO_EVIDENCE
from vpf_sim.types import Floats, LowObstacleRange, Obstacles, Reference, RoadEdges

GAINS = ("literal", "paper", "super-twisting", "motion")


def assert_command(command: Command) -> None:
    assert np.isfinite([command.throttle, command.steering]).all(), command
    assert max(abs(command.throttle), abs(command.steering)) <= 1.0 + 1e-9, command


def assert_plans_and_commands(drive: scenes.Drive) -> None:
    """The planner in its frames, and the controller that follows it."""
    plans = create_planner(drive.setup, drive.configuration)
    controller = Gtsmc(load_gains(drive.configuration.gains), drive.setup.vehicle, drive.setup.rate_hz)
    for perception, observation in drive.frames():
        seen = plans.observe(perception, observation, NO_EVIDENCE)
        force, reference, _ = plans.step(seen, observation)
        assert np.isfinite([reference.heading_rad, reference.speed_mps, reference.heading_rate_radps or 0.0]).all()
        assert np.isfinite(force.total).all()
        assert_command(controller.command(observation, reference))


@pytest.mark.parametrize("examples", MANY)
def test_any_scene_gives_a_command(examples: int) -> None:
    check(examples, scenes.drives(), assert_plans_and_commands)


@pytest.mark.parametrize("rate_hz", [5.0, 10.0, 20.0])
@pytest.mark.parametrize("aside_m", [-3.0, 1.0, 3.0])
def test_a_speed_that_jumps_leaves_the_path_a_direction(rate_hz: float, aside_m: float) -> None:
    """As one that is derived from the flow does."""
    setup = DriverSetup(scenes.CAMERA, scenes.VEHICLE, rate_hz, 8.0, (50.0, 0.0), 0)
    plans = create_planner(setup, scenes.load("robust"))
    seen = ideal.perception(RoadEdges(-6.0 - aside_m, 6.0 - aside_m, 0.0, 0.0, 0.02, 1.0, -aside_m, 3.5), none())
    for k, speed_mps in enumerate([1.2, 1.2, 57.0, 1.2, 1.2, 1.2, 57.0, 57.0, 0.0, 57.0]):
        observation = Observation(scenes.NO_IMAGE, k / rate_hz, 0.0, 0.0, 0.0, speed_mps, 0.0, (50.0, 0.0))
        _, reference, _ = plans.step(plans.observe(seen, observation, NO_EVIDENCE), observation)
        assert abs(reference.heading_rad) < 0.5 * np.pi
        assert np.isfinite([reference.speed_mps, reference.heading_rate_radps or 0.0]).all()


@pytest.mark.parametrize("variant", scenes.VARIANTS)
def test_a_drive_that_begins_standing_has_a_reference(variant: str) -> None:
    """Its speed to keep is none."""
    setup = DriverSetup(scenes.CAMERA, scenes.VEHICLE, 20.0, 0.0, (50.0, 0.0), 0)
    none = np.empty(0)
    nobody = Obstacles(none, none, none, none, none, np.empty(0, np.int64))
    seen = ideal.perception(RoadEdges(-5.0, 5.0, 0.0, 0.0, 0.02, 1.0, 0.0, 3.5), nobody)
    plans = create_planner(setup, scenes.load(variant))
    observation = Observation(scenes.NO_IMAGE, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, (50.0, 0.0))
    seen = plans.observe(replace(seen, low_range_m=LowObstacleRange(10.0, 20.0)), observation, NO_EVIDENCE)
    _, reference, _ = plans.step(seen, observation)
    assert reference.heading_rad == pytest.approx(0.0, abs=0.01)
    assert reference.speed_mps <= 0.0, "below 0 it holds the car by its brake"


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"rate_hz": 0.0}, "rate_hz: expected a finite number > 0, got 0.0"),
        ({"speed_reference_mps": float("nan")}, "speed_reference_mps: expected a finite number >= 0, got nan"),
        ({"goal_m": (float("inf"), 0.0)}, "goal_m: expected finite numbers"),
        ({"route": np.zeros((5, 2))}, "route: expected finite waypoints, two of them apart"),
    ],
)
def test_a_setup_that_no_drive_has_is_refused(change: dict[str, Any], sentence: str) -> None:
    setup = DriverSetup(scenes.CAMERA, scenes.VEHICLE, 20.0, 8.0, (50.0, 0.0), 0)
    with pytest.raises(ValueError, match=re.escape(sentence)):
        replace(setup, **change)


@st.composite
def references(draw: st.DrawFn) -> Reference:
    """Any that is finite."""
    finite = st.floats(allow_nan=False, allow_infinity=False)
    heading, speed, rate = scenes.near(-3.2, 3.2), scenes.near(0.0, 60.0), scenes.near(-1.0, 1.0)
    return Reference(draw(heading), draw(speed), draw(st.one_of(st.none(), rate, finite)))


@st.composite
def observations(draw: st.DrawFn) -> Observation:
    """Any place, speed and turn."""
    x, y = draw(scenes.PLACES), draw(scenes.PLACES)
    yaw, rate = draw(scenes.near(-3.2, 3.2)), draw(scenes.near(-1.0, 1.0))
    return Observation(scenes.NO_IMAGE, 0.0, x, y, yaw, draw(scenes.SPEEDS), rate, (0.0, 0.0))


STEPS = st.lists(st.tuples(observations(), references()), min_size=1, max_size=12)


def assert_controls(gains: str, rate_hz: float, steps: list[tuple[Observation, Reference]]) -> None:
    """The controller alone, on references that no planner has bounded."""
    controller = Gtsmc(load_gains(gains), scenes.VEHICLE, rate_hz)
    for observation, reference in steps:
        assert_command(controller.command(observation, reference))


def assert_carries_out(gains: str, rate_hz: float, steps: list[tuple[Observation, Reference]]) -> None:
    """The model vehicle of a replay, from each recorded pose to the next, however far that is."""
    model = ModelVehicle(load_gains(gains), scenes.VEHICLE, rate_hz)
    for (observation, reference), (after, _) in zip(steps, steps[1:] + steps[:1], strict=True):
        poses: list[Floats] = [np.array([one.x_m, one.y_m, one.yaw_rad]) for one in (observation, after)]
        assert_command(model.drive(reference, observation, Interval(*poses, 1.0 / rate_hz)))
        assert np.isfinite([model.right_m, model.turn_rad, model.speed_mps]).all()


@pytest.mark.parametrize("examples", MANY)
@pytest.mark.parametrize("assert_law", [assert_controls, assert_carries_out])
def test_any_reference_gives_a_command(assert_law: Callable[..., None], examples: int) -> None:
    given = st.tuples(st.sampled_from(GAINS), st.floats(5.0, 120.0), STEPS)
    check(examples, given, lambda one: assert_law(*one))


@st.composite
def routes(draw: st.DrawFn) -> Floats:
    """Waypoints that go on by a metre, stay where they are, or turn back at once."""
    steps = draw(st.lists(st.tuples(st.floats(-1.0, 1.0), st.sampled_from([0.0, 0.0, 1.0])), min_size=1, max_size=40))
    points = np.cumsum([(0.0, 0.0), *steps], axis=0)
    return points if np.ptp(points, axis=0).any() else np.vstack([points, [[1.0, 0.0]]])


def assert_follows(name: str, setup: DriverSetup, route: Floats, seen: list[Observation]) -> None:
    """A baseline along a route."""
    driver = drivers.create(name)
    driver.reset(replace(setup, route=route))
    for observation in seen:
        assert_command(driver.act(observation))


FOLLOWERS = st.sampled_from(["pid", "pure-pursuit", "stanley", "neutral"])
SEEN = st.lists(observations(), min_size=1, max_size=12)


@pytest.mark.parametrize("examples", MANY)
def test_any_route_gives_a_command(examples: int) -> None:
    check(examples, st.tuples(FOLLOWERS, scenes.setups(), routes(), SEEN), lambda one: assert_follows(*one))


@pytest.fixture(scope="module")
def traffic() -> Iterator[FourLane]:
    """A road with other cars on it."""
    with closing(FourLane("traffic", "clear", frames=False)) as env:
        env.reset(seed=1)
        yield env


def test_any_place_on_or_off_the_road_gives_a_command(traffic: FourLane) -> None:
    """Of the one baseline that is told the world."""

    def assert_drives(given: tuple[float, list[Observation]]) -> None:
        driver = drivers.create("idm")
        driver.reset(replace(setup_for(driver, traffic, 1), speed_reference_mps=given[0]))
        for observation in given[1]:
            assert_command(driver.act(observation))

    check(50, st.tuples(scenes.SPEEDS, SEEN), assert_drives)
