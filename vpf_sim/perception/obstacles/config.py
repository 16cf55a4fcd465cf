"""Settings of static obstacles and the collision alarm. A section that may be None can be switched off."""

from vpf_sim.configuration import setting, settings
from vpf_sim.perception.egomotion.config import NoiseModel
from vpf_sim.perception.obstacles.planar_parallax.config import LowTrackConfig, ParallaxConfig
from vpf_sim.perception.road.config import OcclusionConfig


@settings
class FreeRoadConfig:
    """When the road is seen where an obstacle should stand."""

    road: float = setting("largest difference of the images that counts as road, in multiples of the noise", ge=0.0)
    body: float = setting("least difference that counts as an obstacle, in multiples of the noise", ge=0.0)
    looks: int = setting("observations of road, less those of an obstacle, that delete it", ge=1)
    way_m: float = setting("travel between two observations: at standstill the image repeats itself", ge=0.0)
    about_m: tuple[float, float] = setting(
        "points within this distance, along and across, are deleted with an obstacle"
    )
    most_points: float = setting("an obstacle whose points weigh more stays: a shadow hides the foot of a car", gt=0.0)
    known_m: float = setting("standard deviation of the depth up to which a point has weight 1", gt=0.0)

    def __post_init__(self) -> None:
        if not 0.0 < self.road <= self.body:
            raise ValueError(f"road, body: expected 0 < road <= body, got {self.road}, {self.body}")


@settings
class LoomingConsistencyConfig:
    """Which points belong together, and how little they spread if they are far away."""

    baseline_s: float = setting("time over which points are compared", gt=0.0)
    about_px: float = setting("largest distance between points that belong together", gt=0.0)
    alike: float = setting("largest difference of their inverse depths, as a share", gt=0.0)
    noise_px: float = setting("standard deviation of a point's motion over the baseline", gt=0.0)
    least: float = setting("least growth, as a share of what the inverse depth predicts", gt=0.0)
    sure: float = setting("standard deviations by which the growth must differ", gt=0.0)
    kept_s: float = setting("largest weight of earlier results, as a time", gt=0.0)


@settings
class LowObstacleConfig:
    """When a point counts as low, and how many of them make an obstacle."""

    near_m: float = setting("nearest depth of a low point", ge=0.0)
    far_m: float = setting("farthest depth of a low point", ge=0.0)
    min_age_s: float = setting("least age of a track", ge=0.0)
    min_height_m: float = setting("least height above the road", ge=0.0)
    max_height_m: float = setting("largest height above the road", ge=0.0)
    sigma_height_m: float = setting("largest standard deviation of the height", ge=0.0)
    chi2_limit: float = setting("largest chi2 of a point at its own depth", ge=0.0)
    chi2_margin: float = setting("least excess of the chi2 of a point on the road", ge=0.0)
    line_m: float = setting("points within this distance of a lane line do not count: ends of dashes slide", ge=0.0)
    line_px: float = setting("added to it in the image, half of the flow window", ge=0.0)
    edge_m: float = setting("the same distance for edge lines", ge=0.0)
    link_right_m: float = setting("points nearer than this, across, belong to one obstacle", ge=0.0)
    link_forward_m: float = setting("the same along the road", ge=0.0)
    least_texture: float = setting("least texture of a point (small eigenvalue, grey levels^2 / px^2)", ge=0.0)
    least_points: int = setting("least number of points", ge=0)
    least_margin: float = setting("least sum of the chi2 margins over the points of an obstacle", ge=0.0)
    most_margin: float = setting("largest margin that one point adds", ge=0.0)
    single_margin: float = setting("least margin of a point that stands alone", ge=0.0)
    single_texture: float = setting("least texture of a point that stands alone: asphalt slides", ge=0.0)
    single_hits_s: float = setting("time for which a single point must be observed", ge=0.0)
    least_width_m: float = setting("least reported width", ge=0.0)
    beside_m: float = setting("points this near to a taller obstacle belong to it, unless they stick out", ge=0.0)
    sticks_out_m: float = setting("this far beyond its side: the corner of a car's shadow does not", ge=0.0)
    sticks_out_share: float = setting(
        "or by this share of its width: next to a narrow pedestrian any low obstacle does", gt=0.0
    )
    before_m: float = setting("or this far before its face", ge=0.0)
    part_m: tuple[float, float] = setting("points this near to one of its points, along and across, belong to it too")
    shade_m: tuple[float, float] = setting(
        "region of the shadow behind the face and beside it, where one more point is needed"
    )

    def __post_init__(self) -> None:
        if not 0.0 < self.near_m < self.far_m:
            raise ValueError(f"near_m, far_m: expected 0 < near < far, got {self.near_m}, {self.far_m}")
        if not 0.0 < self.min_height_m < self.max_height_m:
            raise ValueError(
                f"min_height_m, max_height_m: expected 0 < min < max, got {self.min_height_m}, {self.max_height_m}"
            )
        for key in ("part_m", "shade_m"):
            if not min(getattr(self, key)) > 0.0:
                raise ValueError(f"{key}: expected both > 0, got {getattr(self, key)}")


