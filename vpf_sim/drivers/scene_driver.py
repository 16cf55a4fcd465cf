"""The coming form of `vpf`: what its camera perceives as a scene, and the planner in space and time on it."""

from typing import TYPE_CHECKING

import numpy as np

from vpf_sim.timing import call
from vpf_sim.types import Command, Driver, DriverSetup, Force, Observation, Perception, Plan, Privilege, Reference

if TYPE_CHECKING:
    from vpf_sim.planning.spacetime.planner import Motion

VARIANT = "robust"  # of the perception
REPLAN_S = 0.1
EXACT_S = 1e-6  # rounding of times
LOST_ROAD_MPS, LOST_ROAD_M = 1.0, 12.0  # where the road is not seen: this fast, this far
NO_FORCE = Force(*np.zeros((4, 2)))


class SceneDriver(Driver):
    """Drives by camera: `vpf`'s perception fills the scene in which `expert` plans."""

    privileged: Privilege = "none"

    def reset(self, setup: DriverSetup) -> None:
        from vpf_sim.drivers.perceiver import Perceiver
        from vpf_sim.perception.egomotion.odometry import Odometry
        from vpf_sim.perception.plausible import Plausibility
        from vpf_sim.planning import variant as variants
        from vpf_sim.planning.spacetime import settings
        from vpf_sim.planning.spacetime.planner import SpacetimePlanner
        from vpf_sim.scene.camera import CameraScene

        self._setup, self._variant = setup, variants.load(VARIANT)
        self._perceiver = Perceiver(setup, self._variant)
        self._plausibility = Plausibility(self._variant.plausibility, setup.vehicle)
        self._odometry = Odometry(self._variant.odometry, setup.vehicle) if self._variant.odometry else None
        self._scene = CameraScene(self._variant.road_edges.object_sizes)
        self._planner = SpacetimePlanner(settings.load(), setup.vehicle)
        self._lost_m = 0.0  # way since the road was seen
        self.motion: Motion | None = None
        self._plan: Plan | None = None

    def act(self, observation: Observation) -> Command:
        observation = self._measured(observation)
        perception = self._perceiver.perceive(observation)
        if self._perceiver.has_processed:
            call("tracking", self._scene.observe, perception, observation)
        if self.motion is None or observation.time_s >= self.motion.time_s + REPLAN_S - EXACT_S:
            self.motion = call("plan", self._replan, perception, observation)
        return call("control", self._follow, self.motion, perception, observation)

    def perceive(self, observation: Observation) -> Perception:
        """What `act` would perceive, without planning or steering; one of the two is called each step."""
        return self._perceiver.perceive(self._measured(observation))

    def _measured(self, observation: Observation) -> Observation:
        observation = self._plausibility.update(observation)
        return observation if self._odometry is None else self._odometry.update(observation)

    def _replan(self, perception: Perception, observation: Observation) -> "Motion":
        speed_mps = self._speed_reference(perception, observation)
        return self._planner.plan(self._scene.scene(observation, speed_mps))

    def _speed_reference(self, perception: Perception, observation: Observation) -> float:
        """m/s, the reference speed, less where too little is seen."""
        from vpf_sim.planning.lane.speed.clear_distance import speed_within_clear_distance

        allowed, lane = self._setup.speed_reference_mps, self._variant.lane_planner
        if lane is not None and lane.clear_distance is not None:
            range_m = perception.low_range_m
            allowed = min(allowed, speed_within_clear_distance(range_m, lane.clear_distance, lane.braking, self._setup))
        seen = max(perception.road.confidence, perception.road.lane_confidence) > 0.0
        self._lost_m = 0.0 if seen else self._lost_m + observation.speed_mps * REPLAN_S
        if not seen:
            allowed = min(allowed, LOST_ROAD_MPS if self._lost_m < LOST_ROAD_M else 0.0)
        return self._perceiver.stop_when_blind(Reference(observation.yaw_rad, allowed), observation).speed_mps

    def _follow(self, motion: "Motion", perception: Perception, observation: Observation) -> Command:
        from vpf_sim.controllers import trajectory
        from vpf_sim.planning.spacetime.tracking import target

        assert self._scene.road is not None
        place, vehicle = self._scene.place(observation), self._setup.vehicle
        wanted = target(motion, self._scene.road, observation, place, vehicle)
        heading_rad = observation.yaw_rad - wanted.course_error_rad
        self._plan = Plan(perception, NO_FORCE, Reference(heading_rad, wanted.speed_mps))
        return trajectory.command(wanted, observation.speed_mps, vehicle)

    @property
    def needs_next_frame(self) -> bool:
        """Whether it processes the next frame."""
        return self._perceiver.needs_next_frame

    def trace(self) -> Plan | None:
        """The plan of the last step, for overlays and scores."""
        return self._plan
