"""Settings of the road edge tracker."""

import numpy as np

from vpf_sim.configuration import setting, settings
from vpf_sim.perception.road.birds_eye import Patch
from vpf_sim.types import Floats


@settings
class CombConfig:
    """Search for a road from scratch."""

    reach_m: float = setting("Farthest row of the search.", gt=0.0)
    heading_limit_deg: float = setting("Largest heading of the search to both sides.", gt=0.0)
    heading_step_deg: float = setting("Step between two headings of the search.", gt=0.0)
    curvature_limit_per_m: float = setting("Largest curvature of the search to both sides.", gt=0.0)
    curvature_step_per_m: float = setting("Step between two curvatures of the search.", gt=0.0)
    unlikely_per_rad: float = setting(
        "Number of lines that a heading must explain in addition, per rad off the likely one.", ge=0.0
    )
    unlikely_m: float = setting(
        "Number of lines that a curvature must explain in addition, times its radius in m.", ge=0.0
    )

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
    apart_m: float = setting("Largest difference of an offset to that in a neighbouring row.", gt=0.0)


@settings
class ChanceTestConfig:
    sigmas: float = setting(
        "Standard deviations by which the observations on lines must exceed their number by chance.", ge=0.0
    )


@settings
class NearPartConfig:
    within_m: float = setting("Distance from the pose that is the near part.", gt=0.0)
    least_rows: int = setting("Least number of observations of a line in the far part.", ge=1)


@settings
class RoadFilterConfig:
    """Kalman filter of the road's state."""

    drift_m: float = setting("Process noise of the lateral place in a metre travelled.", gt=0.0)
    drift_rad: float = setting("Process noise of the heading in a metre travelled.", gt=0.0)
    drift_curvature_per_m: tuple[float, float, float, float] = setting("Drift of the curvature at each node.")
    drift_width_m: float = setting("Process noise of the lane width in a metre travelled.", gt=0.0)
    drift_pitch_rad: float = setting("Process noise of the camera's pitch in a metre travelled.", gt=0.0)
    drift_verge_m: float = setting("Process noise of the verges' places in a metre travelled.", gt=0.0)
    shared_curvature_per_m: float = setting("Initial standard deviation of the curvature of all nodes.", gt=0.0)
    added_curvature_per_m: float = setting(
        "Standard deviation of each node's difference in curvature to the one before.", gt=0.0
    )
    tightest_per_m: float = setting("Largest curvature of the road.", gt=0.0)
    turned_rad: float = setting("Largest heading at which lines are tracked.", gt=0.0)
    steepest_rad: float = setting("Largest pitch of the camera.", gt=0.0)
    passes_m: tuple[float, ...] = setting("Cut of Tukey's biweight in each pass.", min_length=1)
    reach_m: float = setting("Distance from the prediction within which lines are searched.", gt=0.0)
    on_line_m: float = setting("Distance up to which an observation lies on its line.", gt=0.0)
    innovation_sigmas: float = setting(
        "Largest distance to the prediction in standard deviations, plus `on_line_m`.", gt=0.0
    )
    neighbour_test: NeighbourTestConfig = setting(
        "Rejects observations without a neighbour on the line, such as drops and puddles."
    )
    chance_test: ChanceTestConfig = setting("Rejects frames whose lines have no more observations than by chance.")
    near_part: NearPartConfig = setting(
        "Corrects by the near part alone where only one line is visible far ahead, as of a reflection."
    )

    @property
    def drift(self) -> Floats:
        """(10,) process noise of the state in a metre travelled."""
        ends = self.drift_width_m, self.drift_pitch_rad, self.drift_verge_m, self.drift_verge_m
        return np.array([self.drift_m, self.drift_rad, *self.drift_curvature_per_m, *ends])


@settings
class FirstGuessConfig:
    """Standard deviations of a road that was found from scratch."""

    sigma_m: float = setting("Standard deviation of the lateral place.", gt=0.0)
    sigma_rad: float = setting("Standard deviation of the heading.", gt=0.0)
    width_sigma_m: float = setting("Standard deviation of the lane width.", gt=0.0)
    mounted_rad: float = setting("Standard deviation of the pitch before any road was tracked.", gt=0.0)
    pitched_rad: float = setting("Standard deviation of the pitch after a road was tracked.", gt=0.0)
    corrections: int = setting("Number of corrections by the same frame.", ge=1)


@settings
class GuessCheckConfig:
    turned_rad: float = setting("Largest change of the heading by the corrections.", gt=0.0)


@settings
class RefutationConfig:
    frames: int = setting("Number of consecutive frames in which not the road is seen, or not its lines.", ge=1)
    way_m: float = setting("Distance travelled meanwhile.", ge=0.0)


