"""What a driver saw, against the truth: its flow and times to contact from time to time, its objects at every frame."""

from math import nan
from typing import Any

import numpy as np

from vpf_sim.evaluation.truth.detections import DetectionScorer
from vpf_sim.evaluation.truth.true_motion import Shot, TrueMotion, ttc_errors
from vpf_sim.types import Flow, Observation, Plan

JUDGED_EVERY_S = 2.0  # the truth of a frame takes as long as some steps
LONGEST_S = 0.1  # of the flow's windows that are judged
NAMES = ("depth", "instance")


class PerceptionErrors:
    """Is shown every frame of an episode in its order, and what the driver made of it."""

    def __init__(self) -> None:
        self._motion: TrueMotion | None = None
        self._frames = 0
        self._due = False
        self._flow: Flow | None = None  # of the last frame: a driver that does not look at one has that of another
        self._objects = DetectionScorer()

    def observe(self, observation: Observation, env: Any) -> None:
        """Remember where everything is in a frame, if one of the next is judged that reaches back to it."""
        self._env, self._frames = env, self._frames + 1
        renderer, longest = getattr(env, "renderer", None), round(LONGEST_S * env.rate_hz)
        self._due |= self._frames % self._every == 0
        if renderer is None or not (self._due or -self._frames % self._every <= longest):
            return
        if self._motion is None:
            self._motion = TrueMotion(env.camera, longest)
        pose = np.array([observation.x_m, observation.y_m, observation.yaw_rad])
        self._motion.note(Shot(self._frames, observation.image, pose, renderer))

    def columns(self, plan: Plan) -> dict[str, float]:
        """The columns of the step table that say how right the driver was about that frame.

        Flow and times to contact are judged in the next frame that is due and that the driver looked at.
        """
        env, seen = self._env, plan.perception
        found = self._objects.columns(seen.obstacles, env.ego, env.road.network)
        looked, self._flow = seen.flow is not self._flow, seen.flow
        if self._motion is None or not self._due or not looked:
            return found
        self._due = False
        return found | self._judged(seen.flow, seen.ttc_s, self._motion)

    @property
    def _every(self) -> int:
        """Frames from one that is judged to the next."""
        return round(JUDGED_EVERY_S * float(self._env.rate_hz))

    def _judged(self, flow: Flow, ttc_s: Any, motion: TrueMotion) -> dict[str, float]:
        """Medians over the points of the frame; nan where it has none."""
        truth = self._env.renderer.truth(NAMES)
        frames = np.rint(flow.gap_s * self._env.rate_hz).astype(np.int64)
        whole = (frames >= 1) & (frames <= round(LONGEST_S * self._env.rate_hz))
        missed = motion.errors_px(flow.points_px[whole], flow.displacement_px[whole], frames[whole], truth)
        true_s = motion.ttc_s(flow.points_px, 1.0 / self._env.rate_hz, truth)
        errors = ttc_errors(ttc_s, true_s)
        return {
            "flow_error_px": float(np.median(missed)) if len(missed) else nan,
            "ttc_error": float(np.median(errors)) if len(errors) else nan,
        }
