"""Settings of the road edge tracker and of occlusion."""

import dataclasses

import numpy as np

from vpf_sim.configuration import setting, settings
from vpf_sim.perception.object_sizes import ObjectSizes
from vpf_sim.perception.road.birds_eye import Patch
from vpf_sim.types import Floats


@settings
class OcclusionConfig:
    """Footprints of obstacles on the road."""

    before_m: float = setting("margin before the face", default=0.8, gt=0.0)
    beside_m: float = setting("margin at both sides", default=0.35, gt=0.0)
    sizes: ObjectSizes = dataclasses.field(default_factory=ObjectSizes)


@settings
class CombConfig:
    """Search for a road from scratch."""

    reach_m: float = setting("farthest row of the search", gt=0.0)
    heading_limit_deg: float = setting("largest heading to both sides", gt=0.0)
    heading_step_deg: float = setting("between two headings", gt=0.0)
    curvature_limit_per_m: float = setting("largest curvature to both sides", gt=0.0)
    curvature_step_per_m: float = setting("between two curvatures", gt=0.0)
    unlikely_per_rad: float = setting("lines that a heading off the likely one must explain more", ge=0.0)
    unlikely_m: float = setting("lines times m that a curvature must explain more", ge=0.0)

    @property
    def headings_rad(self) -> Floats:
        limit, step = self.heading_limit_deg, self.heading_step_deg
        return np.asarray(np.radians(np.arange(-limit, limit + 0.1 * step, step)))

    @property
    def curvatures_per_m(self) -> Floats:
        limit, step = self.curvature_limit_per_m, self.curvature_step_per_m
        return np.arange(-limit, limit + 0.1 * step, step)


@settings
class NeighbourTestConfig:
    apart_m: float = setting("largest difference to the offset in a neighbouring row", gt=0.0)


@settings
class ChanceTestConfig:
    sigmas: float = setting("by which the observations on lines must exceed their number by chance", ge=0.0)


@settings
class NearPartConfig:
    within_m: float = setting("of the pose, the near part", gt=0.0)
    least_rows: int = setting("observations that make a line in the far part", ge=1)


@settings
class RoadFilterConfig:
    """Kalman filter of the road's state."""

    drift_m: float = setting("Process noise of the lateral place in a metre travelled.", gt=0.0)
    drift_rad: float = setting("Process noise of the heading in a metre travelled.", gt=0.0)
    drift_curvature_per_m: tuple[float, float, float, float] = setting("of the curvature at each node")
    drift_width_m: float = setting("Process noise of the lane width in a metre travelled.", gt=0.0)
    drift_pitch_rad: float = setting("Process noise of the camera's pitch in a metre travelled.", gt=0.0)
    shared_curvature_per_m: float = setting("initial standard deviation of the curvature of all nodes", gt=0.0)
    added_curvature_per_m: float = setting(
        "Standard deviation of each node's difference in curvature to the one before.", gt=0.0
    )
    tightest_per_m: float = setting("largest curvature", gt=0.0)
    turned_rad: float = setting("largest heading at which lines are tracked", gt=0.0)
    steepest_rad: float = setting("largest pitch", gt=0.0)
    passes_m: tuple[float, ...] = setting("cut of Tukey's biweight in each pass", min_length=1)
    reach_m: float = setting("about the prediction, in which lines are searched", gt=0.0)
    on_line_m: float = setting("distance up to which an observation lies on its line", gt=0.0)
    innovation_sigmas: float | None = setting(
        "largest distance to the prediction in standard deviations, plus `on_line_m`", default=None, gt=0.0
    )
    neighbour_test: NeighbourTestConfig | None = setting(
        "reject observations without a neighbour on the line: drops, puddles", default=None
    )
    chance_test: ChanceTestConfig | None = setting(
        "reject frames whose lines have no more observations than by chance", default=None
    )
    near_part: NearPartConfig | None = setting(
        "correct by the near part alone where one line is far ahead: a reflection", default=None
    )

    @property
    def drift(self) -> Floats:
        """(8,) process noise of the state in a metre of way."""
        ends = self.drift_width_m, self.drift_pitch_rad
        return np.array([self.drift_m, self.drift_rad, *self.drift_curvature_per_m, *ends])