@settings
class ObstacleMaskConfig:
    margin_m: float = setting("Margin about an obstacle.", ge=0.0)
    nearest_m: float = setting("Depth from the camera below which obstacles occlude nothing of the patch.", gt=0.0)


@settings
class VergeConfig:
    """How the ends of the road's surface are searched."""

    column_m: float = setting("Distance between columns of the bird's-eye patch.", gt=0.0)
    surface_m: float = setting(
        "Width of the surfaces at both sides that are compared: an odd number of columns, at least 3.", gt=0.0
    )
    centroid_m: float = setting("Distance about the strongest step whose centroid is the verge.", gt=0.0)
    least_levels: float = setting("Least difference of colour of a verge in grey levels.", gt=0.0)
    sigma_m: float = setting("Standard deviation of an observation on the road.", gt=0.0)
    beside_m: float = setting("Least distance of a verge from the car's middle.", gt=0.0)
    least_length_m: float = setting("Visible length up to which the part that is hidden counts as not seen.", gt=0.0)
    found_share: float = setting("Share of its length in which a new verge must be visible.", gt=0.0)
    clear_share: float = setting("Visible share of its length from which a verge is evidence for the edges.", gt=0.0)
    found_sigma_m: float = setting("Standard deviation of the place of a new verge.", gt=0.0)
    lost_share: float = setting("Share of its length below which a verge is forgotten.", gt=0.0)
    new_share: float = setting("Weight of the last frame in the averaged share.", gt=0.0, le=1.0)
    on_verge_m: float = setting("Distance from the expected place within which a verge is judged.", gt=0.0)


@settings
class GroundConfig:
    weight: float = setting("Weight of brightness and colour beside the lines.", ge=0.0)
    unlike_levels: float = setting("Difference of colour at which ground is as likely another surface.", gt=0.0)
    least_road: float = setting("Least likelihood that unlike ground is road.", gt=0.0, lt=1.0)
    least_verge: float = setting("Least likelihood that like ground is verge.", gt=0.0, lt=1.0)


@settings
class LastingConfig:
    share: float = setting(
        "Share of the updates since the last change that must agree in sequence for another change.", gt=0.0
    )
    most: int = setting("Largest number of updates that a change needs.", ge=1)


@settings
class HypothesesConfig:
    """Evidence for the carriageway hypotheses."""

    solid_share: float = setting("Mean visible share of a solid line.", gt=0.0, le=1.0)
    solid_sd: float = setting("Standard deviation of the visible share of a solid line.", gt=0.0)
    dashed_share: float = setting("Mean visible share of a dashed line.", gt=0.0, le=1.0)
    dashed_sd: float = setting("Standard deviation of the visible share of a dashed line.", gt=0.0)
    absent_share: float = setting("Mean visible share where there is no line.", ge=0.0, lt=1.0)
    absent_sd: float = setting("Standard deviation of the visible share where there is no line.", gt=0.0)
    presences: tuple[float, ...] = setting(
        "Visible shares of all paint that are tried, for wear and drops.", min_length=1
    )
    surprise: float = setting("Least likelihood of a line.", gt=0.0, lt=1.0)
    hidden: float = setting("Least likelihood of an invisible line, which may be occluded.", gt=0.0, lt=1.0)
    hidden_share: float = setting("Visible share below which a line is invisible.", ge=0.0, lt=1.0)
    least_length_m: float = setting("Visible length without which a line or strip gives no evidence.", gt=0.0)
    line_reach_m: float = setting("Distance from the expected place within which a line is searched.", gt=0.0)
    off_verge: float = setting("Likelihood of an edge beyond a clear verge.", gt=0.0, le=1.0)
    kept: float = setting("Share of the evidence that is kept from one update to the next.", gt=0.0, lt=1.0)
    weight: float = setting("Weight of the evidence of one update.", gt=0.0, le=1.0)
    other_lanes: float = setting("Prior of another number of lanes of a road of one direction.", gt=0.0, le=1.0)
    other_lane: float = setting(
        "Prior of another first lane; on a road of two directions, of fewer lanes the other way.", gt=0.0, le=1.0
    )
    switch_odds: float = setting("Odds by which a hypothesis must be likelier to replace the current one.", ge=1.0)
    beside_m: float = setting("Largest distance of the pose to the carriageway.", ge=0.0)
    two_way: float = setting("Prior of lanes of oncoming traffic beyond a solid line on the left.", gt=0.0, le=1.0)
    ground: GroundConfig = setting("Compares the ground beside the own lane with that of the lane.")
    lasting: LastingConfig = setting("Changes the hypothesis only for lasting evidence.")


