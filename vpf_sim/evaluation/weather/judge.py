"""The plain perception against the truth of the renderer, frame by frame of one drive.

Two trackers look at the drive: the paper's, whose corners are topped up and chained over 0.1 s, with the paper's focus
of expansion, time to contact and obstacle map on its flow; and a plain one that takes new corners and follows them for
as long, checked by tracking back.
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
NEAR_PX = 16  # a mark so near to something that stands up means it
RIM_PX = 4  # a corner so near to what the weather hides sits on its rim
NAMES = ("depth", "instance", "hidden", "foe", "ttc")


@dataclass(frozen=True, slots=True)
class Score:
    """Shares and medians over all that was judged; nan where there was nothing to judge."""

    survive_1: float  # share of the plain tracker's corners that it still follows after one frame
    survive_6: float  # and after 0.1 s
    off: float  # share of those that are off the true flow by more than OFF_PX
    off_seen: float  # the same among those farther than RIM_PX from what the weather hides
    changed: float  # share of them off their flow without the factor, among those followed in both
    paper_off: float  # of the paper's tracker
    paper_off_seen: float
    foe_px: float  # median distance of the paper's focus of expansion from the true one
    robust_foe_px: float  # of the robust estimate on the same flow
    ttc_error: float  # median of |TTC - true| / true of the paper's
    false_bodies: float  # clusters of the paper's obstacle map with nothing there, a frame
    robust_false: float  # of the robust obstacle map on the same flow
    hidden: float  # share of the frame that the weather hides or fakes


@dataclass(slots=True)
class Judged:
    """What was found in each judged frame."""

    survived: list[tuple[float, float]] = field(default_factory=list)
    errors_px: list[Floats] = field(default_factory=list)
    in_sight: list[Bools] = field(default_factory=list)  # whether the weather leaves each of them visible
    changes_px: list[Floats] = field(default_factory=list)  # from where the same corners go without the factor
    paper_errors_px: list[Floats] = field(default_factory=list)
    paper_in_sight: list[Bools] = field(default_factory=list)
    foe_px: list[float] = field(default_factory=list)
    robust_foe_px: list[float] = field(default_factory=list)
    ttc_errors: list[Floats] = field(default_factory=list)
    false_bodies: list[int] = field(default_factory=list)
    robust_false: list[int] = field(default_factory=list)
    hidden: list[float] = field(default_factory=list)


class Judge:
    """Is shown every frame of a drive in its order, and scores those it is told to."""

    def __init__(self, camera: Camera, rate_hz: float, seed: int) -> None:
        self._camera = camera
        self._rate_hz = rate_hz
        self._plain = variant.load(PLAIN_VARIANT)
        self._tracker = FlowTracker(camera, self._plain.flow, rate_hz)
        self._motion = TrueMotion(camera, WINDOW_FRAMES)
        self._greys: deque[Image] = deque(maxlen=WINDOW_FRAMES + 1)  # oldest first
        self._without: deque[Image] = deque(maxlen=WINDOW_FRAMES + 1)
        self._random = stream(seed, "focus of expansion")
        self._judged = Judged()

    def see(self, shot: Shot, without: Image, judged: bool) -> None:
        """Follow the corners into this frame; `judged`: and compare with its truth.

        `without` is the grey frame of that place in the weather to compare with.
        """
        self._motion.note(shot)
        self._greys.append(grey(shot.image))
        self._without.append(without)
        flow = self._tracker.update(self._greys[-1], shot.pose)
        if not judged or len(self._greys) <= WINDOW_FRAMES:
            return
        truth = shot.renderer.truth(NAMES)
        sight = in_sight(truth["hidden"].astype(np.bool_))
        self._judge_corners(truth, sight)
        self._judge_flow(flow, truth, sight)
        self._judge_stages(flow, truth)
        self._judged.hidden.append(float(truth["hidden"].mean()))

    def score(self) -> Score:
        """What all judged frames together say."""
        judged = self._judged
        survived = np.array(judged.survived).reshape(-1, 2)
        return Score(
            survive_1=_mean(survived[:, 0]),
            survive_6=_mean(survived[:, 1]),
            off=share_off(judged.errors_px),
            off_seen=share_off(judged.errors_px, judged.in_sight),
            changed=share_off(judged.changes_px),
            paper_off=share_off(judged.paper_errors_px),
            paper_off_seen=share_off(judged.paper_errors_px, judged.paper_in_sight),
            foe_px=_median(judged.foe_px),
            robust_foe_px=_median(judged.robust_foe_px),
            ttc_error=_median(np.concatenate([*judged.ttc_errors, np.empty(0)])),
            false_bodies=_mean(judged.false_bodies),
            robust_false=_mean(judged.robust_false),
            hidden=_mean(judged.hidden),
        )

    def _judge_corners(self, truth: Truth, sight: Bools) -> None:
        """The plain tracker, from the corners of the window's first frame to now."""
        start_px = frame_statistics.corners(self._greys[0])
        now_px, alive = frame_statistics.follow(list(self._greys), start_px)
        if len(start_px):
            self._judged.survived.append((float(alive[0].mean()), float(alive[-1].mean())))
        without_px, too = frame_statistics.follow(list(self._without), start_px)
        both = alive[-1] & too[-1]
        self._judged.changes_px.append(np.hypot(*(now_px[both] - without_px[both]).T))
        start_px, now_px = start_px[alive[-1]], now_px[alive[-1]]
        frames = np.full(len(now_px), WINDOW_FRAMES)
        self._judged.errors_px.append(self._motion.errors_px(now_px, now_px - start_px, frames, truth))
        self._judged.in_sight.append(at(sight, now_px, self._camera))

    def _judge_flow(self, flow: Flow, truth: Truth, sight: Bools) -> None:
        """The paper's tracker: the points that were followed for a whole window."""
        frames = np.rint(flow.gap_s * self._rate_hz).astype(np.int64)
        old = frames == WINDOW_FRAMES
        points_px = flow.points_px[old]
        errors = self._motion.errors_px(points_px, flow.displacement_px[old], frames[old], truth)
        self._judged.paper_errors_px.append(errors)
        self._judged.paper_in_sight.append(at(sight, points_px, self._camera))

    def _judge_stages(self, flow: Flow, truth: Truth) -> None:
        """What the paper's stages make of that flow, and the robust ones."""
        camera, plain = self._camera, self._plain
        foe = expansion.estimate(flow, camera, plain.focus_of_expansion, self._random)
        robust = expansion.estimate(flow, camera, variant.load("robust").focus_of_expansion, self._random)
        true_foe = truth["foe"].astype(np.float64)
        self._judged.foe_px.extend(foe_error_px(foe, true_foe))
        self._judged.robust_foe_px.extend(foe_error_px(robust, true_foe))
        ttc = contact.time_to_contact(flow, foe, camera, plain.time_to_contact)
        self._judged.ttc_errors.append(ttc_errors(ttc, at(truth["ttc"], flow.points_px, camera)))
        stands = truth["instance"] != 0
        for config, found in (
            (plain.obstacle_map, self._judged.false_bodies),
            (variant.load("robust").obstacle_map, self._judged.robust_false),
        ):
            found.append(false_clusters(obstacles.detect(flow, camera, config), flow, stands))