@settings
class FirstGuessConfig:
    """Standard deviations of a road that was found from scratch."""

    sigma_m: float = setting("Standard deviation of the lateral place.", gt=0.0)
    sigma_rad: float = setting("Standard deviation of the heading.", gt=0.0)
    width_sigma_m: float = setting("Standard deviation of the lane width.", gt=0.0)
    mounted_rad: float = setting("of the pitch before any road was tracked", gt=0.0)
    pitched_rad: float = setting("of the pitch afterwards", gt=0.0)
    corrections: int = setting("by the same frame", ge=1)


@settings
class GuessCheckConfig:
    turned_rad: float = setting("largest change of the heading by the corrections", gt=0.0)


@settings
class RefutationConfig:
    frames: int = setting("consecutive frames in which other lines are visible", ge=1)
    way_m: float = setting("Distance travelled while other lines are visible.", ge=0.0)


@settings
class ObstacleMaskConfig:
    margin_m: float = setting("about an obstacle", ge=0.0)
    nearest_m: float = setting("from the camera; nearer obstacles hide nothing of the patch", gt=0.0)


@settings
class GroundConfig:
    weight: float = setting("of brightness and colour beside the lines", ge=0.0)
    unlike_levels: float = setting("difference of colour at which ground is as likely another surface", gt=0.0)
    least_road: float = setting("least likelihood that unlike ground is road", gt=0.0, lt=1.0)
    least_verge: float = setting("least likelihood that like ground is verge", gt=0.0, lt=1.0)


@settings
class LastingConfig:
    share: float = setting("of the judgements since the last change, that must be consecutive for another", gt=0.0)
    most: int = setting("judgements at most", ge=1)


@settings
class HypothesesConfig:
    """Evidence for the carriageway hypotheses."""

    solid_share: float = setting("mean visible share of a solid line", gt=0.0, le=1.0)
    solid_sd: float = setting("its standard deviation", gt=0.0)
    dashed_share: float = setting("mean visible share of a dashed line", gt=0.0, le=1.0)
    dashed_sd: float = setting("its standard deviation", gt=0.0)
    absent_share: float = setting("mean visible share where there is no line", ge=0.0, lt=1.0)
    absent_sd: float = setting("its standard deviation", gt=0.0)
    presences: tuple[float, ...] = setting("visible shares of all paint that are tried: wear, drops", min_length=1)
    surprise: float = setting("least likelihood of a line", gt=0.0, lt=1.0)
    hidden: float = setting("least likelihood of an invisible line, which may be occluded", gt=0.0, lt=1.0)
    hidden_share: float = setting("visible share below which a line is invisible", ge=0.0, lt=1.0)
    least_length_m: float = setting("visible length without which a line or strip gives no evidence", gt=0.0)
    line_reach_m: float = setting("about the expected place, in which a line is searched", gt=0.0)
    kept: float = setting("share of the evidence kept from one judgement to the next", gt=0.0, lt=1.0)
    weight: float = setting("of the evidence of one judgement", gt=0.0, le=1.0)
    other_lanes: float = setting("prior of another number of lanes of a road of one direction", gt=0.0, le=1.0)
    other_lane: float = setting(
        "prior of another first lane; on a road of two directions, of fewer lanes the other way", gt=0.0, le=1.0
    )
    switch_odds: float = setting("by which a hypothesis must be likelier to replace the current one", ge=1.0)
    beside_m: float = setting("largest distance of the pose to the carriageway", ge=0.0)
    two_way: float | None = setting(
        "prior of lanes of oncoming traffic beyond a solid line on the left; none: there are none",
        default=None,
        gt=0.0,
        le=1.0,
    )
    ground: GroundConfig | None = setting("compare the ground beside the own lane with its own", default=None)
    lasting: LastingConfig | None = setting("change the hypothesis only for lasting evidence", default=None)


