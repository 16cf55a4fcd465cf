"""Who is asked at each frame, and how: our field drivers through a model vehicle, any other in the recorded state."""

from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from vpf_sim import drivers
from vpf_sim.controllers.gtsmc import Gains
from vpf_sim.drivers import FieldDriver
from vpf_sim.planning.planner import Planner, way
from vpf_sim.planning.variant import Variant
from vpf_sim.replay.model_vehicle import Interval, ModelVehicle
from vpf_sim.replay.present_lane import bodies_seen_from, is_found, present_lane, seen_from
from vpf_sim.replay.segments import Segment
from vpf_sim.types import Command, Driver, DriverSetup, Force, Observation, Perception, Plan, Reference, RoadEdges

MODEL = "a model vehicle carries the commands out, from the recorded place and speed at the start of each segment"
RECORDED = "asked at each recorded state"
# Roads of which nothing is known beforehand: ramps have lanes of 4.5 to 6 m, and a way leads from one to the next.
ANY_ROAD: dict[str, Any] = {"widest_lane_m": 6.5, "unlikely_per_m": 0.2, "keeps_width": False}


@dataclass(frozen=True, slots=True)
class Decision:
    """What a driver says at a frame; `road_found` is None for one that looks for no road of ours."""

    command: Command
    plan: Plan | None = None  # in the axes of the recorded car, for the overlay
    road_found: bool | None = None  # False: course and speed are kept, and nothing is scored
    is_held: bool = False  # the command is the last one: the flow is not to be trusted


class Pilot(Protocol):
    """A driver on a recording."""

    protocol: str  # how it is asked, in words
    restarts: int  # of the model vehicle within segments: it had left what the camera shows

    def begin(self, segment: Segment) -> None: ...

    def decide(self, observation: Observation, interval: Interval) -> Decision: ...


def pilot(driver: Driver, setup: DriverSetup) -> Pilot:
    """The way to ask a driver."""
    if isinstance(driver, FieldDriver):
        return FieldPilot(setup, driver.variant, driver.gains)
    return RecordedStatePilot(setup, driver)


class RecordedStatePilot:
    """Any driver, shown each frame with the state that was recorded there."""

    protocol = RECORDED

    def __init__(self, setup: DriverSetup, driver: Driver) -> None:
        self._driver = driver
        self.restarts = 0
        driver.reset(setup)

    def begin(self, segment: Segment) -> None:
        """The goal and speed of the setup hold for the whole recording: a driver is reset once."""

    def decide(self, observation: Observation, interval: Interval) -> Decision:  # noqa: ARG002
        command = drivers.command_of(self._driver, observation)
        return Decision(command, drivers.trace_of(self._driver))


class FieldPilot:
    """A variant of the method: it perceives from the recorded car, and plans and steers for the model vehicle."""

    protocol = MODEL

    def __init__(self, setup: DriverSetup, variant: Variant, gains: Gains) -> None:
        self._setup = setup
        self._variant = variant
        self._eyes = Planner(setup, replace(variant, road_edges=replace(variant.road_edges, **ANY_ROAD)))
        self._way = way(setup, variant)
        self._lane: RoadEdges | None = None
        self._model = ModelVehicle(gains, setup.vehicle, setup.rate_hz)
        self.restarts = 0

    def begin(self, segment: Segment) -> None:
        self._setup = replace(self._setup, goal_m=segment.goal_m, speed_reference_mps=segment.speed_mps)
        self._way = way(self._setup, self._variant)
        self._model.restart(segment.speed_mps)

    def decide(self, observation: Observation, interval: Interval) -> Decision:
        seen = self._eyes.perceive(observation)
        if self._eyes.has_missed:
            seen = replace(seen, expansion=replace(seen.expansion, confidence=0.0))
        found = is_found(seen.road, observation.speed_mps)
        lane = present_lane(seen.road, found)
        self._follow(lane)
        plan = self._planned(self._from_model(seen, lane), observation) if found else self._kept_on(seen, observation)
        command = self._model.drive(plan.reference, observation, interval)
        if self._model.is_far:
            self.restarts += 1
            self._model.restart(self._model.speed_mps)
        return Decision(command, self._shown(plan, replace(seen, road=lane)), found)

    def _planned(self, from_model: Perception, observation: Observation) -> Plan:
        force, reference, extra = self._way.step(from_model, self._at_model(observation))
        return Plan(from_model, force, self._eyes.unless_blind(reference, observation), extra)

    def _kept_on(self, seen: Perception, observation: Observation) -> Plan:
        """Course and speed as they are: without a lane there is nothing to decide by.

        The course is that of the recorded car. One straight on would leave what the camera shows in every bend.
        """
        none = np.zeros(2)
        course = Reference(observation.yaw_rad, self._model.speed_mps, observation.yaw_rate_radps)
        return Plan(seen, Force(none, none, none, none), course)

    def _follow(self, lane: RoadEdges) -> None:
        """Begin anew from the present place where it is suddenly another lane that is followed."""
        last, self._lane = self._lane, lane
        if last is None:
            return
        found = (last.confidence > 0.0) != (lane.confidence > 0.0)
        if found or abs(lane.lane_m - last.lane_m) > 0.5 * lane.lane_width_m:
            self._way = way(self._setup, self._variant)

    def _from_model(self, seen: Perception, lane: RoadEdges) -> Perception:
        right, turn = self._model.right_m, self._model.turn_rad
        return replace(seen, road=seen_from(lane, right, turn), obstacles=bodies_seen_from(seen.obstacles, right, turn))

    def _at_model(self, observation: Observation) -> Observation:
        recorded = np.array([observation.x_m, observation.y_m, observation.yaw_rad])
        x, y, yaw = (float(value) for value in self._model.pose(recorded))
        return replace(observation, x_m=x, y_m=y, yaw_rad=yaw)

    def _shown(self, plan: Plan, seen: Perception) -> Plan:
        """The plan with what is seen from the recorded car: the lane by its own two lines, the way from the car."""
        half, middle = 0.5 * seen.road.lane_width_m, seen.road.lane_m
        road = replace(seen.road, left_m=middle - half, right_m=middle + half)
        extra = dict(plan.extra)
        if "lane" in extra:
            extra["lane"] = replace(extra["lane"], y_m=-middle)
        return Plan(replace(seen, road=road), plan.force, plan.reference, extra)
