"""Scores feature tracking and the paper's perception against ground truth, on the frames of one drive.

Two trackers run on the drive. The paper's keeps and replenishes its corners over 0.1 s, with the paper's focus of
expansion, time to contact and obstacle map. A plain one detects new corners and follows them for 0.1 s with a
forward-backward check.
"""

from collections import deque
from dataclasses import dataclass, field

import cv2
import numpy as np

from vpf_sim.evaluation.rendering import frame_statistics
from vpf_sim.evaluation.truth.true_motion import OFF_PX, Shot, TrueMotion, Truth, at, ttc_errors
from vpf_sim.perception.egomotion import focus_of_expansion as expansion
from vpf_sim.perception.egomotion.flow import FlowTracker, grey
from vpf_sim.perception.paper import obstacle_map as obstacles
from vpf_sim.perception.paper import time_to_contact as contact
from vpf_sim.planning import variant
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Camera, Expansion, Floats, Flow, Image, ObstacleMap

PLAIN_VARIANT = "full-frame"
WINDOW_FRAMES = frame_statistics.FRAMES_ON  # 0.1 s at 60 Hz
NEAR_PX = 16  # a marked point this near to an object belongs to it
RIM_PX = 4  # a corner this near to a hidden region lies on its rim
NAMES = ("depth", "instance", "hidden", "foe", "ttc")


@dataclass(frozen=True, slots=True)
class Score:
    """Shares and medians over all scored frames; nan without samples."""

    survive_1: float  # share of the plain tracker's corners that survive one frame
    survive_6: float  # and after 0.1 s
    off: float  # share of the survivors with a flow error above OFF_PX
    off_seen: float  # the same farther than RIM_PX from hidden regions
    changed: float  # share that deviates from its flow without the factor
    paper_off: float  # of the paper's tracker
    paper_off_seen: float
    foe_px: float  # median distance of the paper's focus of expansion from the true one
    robust_foe_px: float  # of the robust estimate on the same flow
    ttc_error: float  # median of |TTC - true| / true of the paper's
    false_obstacles: float  # false clusters of the paper's obstacle map a frame
    robust_false: float  # of the robust obstacle map on the same flow
    hidden: float  # share of the frame that the weather hides or fakes


@dataclass(slots=True)
class Samples:
    """The samples of all scored frames."""

    survived: list[tuple[float, float]] = field(default_factory=list)
    errors_px: list[Floats] = field(default_factory=list)
    in_sight: list[Bools] = field(default_factory=list)  # whether each is visible in this weather
    changes_px: list[Floats] = field(default_factory=list)  # deviation from the same corners without the factor
    paper_errors_px: list[Floats] = field(default_factory=list)
    paper_in_sight: list[Bools] = field(default_factory=list)
    foe_px: list[float] = field(default_factory=list)
    robust_foe_px: list[float] = field(default_factory=list)
    ttc_errors: list[Floats] = field(default_factory=list)
    false_obstacles: list[int] = field(default_factory=list)
    robust_false: list[int] = field(default_factory=list)
    hidden: list[float] = field(default_factory=list)


