"""Settings of static obstacles and the collision alarm. A section that may be None can be switched off."""

from vpf_sim.configuration import setting, settings
from vpf_sim.perception.egomotion.config import NoiseModel
from vpf_sim.perception.obstacles.planar_parallax.config import LowTrackConfig, ParallaxConfig
from vpf_sim.perception.road.config import OcclusionConfig


@settings
class FreeRoadConfig:
    """What counts as a look at bare road, and how many it takes."""

    road: float = setting("largest difference where a body should begin, in multiples of the noise", ge=0.0)
    body: float = setting("from which on something stands there", ge=0.0)
    looks: int = setting("at bare road, more than at something", ge=1)
    way_m: float = setting("of the car between two: standing, it sees the same picture again", ge=0.0)
    about_m: tuple[float, float] = setting("along and across, what goes with a cleared body")
    most_points: float = setting("unless points of more weight tell it: a shadow hides a car's foot", gt=0.0)
    known_m: float = setting("standard deviation of the depth up to which a point has weight 1", gt=0.0)

    def __post_init__(self) -> None:
        if not 0.0 < self.road <= self.body:
            raise ValueError(f"road, body: expected 0 < road <= body, got {self.road}, {self.body}")


@settings
class LoomingConsistencyConfig:
    """Which points are of one thing, and how little they draw apart if it is far off."""

    baseline_s: float = setting("over which they are watched", gt=0.0)
    about_px: float = setting("between points of one thing, at most", gt=0.0)
    alike: float = setting("share of the inverse depth, by which theirs may differ", gt=0.0)
    noise_px: float = setting("standard deviation of a point's way over the baseline", gt=0.0)
    least: float = setting("of the growth that their inverse depth asks for", gt=0.0)
    sure: float = setting("standard deviations, by which it is less or more", gt=0.0)
    kept_s: float = setting("of verdicts, that count at most", gt=0.0)


@settings
class LowObstacleConfig:
    """When a point counts as low, and how many of them make a body."""

    near_m: float = setting("range of depth in which points are judged", ge=0.0)
    far_m: float = setting("farthest depth in which points are judged", ge=0.0)
    min_age_s: float = setting("age of a track, at least", ge=0.0)
    min_height_m: float = setting("height above the road, at least", ge=0.0)
    max_height_m: float = setting("height above the road, at most", ge=0.0)
    sigma_height_m: float = setting("largest standard deviation of the height", ge=0.0)
    chi2_limit: float = setting("of a point against its own depth", ge=0.0)
    chi2_margin: float = setting("by which the road must fit worse", ge=0.0)
    line_m: float = setting(
        "points whose foot on the road lies so near a line are not trusted: ends of dashes slide", ge=0.0
    )
    line_px: float = setting("besides, half of the flow's window", ge=0.0)
    edge_m: float = setting("the same of the edge lines", ge=0.0)
    link_right_m: float = setting("points nearer than this belong to one body", ge=0.0)
    link_forward_m: float = setting("the same along the road", ge=0.0)
    least_texture: float = setting("least", ge=0.0)
    least_points: int = setting("least", ge=0)
    least_margin: float = setting("sum over the points of a body, of which one adds", ge=0.0)
    most_margin: float = setting("at most this", ge=0.0)
    single_margin: float = setting("one alone needs this", ge=0.0)
    single_texture: float = setting(
        "a corner so clear (small eigenvalue, grey levels^2 / px^2): asphalt slides", ge=0.0
    )
    single_hits_s: float = setting("and so long", ge=0.0)
    least_width_m: float = setting("a body is told no narrower", ge=0.0)
    beside_m: float = setting("points so near a taller body are of it, unless", ge=0.0)
    sticks_out_m: float = setting("they reach so far out of it as the corner of a car's shadow does not", ge=0.0)
    sticks_out_share: float = setting(
        "or by this share of its width, which of a pedestrian any low body beside him does", gt=0.0
    )
    before_m: float = setting("or so far before its face", ge=0.0)
    part_m: tuple[float, float] = setting("and those so near one of its points, along and across")
    shade_m: tuple[float, float] = setting("behind a taller body's face and beside it, where it takes a point more")

    def __post_init__(self) -> None:
        if not 0.0 < self.near_m < self.far_m:
            raise ValueError(f"near_m, far_m: expected 0 < near < far, got {self.near_m}, {self.far_m}")
        if not 0.0 < self.min_height_m < self.max_height_m:
            raise ValueError(
                f"min_height_m, max_height_m: expected 0 < min < max, got {self.min_height_m}, {self.max_height_m}"
            )
        if not self.sticks_out_share > 0.0:
            raise ValueError(f"sticks_out_share: expected > 0, got {self.sticks_out_share}")
        for key in ("part_m", "shade_m"):
            if not min(getattr(self, key)) > 0.0:
                raise ValueError(f"{key}: expected both > 0, got {getattr(self, key)}")