@settings
class RefinementConfig:
    """Which points are matched with the frame of their first observation."""

    near_m: float = setting("nearest depth", ge=0.0)
    far_m: float = setting("farthest depth", ge=0.0)
    edge_m: float = setting("largest distance outside the carriageway", ge=0.0)
    least_height_m: float = setting("least height", ge=0.0)
    most_height_m: float = setting("largest height", ge=0.0)
    chi2_limit: float = setting("largest chi2 of a point at its own depth", ge=0.0)
    chi2_margin: float = setting("least excess of the chi2 of a point on the road", ge=0.0)
    road_m: float = setting("a point whose ray meets the road nearer than this is matched as a road point too", gt=0.0)

    def __post_init__(self) -> None:
        for low, high in (("near_m", "far_m"), ("least_height_m", "most_height_m")):
            least, most = getattr(self, low), getattr(self, high)
            if not 0.0 < least < most:
                raise ValueError(f"{low}, {high}: expected 0 < {low} < {high}, got {least}, {most}")


@settings
class VerificationConfig:
    """When an obstacle is verified from near, and when the road is seen in its place."""

    slow_mps: float = setting("largest speed at which obstacles are verified", ge=0.0)
    step_m: float = setting("travel between two observations", ge=0.0)
    baseline_m: float = setting("travel between the two frames of an observation", ge=0.0)
    nearest_m: float = setting("nearest face, from the camera", ge=0.0)
    farthest_m: float = setting("farthest face, from the camera", ge=0.0)
    most_bearing: float = setting(
        "largest tangent of the bearing: farther aside the region leads past the obstacle", gt=0.0
    )
    before_m: float = setting("distance before the face at which the region begins", ge=0.0)
    inside_m: float = setting(
        "margin inside each side: past an obstacle that narrows upwards the road is visible", ge=0.0
    )
    cell_m: float = setting("width and length of a cell of the region", ge=0.0)
    rows: int = setting("rows of cells", ge=1)
    grain_m: float = setting("spacing of the samples", ge=0.0)
    shift_grains: int = setting("largest shift that is tried, in samples", ge=0)
    near_grains: int = setting("largest shift that still counts as road, in samples", ge=0)
    least_correlation: float = setting("least correlation at no shift, in a cell that shows road", ge=0.0)
    least_lead: float = setting("least excess over the correlation at any other shift", ge=0.0)
    most_other: float = setting(
        "largest correlation at any other shift: contours along the road match at all shifts", gt=0.0, le=1.0
    )
    road_share: float = setting("least share of road cells, over all observations", ge=0.0)
    least_looks: int = setting("least number of observations", ge=0)
    moved_m: float = setting("an obstacle that moves farther than this is verified anew", ge=0.0)

    def __post_init__(self) -> None:
        if not 0.0 < self.nearest_m < self.farthest_m:
            raise ValueError(f"nearest_m: expected 0 < nearest_m < farthest_m, got {self.nearest_m}")

    def across_m(self, width_m: float) -> float:
        """How much of a body's width is looked at: half of it at least."""
        return max(width_m - 2.0 * self.inside_m, 0.5 * width_m)


@settings
class EdgeLineConfig:
    """The strip along an edge line in which points must be clear corners."""

    inside_m: float = setting("width of the strip on the road", ge=0.0)
    outside_m: float = setting("width of the strip beside the road", ge=0.0)