class TrackingScorer:
    """Receives every frame of a drive in order, and scores the chosen ones."""

    def __init__(self, camera: Camera, rate_hz: float, seed: int) -> None:
        self._camera = camera
        self._rate_hz = rate_hz
        self._plain = variant.load(PLAIN_VARIANT)
        self._tracker = FlowTracker(camera, self._plain.flow, rate_hz)
        self._motion = TrueMotion(camera, WINDOW_FRAMES)
        self._greys: deque[Image] = deque(maxlen=WINDOW_FRAMES + 1)  # oldest first
        self._without: deque[Image] = deque(maxlen=WINDOW_FRAMES + 1)
        self._random = stream(seed, "focus of expansion")
        self._samples = Samples()

    def add_frame(self, shot: Shot, without: Image, score: bool) -> None:
        """Track into this frame, and compare it with ground truth if `score`.

        `without` is the grey frame at the same pose without the weather factor.
        """
        self._motion.add(shot)
        self._greys.append(grey(shot.image))
        self._without.append(without)
        flow = self._tracker.update(self._greys[-1], shot.pose)
        if not score or len(self._greys) <= WINDOW_FRAMES:
            return
        truth = shot.renderer.truth(NAMES)
        sight = in_sight(truth["hidden"].astype(np.bool_))
        self._score_corners(truth, sight)
        self._score_flow(flow, truth, sight)
        self._score_stages(flow, truth)
        self._samples.hidden.append(float(truth["hidden"].mean()))

    def score(self) -> Score:
        """The score over all samples."""
        samples = self._samples
        survived = np.array(samples.survived).reshape(-1, 2)
        return Score(
            survive_1=_mean(survived[:, 0]),
            survive_6=_mean(survived[:, 1]),
            off=share_off(samples.errors_px),
            off_seen=share_off(samples.errors_px, samples.in_sight),
            changed=share_off(samples.changes_px),
            paper_off=share_off(samples.paper_errors_px),
            paper_off_seen=share_off(samples.paper_errors_px, samples.paper_in_sight),
            foe_px=_median(samples.foe_px),
            robust_foe_px=_median(samples.robust_foe_px),
            ttc_error=_median(np.concatenate([*samples.ttc_errors, np.empty(0)])),
            false_obstacles=_mean(samples.false_obstacles),
            robust_false=_mean(samples.robust_false),
            hidden=_mean(samples.hidden),
        )

    def _score_corners(self, truth: Truth, sight: Bools) -> None:
        """The plain tracker, from the corners of the window's first frame to the last."""
        start_px = frame_statistics.corners(self._greys[0])
        now_px, alive = frame_statistics.follow(list(self._greys), start_px)
        if len(start_px):
            self._samples.survived.append((float(alive[0].mean()), float(alive[-1].mean())))
        without_px, alive_without = frame_statistics.follow(list(self._without), start_px)
        both = alive[-1] & alive_without[-1]
        self._samples.changes_px.append(np.hypot(*(now_px[both] - without_px[both]).T))
        start_px, now_px = start_px[alive[-1]], now_px[alive[-1]]
        frames = np.full(len(now_px), WINDOW_FRAMES)
        self._samples.errors_px.append(self._motion.errors_px(now_px, now_px - start_px, frames, truth))
        self._samples.in_sight.append(at(sight, now_px, self._camera))

    def _score_flow(self, flow: Flow, truth: Truth, sight: Bools) -> None:
        """The paper's tracker: points that were tracked for a whole window."""
        frames = np.rint(flow.gap_s * self._rate_hz).astype(np.int64)
        old = frames == WINDOW_FRAMES
        points_px = flow.points_px[old]
        errors = self._motion.errors_px(points_px, flow.displacement_px[old], frames[old], truth)
        self._samples.paper_errors_px.append(errors)
        self._samples.paper_in_sight.append(at(sight, points_px, self._camera))

    def _score_stages(self, flow: Flow, truth: Truth) -> None:
        """The paper's stages on that flow, and the robust ones."""
        camera, plain = self._camera, self._plain
        foe = expansion.estimate(flow, camera, plain.focus_of_expansion, self._random)
        robust = expansion.estimate(flow, camera, variant.load("robust").focus_of_expansion, self._random)
        true_foe = truth["foe"].astype(np.float64)
        self._samples.foe_px.extend(foe_error_px(foe, true_foe))
        self._samples.robust_foe_px.extend(foe_error_px(robust, true_foe))
        ttc = contact.time_to_contact(flow, foe, camera, plain.time_to_contact)
        self._samples.ttc_errors.append(ttc_errors(ttc, at(truth["ttc"], flow.points_px, camera)))
        objects = truth["instance"] != 0
        for config, found in (
            (plain.obstacle_map, self._samples.false_obstacles),
            (variant.load("robust").obstacle_map, self._samples.robust_false),
        ):
            found.append(false_clusters(obstacles.detect(flow, camera, config), flow, objects))


def in_sight(hidden: Bools) -> Bools:
    """(H, W) pixels farther than RIM_PX from hidden ones (H, W)."""
    width = 2 * RIM_PX + 1
    return np.asarray(cv2.dilate(hidden.astype(np.uint8), np.ones((width, width), np.uint8)) == 0, np.bool_)


def share_off(errors_px: list[Floats], chosen: list[Bools] | None = None) -> float:
    """Share of the errors, or of the chosen ones, above OFF_PX; nan without any."""
    errors = np.concatenate([*errors_px, np.empty(0)])
    if chosen is not None:
        errors = errors[np.concatenate([*chosen, np.empty(0, np.bool_)])]
    return _mean(errors > OFF_PX)


def foe_error_px(estimate: Expansion, true_px: Floats) -> list[float]:
    """[distance, px], empty where either is unknown."""
    known = estimate.confidence > 0.0 and bool(np.all(np.isfinite(true_px)))
    return [float(np.hypot(estimate.x_px - true_px[0], estimate.y_px - true_px[1]))] if known else []


def false_clusters(obstacle_map: ObstacleMap, flow: Flow, objects: Bools) -> int:
    """Number of clusters without a point within NEAR_PX of an object, by an (H, W) mask of objects."""
    label = obstacles.cluster_labels(obstacle_map, flow)
    reach = cv2.dilate(objects.astype(np.uint8), np.ones((2 * NEAR_PX + 1, 2 * NEAR_PX + 1), np.uint8))
    height, width = objects.shape
    column, row = np.clip(np.rint(flow.points_px), 0, [width - 1, height - 1]).astype(np.intp).T
    marked = label >= 0
    true = np.unique(label[marked & (reach[row, column] > 0)])
    return len(np.setdiff1d(label[marked], true))


def _mean(values: Floats | Bools | list[float] | list[int]) -> float:
    return float(np.mean(values)) if len(values) else np.nan


def _median(values: Floats | list[float]) -> float:
    return float(np.median(values)) if len(values) else np.nan