@settings
class RefinementConfig:
    """Which points are matched with the frame of their first sighting: all that their tracks let stand on the road."""

    near_m: float = setting("of depth", ge=0.0)
    far_m: float = setting("farthest depth in which points are judged", ge=0.0)
    edge_m: float = setting("outside the carriageway", ge=0.0)
    least_height_m: float = setting("height, at least", ge=0.0)
    most_height_m: float = setting("height, at most", ge=0.0)
    chi2_limit: float = setting("of a point against its own depth", ge=0.0)
    chi2_margin: float = setting("by which the road must fit worse", ge=0.0)
    road_m: float = setting("up to where a ray meets the road, they are matched as if they lay there as well", ge=0.0)

    def __post_init__(self) -> None:
        for low, high in (("near_m", "far_m"), ("least_height_m", "most_height_m")):
            least, most = getattr(self, low), getattr(self, high)
            if not 0.0 < least < most:
                raise ValueError(f"{low}, {high}: expected 0 < {low} < {high}, got {least}, {most}")
        if min(self.edge_m, self.chi2_limit, self.chi2_margin) < 0.0 or not self.road_m > 0.0:
            raise ValueError("edge_m, chi2_limit, chi2_margin: expected >= 0, and road_m > 0")


@settings
class VerificationConfig:
    """When looks are taken, and when the road is seen in a body's place."""

    slow_mps: float = setting("looks are taken below this speed", ge=0.0)
    step_m: float = setting("of the car's way between two", ge=0.0)
    baseline_m: float = setting("and between the frames of one", ge=0.0)
    nearest_m: float = setting("range of the body's face, from the camera", ge=0.0)
    farthest_m: float = setting("farthest face, from the camera", ge=0.0)
    most_bearing: float = setting(
        "tangent, of its middle: farther aside the place leads past what stands there", gt=0.0
    )
    before_m: float = setting("of the face, where the place begins", ge=0.0)
    inside_m: float = setting(
        "of each side, where it ends: past one that grows narrower upwards the road is seen", ge=0.0
    )
    cell_m: float = setting("the place is judged in cells so wide and long", ge=0.0)
    rows: int = setting("so many behind each other", ge=1)
    grain_m: float = setting("spacing of the samples", ge=0.0)
    shift_grains: int = setting("the largest that is tried", ge=0)
    near_grains: int = setting("larger ones are none of the road", ge=0)
    least_correlation: float = setting("of the grain with none, in a cell of the road", ge=0.0)
    least_lead: float = setting("and by how much it is above that with any other", ge=0.0)
    most_other: float = setting("with any other: outlines that run along the way agree with all shifts", gt=0.0, le=1.0)
    road_share: float = setting("of the cells, over all looks", ge=0.0)
    least_looks: int = setting("least", ge=0)
    moved_m: float = setting("a body that is told elsewhere later is another", ge=0.0)

    def __post_init__(self) -> None:
        if not 0.0 < self.nearest_m < self.farthest_m:
            raise ValueError(f"nearest_m: expected 0 < nearest_m < farthest_m, got {self.nearest_m}")
        if not self.most_bearing > 0.0:
            raise ValueError(f"most_bearing: expected > 0, got {self.most_bearing}")
        if not self.inside_m >= 0.0:
            raise ValueError(f"inside_m: expected >= 0, got {self.inside_m}")
        if not self.rows >= 1:
            raise ValueError(f"rows: expected >= 1, got {self.rows}")
        if not 0.0 < self.most_other <= 1.0:
            raise ValueError(f"most_other: expected 0 < most_other <= 1, got {self.most_other}")

    def across_m(self, width_m: float) -> float:
        """How much of a body's width is looked at: half of it at least."""
        return max(width_m - 2.0 * self.inside_m, 0.5 * width_m)