@settings
class StaticObstacleConfig:
    """Thresholds and time constants of the static obstacle tracker."""

    update_period_s: float = setting("between two updates of the points", ge=0.0)
    window_px: int = setting("side of the flow window, for the noise of a track", ge=0)
    min_age_s: float = setting("least age of a track", ge=0.0)
    way_share: float = setting(
        "least travel since the first observation, as a share of the depth: water on the windscreen looks near", ge=0.0
    )
    chi2_limit: float = setting("largest chi2 of a point at its own depth", ge=0.0)
    chi2_margin: float = setting("least excess of the chi2 of a point on the road", ge=0.0)
    depth_ratio: float = setting("largest standard deviation of the depth, as a share of it", ge=0.0)
    min_height_m: float = setting("least height above the road", ge=0.0)
    max_height_m: float = setting("largest height above the road", ge=0.0)
    near_m: float = setting("nearest depth", ge=0.0)
    far_m: float = setting("farthest depth", ge=0.0)
    turned_near_m: float = setting("nearest depth while the car is turned by more than `turned_rad`", ge=0.0)
    turned_rad: float = setting("angle to the road from which near obstacles show their flanks", ge=0.0)
    hits_s: float = setting("time after which a point is confirmed", ge=0.0)
    hits_share: float = setting("least share of the frames since then in which it was above the road", ge=0.0)
    steady_m: float = setting("largest change of its place in the world, plus", ge=0.0)
    steady_ratio: float = setting("this share of the depth", ge=0.0)
    single_hits_s: float = setting("time after which a single point is confirmed", ge=0.0)
    single_depth_ratio: tuple[float, float] = setting("relative depth errors of a well and a badly known single point")
    single_min_height_m: tuple[float, float] = setting(
        "least heights of these two: ends of dashes seem to stand 0.3 m high"
    )
    single_max_height_m: float = setting("largest height of a single point", ge=0.0)
    single_far_m: float = setting("largest depth of a single point", ge=0.0)
    recent_px: float = setting("largest error of the motion over the last window, plus", ge=0.0)
    recent_ratio: float = setting("this share of its length", ge=0.0)
    edge_margin_m: float = setting("least distance inside the carriageway's edges", ge=0.0)
    corner_texture: float = setting("texture of a clear corner (small eigenvalue, grey levels^2 / px^2)", ge=0.0)
    corner_ratio: float = setting("least ratio of its eigenvalues: edges have 0.2", ge=0.0)
    founding_texture: float = setting("least texture of a seed point: edges of puddles and reflections slide", ge=0.0)
    dash_far_m: float = setting("depth from which low points on a line are no seeds", ge=0.0)
    dash_height_m: float = setting("height below which they count as low: ends of dashes slide", ge=0.0)
    foot_m: float = setting("a point whose ray meets the road farther away is no seed: lines slide in bends", ge=0.0)
    high_share: float = setting("seed weight that a clear corner keeps there", ge=0.0, lt=1.0)
    link_right_m: float = setting("points nearer than this, across, belong to one obstacle", ge=0.0)
    link_forward_m: float = setting("the same along the road", ge=0.0)
    face_sigma_m: float = setting("largest standard deviation of a reported obstacle's face", ge=0.0)
    told_m: float = setting("largest distance of a reported obstacle: depth errors grow with its square", ge=0.0)
    sharp_side_m: float = setting("points with a smaller lateral standard deviation define the sides", ge=0.0)
    outdated_share: float = setting(
        "points not observed again below this share of their depth are stale", ge=0.0, lt=1.0
    )
    beside_m: float = setting("margin added to each reported side", ge=0.0)
    least_width_m: float = setting(
        "least reported width: a cone's flow comes from its stripes, its base is wider", ge=0.0
    )
    behind_m: float = setting("distance behind the car at which an obstacle is pruned", ge=0.0)
    noise: NoiseModel = setting("noise of the point tracks")
    occlusion: OcclusionConfig = setting("regions that obstacles hide")
    spots: LowTrackConfig = setting("tracks of low obstacles")
    residual: ParallaxConfig = setting("planar parallax")
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
