"""The scene planner: tracks the scene of road and obstacles by camera, and plans in it in space and time."""

from dataclasses import replace
from math import inf

from vpf_sim.driver_interface import DriverSetup, Observation
from vpf_sim.planning.planner_interface import Planned, Planner
from vpf_sim.planning.spacetime.replanning import REPLAN_S, MotionReplanner
from vpf_sim.planning.visibility import SpeedInSight
from vpf_sim.scene.camera import CameraScene
from vpf_sim.scene.evidence import NO_EVIDENCE, Evidence
from vpf_sim.scene.scene_settings import SceneConfig
from vpf_sim.timing import call
from vpf_sim.types import NO_FORCE, Perception


class ScenePlanner(Planner):
    """Plans as `expert` does, in the scene that the camera shows."""

    def __init__(self, setup: DriverSetup, config: SceneConfig, in_sight: SpeedInSight) -> None:
        self._setup, self._in_sight = setup, in_sight
        self._scene = CameraScene(setup.camera, setup.vehicle, config)
        self._motion = MotionReplanner(setup.vehicle)

    def observe(self, perception: Perception, observation: Observation, evidence: Evidence | None) -> Perception:
        """The perception with the tracks of the scene as its obstacles."""
        if evidence is not None or self._scene.road is None:
            call("tracking", self._scene.observe, perception, observation, evidence or NO_EVIDENCE)
        return replace(perception, obstacles=self._scene.obstacles(observation))

    def step(self, perception: Perception, observation: Observation, limit_mps: float = inf) -> Planned:
        self.plan(perception, observation, limit_mps)
        return self.follow(observation)

    def plan(self, perception: Perception, observation: Observation, limit_mps: float) -> None:
        """Plan a new motion from the observed state, where one is due."""
        if self._motion.is_due(observation.time_s):
            in_sight = self._in_sight.limit(perception, observation.speed_mps * REPLAN_S)
            speed_mps = min(self._setup.speed_reference_mps, in_sight, limit_mps)
            self._motion.plan(self._scene.scene(observation, speed_mps))

    def follow(self, observation: Observation) -> Planned:
        """The last motion's reference at an observation."""
        assert self._scene.road is not None  # since the first observation
        return NO_FORCE, *self._motion.follow(self._scene.road, observation, self._scene.place(observation))
