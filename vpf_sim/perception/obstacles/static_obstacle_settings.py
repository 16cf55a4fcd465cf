"""Settings of static obstacles and the collision alarm. A section that may be None can be switched off."""

from vpf_sim.configuration import setting, settings
from vpf_sim.perception.egomotion.egomotion_settings import NoiseModel
from vpf_sim.perception.obstacles.planar_parallax.low_obstacle_settings import LowTrackConfig, ParallaxConfig
from vpf_sim.perception.road.road_settings import OcclusionConfig


@settings
class Switch:
    """A mechanism without settings."""


@settings
class FarRoadConfig:
    """Seed weight of points whose ray meets the road far away, or not at all: lines slide in bends."""

    share: float = setting("seed weight that a clear corner keeps", ge=0.0, lt=1.0)


@settings
class DashSeedConfig:
    """Low points on a line, farther than `precise_m`, are no seeds: ends of dashes slide."""

    height_m: float = setting("height below which they count as low", ge=0.0)


@settings
class RecentMotionConfig:
    """A point's motion over the last window must fit its place: a track may slip on to something else."""

    error_px: float = setting("Largest error of the motion; `ratio` adds to it.", ge=0.0)
    ratio: float = setting("Share of the motion's length that adds to its largest error.", ge=0.0)


@settings
class SplitConfig:
    """Points behind an obstacle's face and beside it are another obstacle."""

    step_m: float = setting("least distance behind the face, and `sure_sigmas`", ge=0.0)
    beside_m: float = setting("least distance beside the points at the face", ge=0.0)


@settings
class SharpestConfig:
    """The points seen from nearest define a side, others only if they lie farther out than their blur explains."""

    points: int = setting("number of points that define how sharp an obstacle is known", ge=1)
    ratio: float = setting("largest blur, as a multiple of theirs", ge=1.0)
    blurs: float = setting("least distance of another point farther out, in its own blur", ge=0.0)


@settings
class FragmentConfig:
    """A smaller cluster of the same obstacle behind it, hidden by it or in line with it, is no obstacle."""

    behind_m: float = setting("distance behind it from which this holds", ge=0.0)
    length_m: float = setting("distance behind it up to which a cluster in line is a part", ge=0.0)
    beside_m: float = setting("largest distance beside it of a cluster in line", ge=0.0)
    rim_rad: float = setting("angle beside it that counts as hidden", ge=0.0)


@settings
class NearbyConfig:
    """Region about a point of a taller obstacle in which low points belong to it."""

    along_m: float = setting("distance along the road", gt=0.0)
    across_m: float = setting("distance across", gt=0.0)


@settings
class OnTopConfig:
    """Where a taller obstacle may be the upper edge of a wider low one that it overlaps."""

    before_m: float = setting("largest distance of the low one before it", ge=0.0)


@settings
class ParallaxMatchConfig:
    """Which low obstacle of planar parallax is the same as one of points."""

    along_m: float = setting("largest distance along the road", gt=0.0)


@settings
class LowObstacleConfig:
    """When a point counts as low, and how many of them make an obstacle."""

    near_m: float = setting("nearest depth of a low point", ge=0.0)
    min_age_s: float = setting("least age of a track", ge=0.0)
    min_height_m: float = setting("least height above the road", ge=0.0)
    max_height_m: float = setting("largest height above the road", ge=0.0)
    sigma_height_m: float = setting("largest standard deviation of the height", ge=0.0)
    chi2_margin: float = setting("least excess of the chi2 of a point on the road", ge=0.0)
    line_m: float = setting("points within this distance of a lane line do not count: ends of dashes slide", ge=0.0)
    line_px: float = setting("Distance in the image that adds to `line_m`: half of the flow window.", ge=0.0)
    edge_m: float = setting("Points within this distance of an edge line do not count.", ge=0.0)
    link_right_m: float = setting("points nearer than this, across, belong to one obstacle", ge=0.0)
    link_forward_m: float = setting("Points nearer than this, along the road, belong to one obstacle.", ge=0.0)
    least_texture: float = setting("least texture of a point (small eigenvalue, grey levels^2 / px^2)", ge=0.0)
    least_points: int = setting("least number of points", ge=0)
    least_margin: float = setting("least sum of the chi2 margins over the points of an obstacle", ge=0.0)
    most_margin: float = setting("largest margin that one point adds", ge=0.0)
    beside_m: float = setting("points this near to a taller obstacle belong to it, unless they stick out", ge=0.0)
    sticks_out_m: float = setting(
        "Distance beyond a taller obstacle's side at which points stick out; the corner of a car's shadow does not.",
        ge=0.0,
    )
    sticks_out_share: float = setting("Share of a narrow obstacle's width by which points stick out beside it.", gt=0.0)
    before_m: float = setting("Distance before a taller obstacle's face at which points stick out.", ge=0.0)
    part: NearbyConfig | None = setting("points beside one of a taller obstacle belong to it", default=None)
    on_top: OnTopConfig | None = setting("a narrower taller obstacle is the upper edge of a low one", default=None)
    parallax: ParallaxMatchConfig | None = setting("low points take the width of planar parallax", default=None)


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