@settings
class RoadEdgeConfig:
    """Prior of the road and how its lines are searched."""

    lanes: int = setting("Likely number of lanes, with solid lines at both edges and dashed lines between.", ge=1)
    lane_width_m: float = setting("Likely width of a lane.", gt=1.0)
    likely_lane: int = setting("Lane from the right that is assumed before any line is visible.", ge=1)
    near_m: float = setting("Near end of the bird's-eye patch, from the pose.")
    far_m: float = setting("Far end of the bird's-eye patch, from the pose.", gt=0.0)
    half_width_m: float = setting("Half of the width of the bird's-eye patch.", gt=0.0)
    row_m: float = setting("Least distance between rows of the bird's-eye patch.", gt=0.0)
    column_m: float = setting("Distance between columns of the bird's-eye patch.", gt=0.0)
    verge_m: float = setting("Width by which the patch of the ground's colour is wider at both sides.", ge=0.0)
    update_period_s: float = setting("Time between two corrections.", gt=0.0)
    index_period_s: float = setting("Time between two updates of the carriageway hypotheses.", gt=0.0)
    search_period_s: float = setting("Time between two searches without a tracked road, or without its lines.", gt=0.0)
    new_road_m: float = setting("Least distance travelled between two updates of the hypotheses.", ge=0.0)
    ridge_reach_m: float = setting("Distance from a line to the background at both sides.", gt=0.0)
    centroid_m: float = setting("Distance about the strongest response whose centroid is the line.", gt=0.0)
    least_contrast: float = setting("Least contrast of a line in grey levels.", gt=0.0)
    sigma_m: float = setting("Standard deviation of an observation on the road; `sigma_px` adds to it.", gt=0.0)
    sigma_px: float = setting("Standard deviation of an observation in the image, in addition.", ge=0.0)
    least_rows: int = setting("Least number of observations; a frame with fewer is ignored.", ge=1)
    least_comb: float = setting("Least score of a road that a search finds.", ge=0.0)
    lost_sigma_m: float = setting("Standard deviation of the lateral place at which the road is forgotten.", gt=0.0)
    lost_share: float = setting(
        "Standard deviation of the lateral place, as a share of a lane, at which the road is forgotten.", gt=0.0
    )
    facing_rad: float = setting("Heading beyond which a lost road is forgotten.", gt=0.0)
    narrowest_lane_m: float = setting("Width of the narrowest lane that is searched for.", gt=0.0)
    widest_lane_m: float = setting("Width of the widest lane that is searched for.", gt=0.0)
    width_step_m: float = setting("Step between the lane widths that are searched for.", gt=0.0)
    wider_m: float = setting("Distance by which the width of a tracked lane may lie outside the likely widths.", ge=0.0)
    unlikely_per_m: float = setting(
        "Number of lines that a lane must explain in addition, per m off `lane_width_m`.", ge=0.0
    )
    keeps_width: bool = setting("Whether a lost road is searched with its last lane width.")
    report_ahead_m: float = setting("Distance at which the reported curvature is exact.", gt=0.0)
    least_agreement: float = setting("Share of visible lines at which the confidence is 0.", ge=0.0, lt=0.5)
    least_certain: float = setting("Confidence from which the pitch is reported.", ge=0.0, le=1.0)
    confidence_sigma_m: float = setting("Standard deviation that lowers the confidence e-fold.", gt=0.0)
    comb: CombConfig
    filter: RoadFilterConfig
    first_guess: FirstGuessConfig
    hypotheses: HypothesesConfig
    guess_check: GuessCheckConfig = setting("Rejects a first guess whose lines lead away from a known road.")
    refutation: RefutationConfig = setting(
        "Loses a road that is elsewhere, and searches the paint of one that verges alone show."
    )
    obstacle_mask: ObstacleMaskConfig = setting("Ignores the road that obstacles occlude.")

    def __post_init__(self) -> None:
        if self.likely_lane > self.lanes:
            raise ValueError(f"likely_lane: expected 1 .. {self.lanes}, got {self.likely_lane}")
        if self.narrowest_lane_m > self.widest_lane_m:
            widest, narrowest = self.widest_lane_m, self.narrowest_lane_m
            raise ValueError(f"narrowest_lane_m: expected at most widest_lane_m, {widest:g}, got {narrowest:g}")

    @property
    def widths_m(self) -> Floats:
        """Lane widths of the search."""
        return np.arange(self.narrowest_lane_m, self.widest_lane_m + 0.01, self.width_step_m)

    @property
    def patch(self) -> Patch:
        return Patch(self.near_m, self.far_m, self.half_width_m, self.row_m, self.column_m)

    def verge_patch(self, column_m: float) -> Patch:
        """For the verges; its rows are those of `patch`."""
        return Patch(self.near_m, self.far_m, self.half_width_m + self.verge_m, self.row_m, column_m)

    @property
    def colour_patch(self) -> Patch:
        """Coarser, for the ground's colour."""
        width = self.half_width_m + self.verge_m
        return Patch(self.near_m, self.far_m, width, 2.0 * self.row_m, 10.0 * self.column_m)
