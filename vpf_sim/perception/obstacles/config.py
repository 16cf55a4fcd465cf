"""Settings of static obstacles and the collision alarm. A section that may be None can be switched off."""

from vpf_sim.configuration import setting, settings
from vpf_sim.perception.egomotion.config import NoiseModel
from vpf_sim.perception.obstacles.planar_parallax.config import LowTrackConfig, ParallaxConfig
from vpf_sim.perception.road.config import OcclusionConfig


@settings
class Switch:
    """A mechanism without settings."""


@settings
class SinglePointConfig:
    """When one point above the road is an obstacle."""

    depth_ratio: tuple[float, float] = setting("relative depth errors of a well and a badly known point")
    min_height_m: tuple[float, float] = setting("least heights of these two: ends of dashes seem to stand 0.3 m high")
    max_height_m: float = setting("largest height", ge=0.0)


@settings
class TurnedConfig:
    """Nearest depth of points while the car is turned: near obstacles show their flanks."""

    near_m: float = setting("nearest depth", ge=0.0)
    angle_rad: float = setting("angle to the road from which the car is turned", ge=0.0)


@settings
class FarRoadConfig:
    """Seed weight of points whose ray meets the road far away, or not at all: lines slide in bends."""

    share: float = setting("seed weight that a clear corner keeps", ge=0.0, lt=1.0)


@settings
class DashSeedConfig:
    """Low points on a line, farther than `precise_m`, are no seeds: ends of dashes slide."""

    height_m: float = setting("height below which they count as low", ge=0.0)


@settings
class SeedTextureConfig:
    """Points of little texture are no seeds: edges of puddles and reflections slide."""

    least: float = setting("least texture (small eigenvalue, grey levels^2 / px^2)", ge=0.0)


@settings
class TravelConfig:
    """The car must have moved since a point's first observation: water on the windscreen looks near."""

    share: float = setting("least travel, as a share of the depth", ge=0.0)


@settings
class RecentMotionConfig:
    """A point's motion over the last window must fit its place: a track may slip on to something else."""

    error_px: float = setting("largest error of the motion, plus", ge=0.0)
    ratio: float = setting("this share of its length", ge=0.0)


@settings
class OutlierConfig:
    """A single point behind an obstacle and beside it defines no side."""

    sigma_m: float = setting("standard deviation of its depth from which it does not", ge=0.0)


@settings
class SplitConfig:
    """Points behind an obstacle's face and beside it are another obstacle."""

    step_m: float = setting("least distance behind the face, and `sure_sigmas`", ge=0.0)
    beside_m: float = setting("least distance beside the points at the face", ge=0.0)
    outlier: OutlierConfig | None = setting("single points there define no side", default=None)


@settings
class FragmentConfig:
    """A smaller cluster of the same obstacle behind it, hidden by it or in line with it, is no obstacle."""

    behind_m: float = setting("distance behind it from which this holds", ge=0.0)
    length_m: float = setting("distance behind it up to which a cluster in line is a part", ge=0.0)
    beside_m: float = setting("largest distance beside it of a cluster in line", ge=0.0)
    rim_rad: float = setting("angle beside it that counts as hidden", ge=0.0)


@settings
class StaleConfig:
    """Points that are not observed again on the way to them are stale."""

    share: float = setting("stale from this share of their last observed depth", ge=0.0, lt=1.0)
    part: Switch | None = setting("a stale cluster before a larger one of the same obstacle is deleted", default=None)
    high: Switch | None = setting("a stale obstacle of high points only is deleted", default=None)


@settings
class SharpSideConfig:
    """Only points that are well known across define an obstacle's sides."""

    sigma_m: float = setting("largest lateral standard deviation of these points", ge=0.0)


@settings
class SharpestConfig:
    """The points seen from nearest define a side, others only if they lie farther out than their blur explains."""

    points: int = setting("number of points that define how sharp an obstacle is known", ge=1)
    ratio: float = setting("largest blur, as a multiple of theirs", ge=1.0)
    blurs: float = setting("least distance of another point farther out, in its own blur", ge=0.0)


@settings
class SideOutlierConfig:
    """The farthest of many points defines no side if all others lie much nearer."""

    points: int = setting("least number of points", ge=2)
    apart_m: float = setting("distance from the next farthest point", ge=0.0)


@settings
class NearCornerConfig:
    """An obstacle begins where several points lie nearer than its face: corners that stand at an angle."""

    points: int = setting("least number of points", ge=1)


@settings
class LowSinglePointConfig:
    """When one low point is an obstacle."""

    margin: float = setting("least excess of its chi2 on the road", ge=0.0)
    texture: float = setting("least texture: asphalt slides", ge=0.0)