@settings
class LoomingConsistencyConfig:
    """Which points belong together, and how little they spread if they are far away."""

    baseline_s: float = setting("time over which points are compared", gt=0.0)
    near_px: float = setting("largest distance between points that belong together", gt=0.0)
    depth_ratio: float = setting("largest difference of their inverse depths, as a share", gt=0.0)
    noise_px: float = setting("standard deviation of a point's motion over the baseline", gt=0.0)
    least_growth: float = setting("least growth, as a share of what the inverse depth predicts", gt=0.0)
    sigmas: float = setting("standard deviations by which the growth must differ", gt=0.0)
    memory_s: float = setting("largest weight of earlier results, as a time", gt=0.0)


@settings
class OncomingConfig:
    """Points that hang in the air before the lanes of oncoming traffic."""

    hangs_m: float = setting("least height", gt=0.0)
    across_m: float = setting("largest distance across of points of one body", gt=0.0)
    lowest_m: float = setting("height above which a point below is no point of the road", gt=0.0)
    along_share: float = setting("share of the depth by which points of one body differ at most", gt=0.0)
    nearest_ratio: float = setting("Least factor by which the vehicle is farther than it seems.", gt=1.0)
    farthest_ratio: float = setting("Largest factor by which the vehicle is farther than it seems.", gt=1.0)


@settings
class StaticObstacleConfig:
    """Thresholds and time constants of the static obstacle tracker."""

    update_period_s: float = setting("between two updates of the points", ge=0.0)
    window_px: int = setting("side of the flow window, for the noise of a track", ge=0)
    min_age_s: float = setting("least age of a track", ge=0.0)
    chi2_limit: float = setting("largest chi2 of a point at its own depth", ge=0.0)
    chi2_margin: float = setting("least excess of the chi2 of a point on the road", ge=0.0)
    depth_ratio: float = setting("largest standard deviation of the depth, as a share of it", ge=0.0)
    min_height_m: float = setting("least height above the road", ge=0.0)
    max_height_m: float = setting("largest height above the road", ge=0.0)
    near_m: float = setting("nearest depth", ge=0.0)
    far_m: float = setting("farthest depth", ge=0.0)
    precise_m: float = setting("farthest depth of low points, and of single ones", ge=0.0)
    sure_sigmas: float = setting("standard deviations of the depth between separate points", ge=0.0)
    hits_s: float = setting("time after which a point is confirmed", ge=0.0)
    hits_share: float = setting("least share of the frames since then in which it was above the road", ge=0.0)
    steady_m: float = setting("Largest change of a point's place in the world; `steady_ratio` adds to it.", ge=0.0)
    steady_ratio: float = setting("Share of the depth that adds to the largest change of a point's place.", ge=0.0)
    memory_s: float = setting("half the time over which hits count", ge=0.0)
    edge_margin_m: float = setting("least distance inside the carriageway's edges", ge=0.0)
    corner_texture: float = setting("texture of a clear corner (small eigenvalue, grey levels^2 / px^2)", ge=0.0)
    corner_ratio: float = setting("least ratio of its eigenvalues: edges have 0.2", ge=0.0)
    foot_m: float = setting("distance from which the road is far, for points whose ray meets it there", ge=0.0)
    link_right_m: float = setting("points nearer than this, across, belong to one obstacle", ge=0.0)
    link_forward_m: float = setting("the same along the road", ge=0.0)
    face_sigma_m: float = setting("largest standard deviation of a reported obstacle's face", ge=0.0)
    reported_m: float = setting("largest distance of a reported obstacle: depth errors grow with its square", ge=0.0)
    beside_m: float = setting("margin added to each reported side", ge=0.0)
    least_width_m: float = setting("least reported width: a cone's base is wider than its stripes", ge=0.0)
    behind_m: float = setting("distance behind the car at which an obstacle is pruned", ge=0.0)
    noise: NoiseModel = setting("noise of the point tracks")
    occlusion: OcclusionConfig = setting("regions that obstacles hide")
    low_tracks: LowTrackConfig = setting("tracks of low obstacles")
    planar_parallax: ParallaxConfig = setting("planar parallax")
    low_obstacles: LowObstacleConfig | None = setting("several low points are an obstacle", default=None)
    looming_consistency: LoomingConsistencyConfig | None = setting("points that expand too little", default=None)
    track_refinement: RefinementConfig | None = setting("points are matched with their first frame", default=None)
    far_road: FarRoadConfig | None = setting("points before far road have less seed weight", default=None)
    dash_seed: DashSeedConfig | None = setting("low points on far lines are no seeds", default=None)
    seed_texture: float | None = setting(
        "least texture of a seed (small eigenvalue, grey levels^2 / px^2): rims of puddles slide", default=None, gt=0.0
    )
    travel_share: float | None = setting(
        "least way since a point's first observation, as a share of its depth: drops look near", default=None, gt=0.0
    )
    recent_motion: RecentMotionConfig | None = setting("a point's last motion must fit its place", default=None)
    oncoming: OncomingConfig | None = setting("points of oncoming traffic are none", default=None)
    split: SplitConfig | None = setting("points behind and beside an obstacle are another", default=None)
    fragment: FragmentConfig | None = setting("fragments behind an obstacle are no obstacles", default=None)
    sharpest: SharpestConfig | None = setting("sides from the points seen from nearest", default=None)
    face_correction: Switch | None = setting("faces are corrected for depth errors", default=None)
