"""Whole drivers on frames from the camera: no direction of the world is special, nor its left or right."""

from contextlib import closing
from dataclasses import dataclass, replace
from math import radians
from pathlib import Path

import numpy as np
import pytest

from vpf_sim import drivers, scenarios
from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.drivers import command_of, trace_of
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.episode.episode import read, setup_for
from vpf_sim.geometry import rotation, wrap_angle
from vpf_sim.perception.paper import obstacle_map
from vpf_sim.planning.spacetime.motion import MotionPlan
from vpf_sim.types import Floats, Plan

FRAMES = 60
PAST_A_CAR = """
schema = 1
[road]
segments = [{kind = "arc", length_m = 120, radius_m = 150}]
[goal]
s_m = 60.0
[[bodies]]
kind = "car"
s_m = 22.0
lane = 2
lateral_m = 0.9
"""


@dataclass(frozen=True)
class Drive:
    """What a driver was told and saw."""

    setup: DriverSetup
    seen: list[Observation]


@pytest.fixture(scope="module")
def drive() -> Drive:
    """`vpf` passes a parked car in a bend."""
    with closing(FourLane(scenarios.parse(PAST_A_CAR, "past a car"))) as env:
        observed, _ = env.reset(seed=3)
        driver = drivers.create("vpf")
        setup = setup_for(driver, env, 3)
        driver.reset(setup)
        seen = []
        for _ in range(FRAMES):
            seen.append(read(observed))
            command = command_of(driver, seen[-1])
            observed, *_ = env.step(np.array([command.throttle, command.steering]))
    return Drive(setup, seen)


def moved(drive: Drive, turn_rad: float, shift_m: tuple[float, float]) -> Drive:
    """The same in a world that is turned about its origin, then moved."""

    def place(x_m: float, y_m: float) -> tuple[float, float]:
        x, y = (rotation(turn_rad) @ [x_m, y_m] + shift_m).tolist()
        return x, y

    seen = []
    for one in drive.seen:
        x, y = place(one.x_m, one.y_m)
        seen.append(replace(one, x_m=x, y_m=y, yaw_rad=wrap_angle(one.yaw_rad + turn_rad), goal_m=place(*one.goal_m)))
    return Drive(replace(drive.setup, goal_m=place(*drive.setup.goal_m)), seen)


def in_the_mirror(drive: Drive) -> Drive:
    """Left for right; the pictures, too."""
    seen = [
        replace(
            one,
            image=np.ascontiguousarray(one.image[:, ::-1]),
            y_m=-one.y_m,
            yaw_rad=-one.yaw_rad,
            yaw_rate_radps=-one.yaw_rate_radps,
            goal_m=(one.goal_m[0], -one.goal_m[1]),
        )
        for one in drive.seen
    ]
    return Drive(replace(drive.setup, goal_m=(drive.setup.goal_m[0], -drive.setup.goal_m[1])), seen)


def driven(name: str, drive: Drive) -> tuple[Floats, Plan]:
    """(n, 2) commands at what was seen, and the last plan."""
    driver = drivers.create(name)
    driver.reset(drive.setup)
    commands = [command_of(driver, one) for one in drive.seen]
    plan = trace_of(driver)
    assert plan is not None
    return np.array([(command.throttle, command.steering) for command in commands]), plan


@pytest.mark.parametrize("name", ["vpf", "vpf-paper"])
def test_turning_and_moving_the_world_changes_no_command(name: str, drive: Drive) -> None:
    here, plan = driven(name, drive)
    there, _ = driven(name, moved(drive, radians(137.0), (600.0, -800.0)))
    assert there == pytest.approx(here, abs=1e-6)
    assert np.abs(here[:, 1]).max() > 0.05
    assert name == "vpf-paper" or len(plan.perception.obstacles) > 0
    assert plan.force.total == pytest.approx(plan.force.target + plan.force.obstacle + plan.force.road)


def test_literal_is_not_equivariant(drive: Drive) -> None:
    """The transposed rotation and the angle of the world make headings off the X axis special."""
    (_, here), (_, away) = (driven("vpf-literal", one) for one in (drive, moved(drive, radians(30.0), (0.0, 0.0))))
    turn = wrap_angle(away.reference.heading_rad - here.reference.heading_rad)
    assert abs(wrap_angle(turn - radians(30.0))) > radians(10.0)


def test_the_obstacle_map_is_computed_once_where_it_is_asked_for(drive: Drive, monkeypatch: pytest.MonkeyPatch) -> None:
    requested, detect = [], obstacle_map.detect
    monkeypatch.setattr(obstacle_map, "detect", lambda *given: requested.append(0) or detect(*given))
    seen = driven("vpf", drive)[1].perception
    assert not requested, "the scene planner goes by obstacles"
    shapes = {found.shape for found in (seen.features.obstacle_map.on_obstacle, seen.features.ttc_s)}
    assert shapes == {seen.flow.points_px.shape[:1]}
    assert len(requested) == 1


def test_the_mirror_image_is_seen_and_planned_the_other_way(drive: Drive, tmp_path: Path) -> None:
    """Not to the last digit: which of two alike corners is taken depends on the order of the pixels."""
    own = tmp_path / "mirrored.toml"
    own.write_text("[road_edges]\nlikely_lane = 3\n")
    here, plan = driven("vpf", drive)
    there, seen = driven(f"vpf@{own}", in_the_mirror(drive))
    assert seen.perception.road.left_m == pytest.approx(-plan.perception.road.right_m, abs=0.01)
    assert seen.perception.road.heading_rad == pytest.approx(-plan.perception.road.heading_rad, abs=2e-3)
    assert seen.perception.road.curvature_per_m == pytest.approx(-plan.perception.road.curvature_per_m, abs=1e-3)
    assert isinstance(seen.extra, MotionPlan)
    assert isinstance(plan.extra, MotionPlan)
    end_m, mirrored_m = (float(one.extra.motion.path.end_m[0]) for one in (plan, seen))
    assert mirrored_m == pytest.approx(-end_m, abs=0.15)
    assert end_m < -0.5
    assert here[:, 1].min() < -0.1
    assert there[:, 1].max() > 0.1