@settings
class NearbyConfig:
    """A region beside a taller obstacle."""

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
    width: Switch | None = setting("the obstacle is as wide as planar parallax measures it", default=None)


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
    line_px: float = setting("added to it in the image, half of the flow window", ge=0.0)
    edge_m: float = setting("the same distance for edge lines", ge=0.0)
    link_right_m: float = setting("points nearer than this, across, belong to one obstacle", ge=0.0)
    link_forward_m: float = setting("the same along the road", ge=0.0)
    least_texture: float = setting("least texture of a point (small eigenvalue, grey levels^2 / px^2)", ge=0.0)
    least_points: int = setting("least number of points", ge=0)
    least_margin: float = setting("least sum of the chi2 margins over the points of an obstacle", ge=0.0)
    most_margin: float = setting("largest margin that one point adds", ge=0.0)
    beside_m: float = setting("points this near to a taller obstacle belong to it, unless they stick out", ge=0.0)
    sticks_out_m: float = setting("this far beyond its side: the corner of a car's shadow does not", ge=0.0)
    sticks_out_share: float = setting("or by this share of its width, beside narrow ones", gt=0.0)
    before_m: float = setting("or this far before its face", ge=0.0)
    single_point: LowSinglePointConfig | None = setting("one clear point is an obstacle", default=None)
    part: NearbyConfig | None = setting("points beside one of a taller obstacle belong to it", default=None)
    shadow: NearbyConfig | None = setting("one more point is needed in the shadow of a taller obstacle", default=None)
    on_top: OnTopConfig | None = setting("a narrower taller obstacle is the upper edge of a low one", default=None)
    parallax: ParallaxMatchConfig | None = setting("low points are matched with planar parallax", default=None)


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
class CollisionAlarmConfig:
    """When points in the car's path raise an alarm."""

    bound_s: float = setting("largest time to contact", ge=0.0)
    half_width_m: float = setting("largest distance from the car's path", ge=0.0)
    ceiling_m: float = setting("largest height", ge=0.0)
    least_baseline_m: float = setting("least travel since the point's first observation", ge=0.0)
    chi2_limit: float = setting("largest chi2 of a point at its own depth, plus", ge=0.0)
    chi2_ratio: float = setting("this share of its chi2 on the road", ge=0.0)
    chi2_margin: float = setting("least excess of the chi2 of a point on the road", ge=0.0)
    least_drop: float = setting("least tangent below the horizon", ge=0.0)
    least_depth_m: float = setting("least depth", ge=0.0)
    least_points: int = setting("least number of points that agree", ge=0)
    agree_ratio: float = setting("largest difference of their inverse depths, as a share", ge=0.0)
    least_share: float = setting("least share of all points that alarm", ge=0.0)
    least_width_m: float = setting("least reported width", ge=0.0)
    least_height_m: float = setting("least height", ge=0.0)
    after_s: float = setting("time for which points must alarm", ge=0.0)
    hold_s: float = setting("time for which the alarm lasts without points", ge=0.0)


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
    steady_m: float = setting("largest change of its place in the world, plus", ge=0.0)
    steady_ratio: float = setting("this share of the depth", ge=0.0)
    single_hits_s: float = setting("time after which a single point is; hits count up to twice this time", ge=0.0)
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
    track_refinement: RefinementConfig | None = setting("points are matched with their first frame", default=None)
    single_point: SinglePointConfig | None = setting("one point may be an obstacle", default=None)
    turned: TurnedConfig | None = setting("near points are ignored while the car is turned", default=None)
    far_road: FarRoadConfig | None = setting("points before far road have less seed weight", default=None)
    dash_seed: DashSeedConfig | None = setting("low points on far lines are no seeds", default=None)
    seed_texture: SeedTextureConfig | None = setting("points of little texture are no seeds", default=None)
    travel: TravelConfig | None = setting("points need travel of the car", default=None)
    recent_motion: RecentMotionConfig | None = setting("a point's last motion must fit its place", default=None)
    road_points: Switch | None = setting("observations on the road count against a point", default=None)
    swept: Switch | None = setting("points where a moving obstacle drives are deleted", default=None)
    split: SplitConfig | None = setting("points behind and beside an obstacle are another", default=None)
    fragment: FragmentConfig | None = setting("fragments behind an obstacle are no obstacles", default=None)
    stale: StaleConfig | None = setting("points not observed again are stale", default=None)
    sharp_side: SharpSideConfig | None = setting("sides from points that are well known across", default=None)
    sharpest: SharpestConfig | None = setting("sides from the points seen from nearest", default=None)
    side_outlier: SideOutlierConfig | None = setting("one point far outside many defines no side", default=None)
    face_correction: Switch | None = setting("faces are corrected for depth errors", default=None)
    near_corner: NearCornerConfig | None = setting("obstacles begin at their nearest corner", default=None)
