"""Drivers on recordings: vision drivers steer a model vehicle, others get the recorded state."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Protocol

from vpf_sim import drivers
from vpf_sim.controllers.gtsmc import Gains
from vpf_sim.driver_interface import Command, Driver, DriverSetup, Observation
from vpf_sim.drivers import VisionDriver
from vpf_sim.drivers.learned.driver import OnnxDriver
from vpf_sim.drivers.perceiver import Perceiver
from vpf_sim.errors import InputError
from vpf_sim.perception.road.road_settings import RoadEdgeConfig
from vpf_sim.planning.paper.planner import PaperPlan
from vpf_sim.planning.planner import create_planner
from vpf_sim.planning.scene_planner import ScenePlanner
from vpf_sim.planning.spacetime.motion import MotionPlan
from vpf_sim.planning.variant import Variant
from vpf_sim.replay.fixed_structure import FixedStructure
from vpf_sim.replay.model_vehicle import Interval, ModelVehicle, Segment
from vpf_sim.replay.present_lane import (
    LaneSupport,
    is_found,
    obstacles_in_vehicle_frame,
    present_lane,
    road_in_vehicle_frame,
)
from vpf_sim.replay.records import Fault
from vpf_sim.types import NO_FORCE, Perception, Plan, Reference, RoadEdges

MODEL = "a model vehicle carries out the commands, from the recorded position and speed at the start of each segment"
RECORDED = "evaluated at each recorded state"


@dataclass(frozen=True, slots=True)
class Decision:
    """A driver's decision at a frame; `road_found` is None for drivers without lane detection."""

    command: Command
    plan: Plan | None = None  # in the axes of the recorded car, for the overlay
    road_found: bool | None = None  # False: course and speed are held, not scored
    is_held: bool = False  # the last command, since the flow is unreliable


def any_road(config: RoadEdgeConfig) -> RoadEdgeConfig:
    """Settings for unknown roads: ramps have lanes of 4.5 to 6 m, and a drive leads from one road to the next."""
    return replace(config, widest_lane_m=6.5, unlikely_per_m=0.2, keeps_width=False)


class OpenLoopDriver(Protocol):
    """A driver on a recording."""

    protocol: str  # how it is evaluated, for the tables
    restarts: int  # of the model vehicle within segments, after it left the camera's view

    def begin(self, segment: Segment) -> None: ...

    def decide(self, observation: Observation, interval: Interval) -> Decision: ...

    def unlike_training(self) -> str:
        """What is unlike the inputs that a learned driver was trained on, in one line; else empty."""


def open_loop_driver(driver: Driver, setup: DriverSetup, fixed: FixedStructure | None = None) -> OpenLoopDriver:
    """The open-loop form of a driver; what is `fixed` to the camera supports no lane."""
    if isinstance(driver, VisionDriver):
        return ModelVehicleDriver(setup, driver.variant, driver.gains, fixed)
    return RecordedStateDriver(setup, driver)


class RecordedStateDriver:
    """Any driver, given each frame with the state recorded there."""

    protocol = RECORDED

    def __init__(self, setup: DriverSetup, driver: Driver) -> None:
        self._driver = driver
        self.restarts = 0
        driver.reset(setup)

    def begin(self, segment: Segment) -> None:
        """Nothing: the goal and speed of the setup hold for the whole recording."""

    def decide(self, observation: Observation, interval: Interval) -> Decision:  # noqa: ARG002
        command = drivers.command_of(self._driver, observation)
        return Decision(command, drivers.trace_of(self._driver))

    def unlike_training(self) -> str:
        return self._driver.unlike_training() if isinstance(self._driver, OnnxDriver) else ""


