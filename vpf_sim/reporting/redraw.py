"""Re-renders an episode of a run folder from its steps and seed.

The stored poses give the frames, and the driver recomputes its plans on them. With the run's code and machine both are
identical to the run; the hash of the frames verifies it.
"""

from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, field
from math import isfinite

from vpf_sim import drivers
from vpf_sim.driver_interface import Command, Driver, Observation
from vpf_sim.envs.contacts import solid_objects
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.envs.network import OnRoad
from vpf_sim.errors import InputError
from vpf_sim.evaluation.episode.episode import read, setup_for
from vpf_sim.evaluation.episode.pose_playback import PosePlayback, rate_of
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.reporting.run_data import StoredRun
from vpf_sim.reporting.top_view import Rectangle, Scene
from vpf_sim.types import Camera, Image, Plan


@dataclass(frozen=True, slots=True)
class Moment:
    """One frame of the episode, with plan and objects."""

    index: int  # the row of the step table
    image: Image  # (H, W, 3) RGB
    plan: Plan | None
    objects: tuple[Rectangle, ...]


@dataclass(slots=True)
class Redrawing:
    """An episode to re-render; after `moments` ends, `remarks` lists deviations from the run."""

    record: Record
    table: StepTable
    replan: bool  # whether the driver recomputes its plans
    inputs: RunInputs = field(default_factory=RunInputs)
    remarks: list[str] = field(default_factory=list)
    camera: Camera = field(init=False)
    scene: Scene = field(init=False)
    rate_hz: float = field(init=False)

    def __post_init__(self) -> None:
        self.rate_hz = rate_of(self.table)
        with closing(self._world()) as world:
            world.reset(seed=self.record.seed)
            self.camera, self.scene = world.camera, scene_of(world)

    def moments(self) -> Iterator[Moment]:
        """Yield every frame in order, with the driver's plan if `replan` is set and it has one."""
        replanner: _Replanner | None = None
        with closing(self._world()) as world:
            for frame in world.play(self.record.seed):
                if self.replan and replanner is None and self.record.driver != drivers.KEYBOARD:
                    replanner = _Replanner(self, world)
                observation = read(frame.observed)
                objects = tuple(rectangle_of(obj) for obj in solid_objects(world.ego))
                plan = replanner.plan(frame.index, observation) if replanner else None
                yield Moment(frame.index, observation.image, plan, objects)
        self.remarks[:0] = world.deviations(self.record)

    def _world(self) -> PosePlayback:
        return PosePlayback.of(self.record, self.table, self.inputs)


class _Replanner:
    """Recomputes the driver's plans."""

    def __init__(self, drawn: Redrawing, world: FourLane) -> None:
        self.remarks = drawn.remarks
        self._table = drawn.table
        self._driver: Driver | None = None
        try:
            driver = drivers.create(drawn.inputs.driver(drawn.record.driver))
            driver.reset(setup_for(driver, world, drawn.record.seed))
            self._driver = driver
        except InputError as error:  # a class of a notebook, or of a module that has moved
            self.remarks.append(f"without the driver's view: {error}{drawn.inputs.place}")
        except (Exception, SystemExit) as error:  # raised by the driver
            self.remarks.append(f"without the driver's view: its reset fails: {type(error).__name__}: {error}")

    def plan(self, index: int, observation: Observation) -> Plan | None:
        """The plan for a frame; None if the driver has none, failed, or gave no command in the run."""
        if self._driver is None or not isfinite(self._table.throttle[index]):
            return None
        try:
            command, plan = drivers.command_of(self._driver, observation), drivers.trace_of(self._driver)
        except (Exception, SystemExit) as error:  # raised by the driver
            self.remarks.append(f"the driver fails on frame {index}: {type(error).__name__}: {error}")
            self._driver = None
            return None
        if not self.remarks and command != Command(
            float(self._table.throttle[index]), float(self._table.steering[index])
        ):
            self.remarks.append(f"from frame {index} on the driver's commands differ from the run")
        return plan


def redrawing(run: StoredRun, episode_id: str, replan: bool) -> Redrawing:
    """The episode of a run folder with this id."""
    record = run.record(episode_id)
    table = run.steps(episode_id)
    if table is None:
        raise InputError(f"{episode_id}: expected an episode with steps, got one that {run.why_no_steps(episode_id)}")
    return Redrawing(record, table, replan, run.inputs)


def scene_of(world: FourLane) -> Scene:
    """The static scene of an environment in world axes."""
    return Scene(world.road.network.lines(), world.route.copy(), world.goal_m)


def rectangle_of(obj: OnRoad) -> Rectangle:
    """The outline of an object of the environment."""
    x_m, y_m = (float(value) for value in obj.position)
    return Rectangle(x_m, y_m, float(obj.heading), float(obj.LENGTH), float(obj.WIDTH), str(obj.kind))