@settings
class CollisionAlarmConfig:
    """When points in our way alarm."""

    bound_s: float = setting("they are met within this time", ge=0.0)
    half_way_m: float = setting("so near to our course, as standing points", ge=0.0)
    ceiling_m: float = setting("not above this", ge=0.0)
    least_baseline_m: float = setting("own way since the first sighting", ge=0.0)
    chi2_limit: float = setting("of a point against its own depth, plus", ge=0.0)
    chi2_ratio: float = setting("this share of its chi2 against the road", ge=0.0)
    chi2_margin: float = setting("by which the road must fit worse", ge=0.0)
    least_drop: float = setting("tangent below the horizon", ge=0.0)
    least_depth_m: float = setting("depth, at least", ge=0.0)
    least_points: int = setting("that agree", ge=0)
    agree_ratio: float = setting("in their inverse depth", ge=0.0)
    least_share: float = setting("of all that alarm", ge=0.0)
    least_width_m: float = setting("width, at least", ge=0.0)
    least_height_m: float = setting("height, at least", ge=0.0)
    after_s: float = setting("for so long", ge=0.0)
    hold_s: float = setting("without them", ge=0.0)


@settings
class EdgeLineConfig:
    """A strip about an edge line."""

    inside_m: float = setting("of the line", ge=0.0)
    outside_m: float = setting("of the line", ge=0.0)