class ModelVehicleDriver:
    """A vision driver: it perceives from the recorded car and steers the model vehicle."""

    protocol = MODEL

    def __init__(self, setup: DriverSetup, variant: Variant, gains: Gains, fixed: FixedStructure | None = None) -> None:
        self._setup = setup
        self._support = LaneSupport(setup.camera, variant.road_edges, fixed)
        self._variant = variant
        self._perceiver = Perceiver(setup, replace(variant, road_edges=any_road(variant.road_edges)))
        self._planner = create_planner(setup, variant)
        self._lane: RoadEdges | None = None
        self._model = ModelVehicle(gains, setup.vehicle, setup.rate_hz)
        self.restarts = 0

    def begin(self, segment: Segment) -> None:
        self._setup = replace(self._setup, goal_m=segment.goal_m, speed_reference_mps=segment.speed_mps)
        self._planner = create_planner(self._setup, self._variant)
        self._model.restart(segment.speed_mps)

    def decide(self, observation: Observation, interval: Interval) -> Decision:
        perception = self._perceiver.perceive(observation)
        if self._perceiver.has_missed:
            perception = replace(perception, expansion=replace(perception.expansion, confidence=0.0))
        found = self._is_found(perception.road, observation)
        lane = present_lane(perception.road, found)
        self._restart_in_new_lane(lane)
        perception = replace(perception, road=lane)
        perception = self._planner.observe(perception, observation, self._perceiver.evidence)
        plan = self._planned(perception, observation) if found else self._hold_course(perception, observation)
        command = self._model.drive(plan.reference, observation, interval)
        if self._model.is_far:
            self.restarts += 1
            self._model.restart(self._model.speed_mps)
        return Decision(command, self._in_recorded_axes(plan, perception), found)

    def unlike_training(self) -> str:
        return ""

    def _is_found(self, road: RoadEdges, observation: Observation) -> bool:
        """Whether the tracked lane can be the car's, and the image supports it."""
        if not is_found(road, observation.speed_mps):
            self._support.forget()
            return False
        return self._support.update(observation.image, road, observation.time_s)

    def _planned(self, perception: Perception, observation: Observation) -> Plan:
        """The plan of the model vehicle, which moves at the recorded speed but has a speed of its own."""
        seen, at_model = self._seen_from_model(perception), self._at_model(observation, observation.speed_mps)
        limit_mps = self._perceiver.limit_mps(observation)
        if isinstance(self._planner, ScenePlanner):
            self._planner.plan(seen, self._at_model(observation, self._model.speed_mps), limit_mps)
            return Plan(seen, *self._planner.follow(at_model))
        return Plan(seen, *self._planner.step(seen, at_model, limit_mps))

    def _hold_course(self, perception: Perception, observation: Observation) -> Plan:
        """Hold course and speed, since without a lane there is no basis for a decision.

        The course is that of the recorded car: a straight one would leave the camera's view in every bend.
        """
        course = Reference(observation.yaw_rad, self._model.speed_mps, observation.yaw_rate_radps)
        return Plan(perception, NO_FORCE, course)

    def _restart_in_new_lane(self, lane: RoadEdges) -> None:
        """Restart the planner where the followed lane changes."""
        last, self._lane = self._lane, lane
        if last is None:
            return
        found = (last.confidence > 0.0) != (lane.confidence > 0.0)
        if found or abs(lane.lane_m - last.lane_m) > 0.5 * lane.lane_width_m:
            self._planner = create_planner(self._setup, self._variant)

    def _seen_from_model(self, perception: Perception) -> Perception:
        right, turn = self._model.right_m, self._model.turn_rad
        return replace(
            perception,
            road=road_in_vehicle_frame(perception.road, right, turn),
            obstacles=obstacles_in_vehicle_frame(perception.obstacles, right, turn),
        )

    def _at_model(self, observation: Observation, speed_mps: float) -> Observation:
        """The model vehicle's place, turned as its wheels are, at a speed."""
        x, y, yaw = (float(value) for value in self._model.pose(observation.pose))
        turn = self._model.yaw_rate_radps(speed_mps)
        return replace(observation, x_m=x, y_m=y, yaw_rad=yaw, speed_mps=speed_mps, yaw_rate_radps=turn)

    def _in_recorded_axes(self, plan: Plan, perception: Perception) -> Plan:
        """The plan in the axes of the recorded car: its lane and its path."""
        half, middle = 0.5 * perception.road.lane_width_m, perception.road.lane_m
        road = replace(perception.road, left_m=middle - half, right_m=middle + half)
        extra = plan.extra
        if isinstance(extra, PaperPlan):
            extra = replace(extra, lane=replace(extra.lane, y_m=-middle))
        elif isinstance(extra, MotionPlan):
            extra = replace(extra, pose=perception.pose)
        return Plan(replace(perception, road=road), plan.force, plan.reference, extra)


class DriverError(Exception):
    """The driver raised at a frame; the exception itself is its cause."""

    def __init__(self, frame: int, error: BaseException) -> None:
        self.frame = frame
        self.error = error
        super().__init__(f"frame {frame}, at {place(error)}: {what(error)}")

    def fault(self) -> Fault:
        """The `error` of the drive's record."""
        return Fault(frame=self.frame, place=place(self.error), what=what(self.error))


@contextmanager
def at_frame(frame: int) -> Iterator[None]:
    """Turn exceptions other than InputError into a DriverError at this frame."""
    try:
        yield
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        raise DriverError(frame, error) from error


def place(error: BaseException) -> str:
    """Module, line and function where an exception was raised."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    if trace is None:
        return "an unknown place"
    code = trace.tb_frame
    return f"{code.f_globals.get('__name__', code.f_code.co_filename)}:{trace.tb_lineno} in {code.f_code.co_name}"


def what(error: BaseException) -> str:
    """The exception in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())
