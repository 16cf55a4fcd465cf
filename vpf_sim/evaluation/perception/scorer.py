"""What a driver perceived on one drive, beside the truth: frame by frame, and report by report."""

from dataclasses import dataclass, field
from math import nan
from typing import Any, NamedTuple

import numpy as np

from vpf_sim.evaluation.episode.log import NOWHERE_PX, perceived
from vpf_sim.evaluation.metrics.perception import KINDS
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.evaluation.truth import extents, surroundings
from vpf_sim.evaluation.truth.detections import Detection, DetectionScorer
from vpf_sim.types import Floats, Perception

SEEN = ("foe_x_px", "foe_y_px", "seen_left_m", "seen_right_m")
TRUE = ("true_foe_x_px", "true_foe_y_px", "true_left_m", "true_right_m")
OBJECTS = ("objects_right", "objects_wrong", "new_wrong_objects", "met_kind", "met_confirmed_m")
SCORED_COLUMNS = (*SEEN, *TRUE, *OBJECTS)  # the columns of the step table that a perception makes


class DetectionRow(NamedTuple):
    """A report in the corridor at one frame; what a wrong one is off by is nan."""

    ahead_m: float  # along the road from the front bumper to its foot
    is_right: float
    is_new: float  # wrong, and not wrong before
    kind: float  # the place in KINDS of the body that it is about
    distance_m: float
    left_m: float
    right_m: float
    speed_mps: float


@dataclass(frozen=True, slots=True)
class DriveEvaluation:
    """One drive as one driver perceives it."""

    drive: str  # the id of the episode
    scenario: str
    weather: str
    seed: int
    driver: str  # that perceived
    states_sha256: str  # of the episode: two judgements with the same are of the same poses
    table: StepTable  # the episode's, with the columns SCORED_COLUMNS made again
    lane_error_m: Floats  # (n + 1,) of the own lane's middle 10 m ahead; nan where none is told
    detections: Floats  # (R, len(ReportRow._fields))
    remarks: tuple[str, ...] = ()

    def of(self, name: str) -> Floats:
        """(R,) a column of the reports."""
        column: Floats = self.detections[:, DetectionRow._fields.index(name)]
        return column

    @property
    def minutes(self) -> float:
        """Of driving."""
        return float(self.table.time_s[-1] - self.table.time_s[0]) / 60.0


@dataclass(slots=True)
class PerceptionScorer:
    """Is shown what one driver perceives at every frame of a drive, in their order."""

    rows: int  # of the step table
    detections: list[DetectionRow] = field(default_factory=list)
    columns: dict[str, Floats] = field(init=False)
    lane_error_m: Floats = field(init=False)
    _book: DetectionScorer = field(default_factory=DetectionScorer)

    def __post_init__(self) -> None:
        self.columns = {name: np.full(self.rows, nan) for name in SCORED_COLUMNS}
        self.lane_error_m = np.full(self.rows, nan)

    def judge(self, row: int, seen: Perception, world: Any, info: dict[str, Any]) -> None:
        """Compare with the world as it is at that frame; `info` is the environment's, with the true `foe`."""
        ego, network = world.ego, world.road.network
        truth = (*info.get("foe", NOWHERE_PX), *surroundings.true_edges(ego, network))
        found = self._book.columns(seen.obstacles, ego, network)
        for name, value in (dict(zip(TRUE, truth, strict=True)) | perceived(seen) | found).items():
            self.columns[name][row] = value
        if seen.road.lane_confidence > 0.0:
            lane_m = surroundings.true_lane(ego, network, ego.place[1] - info["lane_offset_m"])
            self.lane_error_m[row] = surroundings.seen_lane(seen.road) - lane_m
        self.detections += [
            DetectionRow(detection.ahead_m, *self._truth(detection, seen, ego))
            for detection in self._book.detections
            if detection.in_corridor
        ]

    def _truth(self, detection: Detection, seen: Perception, ego: Any) -> tuple[float, ...]:
        if not detection.owners:
            return 0.0, float(detection.is_new), nan, nan, nan, nan, nan
        off = extents.errors(detection, self._book.detections, seen.obstacles, ego)
        return 1.0, 0.0, float(KINDS.index(detection.owners[0].kind)), *off

    def detections_table(self) -> Floats:
        """(R, len(ReportRow._fields))"""
        return np.array(self.detections, float).reshape(-1, len(DetectionRow._fields))