def in_sight(hidden: Bools) -> Bools:
    """(H, W) what the weather leaves to be seen, RIM_PX off what it hides (H, W)."""
    width = 2 * RIM_PX + 1
    return np.asarray(cv2.dilate(hidden.astype(np.uint8), np.ones((width, width), np.uint8)) == 0, np.bool_)


def share_off(errors_px: list[Floats], chosen: list[Bools] | None = None) -> float:
    """How many of all errors, or of the chosen ones, are above OFF_PX; nan without any."""
    errors = np.concatenate([*errors_px, np.empty(0)])
    if chosen is not None:
        errors = errors[np.concatenate([*chosen, np.empty(0, np.bool_)])]
    return _mean(errors > OFF_PX)


def foe_error_px(seen: Expansion, true_px: Floats) -> list[float]:
    """The distance between the two, or nothing where either is unknown."""
    known = seen.confidence > 0.0 and bool(np.all(np.isfinite(true_px)))
    return [float(np.hypot(seen.x_px - true_px[0], seen.y_px - true_px[1]))] if known else []


def false_clusters(obstacle_map: ObstacleMap, flow: Flow, stands: Bools) -> int:
    """Clusters of marked points none of which is within NEAR_PX of something that stands up, an (H, W) mask."""
    label = obstacles.cluster_labels(obstacle_map, flow)
    reach = cv2.dilate(stands.astype(np.uint8), np.ones((2 * NEAR_PX + 1, 2 * NEAR_PX + 1), np.uint8))
    height, width = stands.shape
    column, row = np.clip(np.rint(flow.points_px), 0, [width - 1, height - 1]).astype(np.intp).T
    marked = label >= 0
    true = np.unique(label[marked & (reach[row, column] > 0)])
    return len(np.setdiff1d(label[marked], true))


def _mean(values: Floats | Bools | list[float] | list[int]) -> float:
    return float(np.mean(values)) if len(values) else np.nan


def _median(values: Floats | list[float]) -> float:
    return float(np.median(values)) if len(values) else np.nan
