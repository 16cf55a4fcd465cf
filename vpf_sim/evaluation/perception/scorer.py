"""Scores one driver's perception on one drive, frame by frame and detection by detection."""

from dataclasses import dataclass, field
from math import nan
from typing import NamedTuple

import numpy as np

from vpf_sim.envs.network import OnRoad
from vpf_sim.evaluation.environment import Info, Surroundings
from vpf_sim.evaluation.episode.log import NO_FOE_PX, perceived
from vpf_sim.evaluation.metrics.perception import KINDS
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.evaluation.truth import detections, surroundings
from vpf_sim.evaluation.truth.detections import Detection, DetectionScorer
from vpf_sim.types import Floats, Perception

ESTIMATED = ("foe_x_px", "foe_y_px", "seen_left_m", "seen_right_m")
TRUE = ("true_foe_x_px", "true_foe_y_px", "true_left_m", "true_right_m")
COUNTED = ("objects_right", "objects_wrong", "new_wrong_objects", "met_kind", "met_confirmed_m")
OBJECTS = (*COUNTED, "wrong_ahead_m", "near_confirmed_m", "near_sticks_out_m")
SCORED_COLUMNS = (*ESTIMATED, *TRUE, *OBJECTS)  # step-table columns that perception determines


class DetectionRow(NamedTuple):
    """A detection in the corridor at one frame; the errors of a false positive are nan."""

    ahead_m: float  # along the road from the front bumper to its foot
    is_right: float
    is_new: float  # a false positive that was not false before
    kind: float  # index in KINDS of the matching object
    distance_m: float
    left_m: float
    right_m: float
    speed_mps: float
    overlap: float  # across, of detection and object: what they share, of what either covers
    existence: float  # probability that the driver states; nan where it states none


@dataclass(frozen=True, slots=True)
class DriveEvaluation:
    """One driver's perception on one drive, scored."""

    drive: str  # the id of the episode
    scenario: str
    weather: str
    seed: int
    driver: str  # whose perception is scored
    states_sha256: str  # of the episode: equal hashes mean equal poses
    table: StepTable  # the episode's, with new SCORED_COLUMNS
    lane_error_m: Floats  # (n + 1,) of the ego lane's centre 10 m ahead; nan without an estimate
    detections: Floats  # (D, len(DetectionRow._fields))
    remarks: tuple[str, ...] = ()

    def of(self, name: str) -> Floats:
        """(D,) a column of the detections."""
        column: Floats = self.detections[:, DetectionRow._fields.index(name)]
        return column

    @property
    def minutes(self) -> float:
        """Duration of the drive, min."""
        return float(self.table.time_s[-1] - self.table.time_s[0]) / 60.0


@dataclass(slots=True)
class PerceptionScorer:
    """Collects the scores of one driver's perception; receives every frame of a drive in order."""

    rows: int  # of the step table
    detections: list[DetectionRow] = field(default_factory=list)
    columns: dict[str, Floats] = field(init=False)
    lane_error_m: Floats = field(init=False)
    _detection_scorer: DetectionScorer = field(default_factory=DetectionScorer)

    def __post_init__(self) -> None:
        self.columns = {name: np.full(self.rows, nan) for name in SCORED_COLUMNS}
        self.lane_error_m = np.full(self.rows, nan)

    def add(self, row: int, perception: Perception, world: Surroundings, info: Info) -> None:
        """Score a perception against the environment at that frame; `info` has the true `foe`."""
        ego, network = world.ego, world.road.network
        truth = (*info.get("foe", NO_FOE_PX), *surroundings.true_edges(ego, network))
        objects = self._detection_scorer.columns(perception.obstacles, world)
        for name, value in (dict(zip(TRUE, truth, strict=True)) | perceived(perception) | objects).items():
            self.columns[name][row] = value
        if perception.road.lane_confidence > 0.0:
            lane_m = surroundings.true_lane(ego, network, ego.place[1] - info["lane_offset_m"])
            self.lane_error_m[row] = surroundings.perceived_lane(perception.road) - lane_m
        self.detections += [
            DetectionRow(detection.ahead_m, *self._truth(detection, perception, ego))
            for detection in self._detection_scorer.detections
            if detection.in_corridor
        ]

    def _truth(self, detection: Detection, perception: Perception, ego: OnRoad) -> tuple[float, ...]:
        stated = float(perception.obstacles.existence[detection.index])
        if not detection.owners:
            return 0.0, float(detection.is_new), nan, nan, nan, nan, nan, nan, stated
        errors = detections.errors(detection, self._detection_scorer.detections, perception.obstacles, ego)
        return 1.0, 0.0, float(KINDS.index(detection.owners[0].kind)), *errors, stated

    def detections_table(self) -> Floats:
        """(D, len(DetectionRow._fields)) all detections so far."""
        return np.array(self.detections, float).reshape(-1, len(DetectionRow._fields))