@settings
class StaticObstacleConfig:
    """Limits and time constants of `vpf_sim.perception.obstacles.static_tracker.StaticObstacleTracker`."""

    update_period_s: float = setting("between judgements of the points", ge=0.0)
    window_px: int = setting("of the flow, for the noise of a track", ge=0)
    min_age_s: float = setting("age of a track, at least", ge=0.0)
    way_share: float = setting(
        "of the depth, that the car has gone since: on less, water on the glass looks near", ge=0.0
    )
    chi2_limit: float = setting("of a point against its own depth", ge=0.0)
    chi2_margin: float = setting("by which the road must fit worse", ge=0.0)
    depth_ratio: float = setting("largest sigma_Z / Z", ge=0.0)
    min_height_m: float = setting("height above the road, at least", ge=0.0)
    max_height_m: float = setting("height above the road, at most", ge=0.0)
    near_m: float = setting("range of depth in which points are judged", ge=0.0)
    far_m: float = setting("farthest depth in which points are judged", ge=0.0)
    turned_near_m: float = setting(
        "where it begins while the car is turned from the road by more than turned_rad", ge=0.0
    )
    turned_rad: float = setting("what is near shows its flank then", ge=0.0)
    hits_s: float = setting("a point is believed after so long", ge=0.0)
    hits_share: float = setting("if it stood above the road in this share of the frames since it first did", ge=0.0)
    steady_m: float = setting("and its place in the world changed by no more than this, plus", ge=0.0)
    steady_ratio: float = setting("this share of the depth", ge=0.0)
    single_hits_s: float = setting("and one alone after so long", ge=0.0)
    single_depth_ratio: tuple[float, float] = setting("known so well or so badly")
    single_min_height_m: tuple[float, float] = setting("at such a height: ends of dashes seem to stand 0.3 m high")
    single_max_height_m: float = setting("height of a single point, at most", ge=0.0)
    single_far_m: float = setting("depth of a single point, at most", ge=0.0)
    recent_px: float = setting("largest error of the motion in the last window, plus", ge=0.0)
    recent_ratio: float = setting("this share of its length", ge=0.0)
    edge_margin_m: float = setting("inside the carriageway's edges", ge=0.0)
    corner_texture: float = setting("unless so clear a corner (small eigenvalue, grey levels^2 / px^2)", ge=0.0)
    corner_ratio: float = setting("that is no less than this share of the large one: edges have .2", ge=0.0)
    founding_texture: float = setting(
        "smaller ones found no body: where puddles end and what they mirror begins slides", ge=0.0
    )
    dash_far_m: float = setting("nor do points farther than this", ge=0.0)
    dash_height_m: float = setting(
        "and lower than this whose ray meets the road on a line: ends of dashes slide there", ge=0.0
    )
    foot_m: float = setting(
        "points whose ray meets the road farther away found no body: bends of lines slide there", ge=0.0
    )
    high_share: float = setting(
        "but corners so clear as to be trusted beside an edge line count for so much of one", ge=0.0, lt=1.0
    )
    link_right_m: float = setting("points nearer than this belong to one body", ge=0.0)
    link_forward_m: float = setting("the same along the road", ge=0.0)
    face_sigma_m: float = setting("a body is told once its face is known so well", ge=0.0)
    told_m: float = setting("and so near, from the pose: depth errs with the square of the distance", ge=0.0)
    sharp_side_m: float = setting(
        "points with a smaller sigma across count for the sides, or those near the best", ge=0.0
    )
    outdated_share: float = setting(
        "parts come nearer to than this share of their depth, and not seen again, are none", ge=0.0, lt=1.0
    )
    beside_m: float = setting("each side is told so much farther out than its points tell", ge=0.0)
    least_width_m: float = setting(
        "a body is told no narrower: a cone's flow comes from its stripes, its base is wider", ge=0.0
    )
    behind_m: float = setting("where a body is forgotten", ge=0.0)
    noise: NoiseModel = setting("of the point tracks")
    occlusion: OcclusionConfig = setting("footprints of obstacles that hide the road")
    spots: LowTrackConfig = setting("of its tracks")
    residual: ParallaxConfig = setting("of planar parallax")
    edge_lines: EdgeLineConfig | None = setting(
        "edge lines: points near an edge line count only if they are clear corners, since others slide", default=None
    )
    low_obstacles: LowObstacleConfig | None = setting(
        "low obstacles from points: several points a hand's breadth above the road make one", default=None
    )
    looming_consistency: LoomingConsistencyConfig | None = setting(
        "looming consistency: points that expand too little for their distance are far away and are ignored",
        default=None,
    )
    free_road: FreeRoadConfig | None = setting(
        "free road: obstacles in whose place the road is seen are deleted", default=None
    )
    track_refinement: RefinementConfig | None = setting(
        "track refinement: points that may be obstacles are matched again with their first frame", default=None
    )

    def __post_init__(self) -> None:
        if not 0.0 < self.near_m < self.far_m:
            raise ValueError(f"near_m, far_m: expected 0 < near < far, got {self.near_m}, {self.far_m}")
        if not self.near_m <= self.turned_near_m < self.far_m:
            raise ValueError(f"turned_near_m: expected near_m <= it < far_m, got {self.turned_near_m}")
        if self.min_height_m >= self.max_height_m:
            raise ValueError(f"min_height_m: expected < max_height_m, got {self.min_height_m}")
        for key in ("single_depth_ratio", "single_min_height_m"):
            if not 0.0 < getattr(self, key)[0] < getattr(self, key)[1]:
                raise ValueError(f"{key}: expected 0 < first < second, got {getattr(self, key)}")
