"""Perception errors for the step log: detections at every frame, flow and time to contact at some."""

from math import nan

import numpy as np

from vpf_sim.driver_interface import Observation
from vpf_sim.evaluation.environment import FilmedSurroundings
from vpf_sim.evaluation.truth.detections import DetectionScorer
from vpf_sim.evaluation.truth.true_motion import Shot, TrueMotion, Truth, ttc_errors
from vpf_sim.types import Floats, Flow, Perception

SCORED_EVERY_S = 2.0  # rendering a frame's ground truth takes as long as several steps
LONGEST_S = 0.1  # of the flow windows that are scored
NAMES = ("depth", "instance")


class PerceptionErrors:
    """Scores a driver's perception; receives every frame of an episode in order."""

    def __init__(self) -> None:
        self._motion: TrueMotion | None = None
        self._frames = 0
        self._due = False
        self._flow: Flow | None = None  # of the last frame: unchanged if the driver did not use the frame
        self._detections = DetectionScorer()

    def observe(self, observation: Observation, env: FilmedSurroundings) -> None:
        """Record a frame's poses if a later scored frame has a flow window that reaches back to it."""
        self._env, self._frames = env, self._frames + 1
        renderer, longest = env.renderer, round(LONGEST_S * env.rate_hz)
        self._due |= self._frames % self._every == 0
        if renderer is None or not (self._due or -self._frames % self._every <= longest):
            return
        if self._motion is None:
            self._motion = TrueMotion(env.camera, longest)
        pose = observation.pose
        self._motion.add(Shot(self._frames, observation.image, pose, renderer))

    def columns(self, perception: Perception) -> dict[str, float]:
        """Step-table columns with the errors of that frame.

        Flow and times to contact are scored in the next frame that is due and that the driver used.
        """
        env = self._env
        columns = self._detections.columns(perception.obstacles, env)
        used, self._flow = perception.flow is not self._flow, perception.flow
        if env.renderer is None or self._motion is None or not self._due or not used:
            return columns
        self._due = False
        truth = env.renderer.truth(NAMES)
        return columns | self._flow_errors(perception.flow, perception.features.ttc_s, self._motion, truth)

    @property
    def _every(self) -> int:
        """Frames between two scored ones."""
        return round(SCORED_EVERY_S * float(self._env.rate_hz))

    def _flow_errors(self, flow: Flow, ttc_s: Floats, motion: TrueMotion, truth: Truth) -> dict[str, float]:
        """Median errors over the frame's points; nan without points."""
        frames = np.rint(flow.gap_s * self._env.rate_hz).astype(np.int64)
        whole = (frames >= 1) & (frames <= round(LONGEST_S * self._env.rate_hz))
        errors_px = motion.errors_px(flow.points_px[whole], flow.displacement_px[whole], frames[whole], truth)
        true_s = motion.ttc_s(flow.points_px, 1.0 / self._env.rate_hz, truth)
        errors = ttc_errors(ttc_s, true_s)
        return {
            "flow_error_px": float(np.median(errors_px)) if len(errors_px) else nan,
            "ttc_error": float(np.median(errors)) if len(errors) else nan,
        }
