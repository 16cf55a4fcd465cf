"""The camera's perception of `vpf` as a scene of road and tracks, and the planner in space and time on it."""

from dataclasses import replace

from vpf_sim.driver_interface import Command, Driver, DriverSetup, Observation, Privilege
from vpf_sim.timing import call
from vpf_sim.types import Perception, Plan, Reference

VARIANT = "scene"  # of the perception


class SceneDriver(Driver):
    """Drives by camera: `vpf`'s perception fills the scene in which `expert` plans."""

    privileged: Privilege = "none"

    def reset(self, setup: DriverSetup) -> None:
        from vpf_sim.drivers.motion_follower import MotionFollower
        from vpf_sim.drivers.perceiver import OwnMotion, Perceiver
        from vpf_sim.planning import variant as variants
        from vpf_sim.planning.visibility import SpeedInSight
        from vpf_sim.scene.camera import CameraScene

        self._setup, self._variant = setup, variants.load(VARIANT)
        self._perceiver = Perceiver(setup, self._variant)
        self._own_motion = OwnMotion(setup, self._variant)
        assert self._variant.scene is not None
        assert self._variant.visibility is not None
        self._in_sight = SpeedInSight(self._variant.visibility, setup)
        self._scene = CameraScene(setup.camera, self._variant.scene, self._variant.road_edges.object_sizes)
        self._follower = MotionFollower(setup)

    def act(self, observation: Observation) -> Command:
        observation = self._own_motion.update(observation)
        perception = self._perceived(observation)
        if self._follower.is_due(observation.time_s):
            call("plan", self._replan, perception, observation)
        return call("control", self._follow, perception, observation)

    def perceive(self, observation: Observation) -> Perception:
        """What `act` would perceive, without planning or steering; one of the two is called each step."""
        return self._perceived(self._own_motion.update(observation))

    def _perceived(self, observation: Observation) -> Perception:
        """The perception with the tracks of the scene as its obstacles."""
        from vpf_sim.scene.camera import Evidence

        perception = self._perceiver.perceive(observation)
        if self._perceiver.has_processed:
            frame = self._perceiver.frame
            evidence = Evidence(frame.crossers, frame.points, frame.motions, frame.relief)
            call("tracking", self._scene.observe, perception, observation, evidence)
        return replace(perception, obstacles=self._scene.obstacles(observation))

    def _replan(self, perception: Perception, observation: Observation) -> None:
        speed_mps = self._speed_reference(perception, observation)
        self._follower.replan(self._scene.scene(observation, speed_mps))

    def _speed_reference(self, perception: Perception, observation: Observation) -> float:
        """m/s, the reference speed, less where too little is seen."""
        from vpf_sim.drivers.motion_follower import REPLAN_S

        in_sight = self._in_sight.limit(perception, observation.speed_mps * REPLAN_S)
        allowed = min(self._setup.speed_reference_mps, in_sight)
        return self._perceiver.stop_when_blind(Reference(observation.yaw_rad, allowed), observation).speed_mps

    def _follow(self, perception: Perception, observation: Observation) -> Command:
        assert self._scene.road is not None
        return self._follower.command(self._scene.road, observation, self._scene.place(observation), perception)

    @property
    def needs_next_frame(self) -> bool:
        """Whether it processes the next frame."""
        return self._perceiver.needs_next_frame

    def trace(self) -> Plan | None:
        """The plan of the last step, for overlays and scores."""
        return self._follower.plan