@settings
class RoadEdgeConfig:
    """Prior of the road and how its lines are searched."""

    lanes: int = setting("likely number; solid lines at both edges, dashed lines within", ge=1)
    lane_width_m: float = setting("likely width", gt=1.0)
    likely_lane: int = setting("from the right, assumed before any line is visible", ge=1)
    near_m: float = setting("near end of the bird's-eye patch, from the pose")
    far_m: float = setting("far end of the patch", gt=0.0)
    half_width_m: float = setting("of the patch", gt=0.0)
    row_m: float = setting("least distance between rows of the patch", gt=0.0)
    column_m: float = setting("between columns of the patch", gt=0.0)
    verge_m: float = setting("by which the patch of the ground's colour is wider at both sides", ge=0.0)
    update_period_s: float = setting("between two corrections", gt=0.0)
    index_period_s: float = setting("between two judgements of the carriageway hypotheses", gt=0.0)
    search_period_s: float = setting("between two searches from scratch", gt=0.0)
    new_road_m: float = setting("least way between two judgements", ge=0.0)
    ridge_reach_m: float = setting("from a line to the background at both sides", gt=0.0)
    centroid_m: float = setting("about the strongest response, whose centroid is the line", gt=0.0)
    least_contrast: float = setting("Least contrast of a line in grey levels.", gt=0.0)
    sigma_m: float = setting("Standard deviation of an observation on the road; `sigma_px` adds to it.", gt=0.0)
    sigma_px: float = setting("Standard deviation of an observation in the image, in addition.", ge=0.0)
    least_rows: int = setting("observations without which a frame is ignored", ge=1)
    least_comb: float = setting("least score of a road found from scratch", ge=0.0)
    lost_sigma_m: float = setting("Standard deviation of the lateral place at which the road is forgotten.", gt=0.0)
    lost_share: float = setting(
        "Standard deviation of the lateral place, as a share of a lane, at which the road is forgotten.", gt=0.0
    )
    facing_rad: float = setting("heading beyond which a lost road is forgotten", gt=0.0)
    narrowest_lane_m: float = setting("Width of the narrowest lane that is searched for.", gt=0.0)
    widest_lane_m: float = setting("Width of the widest lane that is searched for.", gt=0.0)
    width_step_m: float = setting("Step between the lane widths that are searched for.", gt=0.0)
    wider_m: float = setting("by which a tracked lane may lie outside these widths", ge=0.0)
    unlikely_per_m: float = setting("lines that a lane 1 m off `lane_width_m` must explain more", ge=0.0)
    keeps_width: bool = setting("whether a lost road is searched with its last lane width")
    report_ahead_m: float = setting("distance at which the reported curvature is exact", gt=0.0)
    least_agreement: float = setting("share of visible lines at which the confidence is 0", ge=0.0, lt=0.5)
    least_certain: float = setting("confidence from which the pitch is reported", ge=0.0, le=1.0)
    confidence_sigma_m: float = setting("standard deviation that lowers the confidence e-fold", gt=0.0)
    comb: CombConfig
    filter: RoadFilterConfig
    first_guess: FirstGuessConfig
    hypotheses: HypothesesConfig
    object_sizes: ObjectSizes
    guess_check: GuessCheckConfig | None = setting(
        "reject a first guess whose lines lead away from a known road", default=None
    )
    refutation: RefutationConfig | None = setting("lose a road whose lines are elsewhere", default=None)
    obstacle_mask: ObstacleMaskConfig | None = setting("ignore the road that obstacles hide", default=None)

    def __post_init__(self) -> None:
        if self.likely_lane > self.lanes:
            raise ValueError(f"likely_lane: expected 1 .. {self.lanes}, got {self.likely_lane}")

    @property
    def widths_m(self) -> Floats:
        """Lane widths of the search."""
        return np.arange(self.narrowest_lane_m, self.widest_lane_m + 0.01, self.width_step_m)

    @property
    def patch(self) -> Patch:
        return Patch(self.near_m, self.far_m, self.half_width_m, self.row_m, self.column_m)

    @property
    def verge_patch(self) -> Patch:
        """Coarser, for the ground's colour."""
        width = self.half_width_m + self.verge_m
        return Patch(self.near_m, self.far_m, width, 2.0 * self.row_m, 10.0 * self.column_m)
