"""Settings of static obstacles."""

from vpf_sim.configuration import setting, settings
from vpf_sim.perception.egomotion.egomotion_settings import NoiseModel
from vpf_sim.perception.obstacles.planar_parallax.low_obstacle_settings import LowTrackConfig, ParallaxConfig


@settings
class FarRoadConfig:
    """Seed weight of points whose ray meets the road far away, or not at all: lines slide in bends."""

    share: float = setting("Seed weight that a clear corner keeps.", ge=0.0, lt=1.0)


@settings
class DashSeedConfig:
    """Low points on a line, farther than `precise_m`, are no seeds: ends of dashes slide."""

    height_m: float = setting("Height below which points on far lines count as low.", ge=0.0)


@settings
class RecentMotionConfig:
    """A point's motion over the last window must fit its place: a track may slip on to something else."""

    error_px: float = setting("Largest error of the motion; `ratio` adds to it.", ge=0.0)
    ratio: float = setting("Share of the motion's length that adds to its largest error.", ge=0.0)


@settings
class SplitConfig:
    """Points behind an obstacle's face and beside it are another obstacle."""

    step_m: float = setting("Least distance of another obstacle behind the face, beside `sure_sigmas`.", ge=0.0)
    beside_m: float = setting("Least distance of another obstacle beside the points at the face.", ge=0.0)


@settings
class SharpestConfig:
    """The points seen from nearest define a side, others only if they lie farther out than their blur explains."""

    points: int = setting("Number of points that define how sharp an obstacle is known.", ge=1)
    ratio: float = setting("Largest blur, as a multiple of that of these points.", ge=1.0)
    blurs: float = setting("Least distance of another point farther out, in its own blur.", ge=0.0)


@settings
class FragmentConfig:
    """A smaller cluster of the same obstacle behind it, hidden by it or in line with it, is no obstacle."""

    behind_m: float = setting("Distance behind an obstacle from which a cluster is a fragment.", ge=0.0)
    length_m: float = setting("Distance behind an obstacle up to which a cluster in line is a part of it.", ge=0.0)
    beside_m: float = setting("Largest distance of a cluster in line beside the obstacle.", ge=0.0)
    rim_rad: float = setting("Angle beside an obstacle that counts as occluded.", ge=0.0)


@settings
class NearbyConfig:
    """Region about a point of a taller obstacle in which low points belong to it."""

    along_m: float = setting("Distance along the road within which points belong to a taller obstacle.", gt=0.0)
    across_m: float = setting("Distance across the road within which points belong to a taller obstacle.", gt=0.0)


@settings
class OnTopConfig:
    """Where a taller obstacle may be the upper edge of a wider low one that it overlaps."""

    before_m: float = setting("Largest distance of the low obstacle before the taller one.", ge=0.0)


@settings
class ParallaxMatchConfig:
    """Which low obstacle of planar parallax is the same as one of points."""

    along_m: float = setting("Largest distance along the road to the detection by parallax.", gt=0.0)


@settings
class LowObstacleConfig:
    """When a point counts as low, and how many of them make an obstacle."""

    near_m: float = setting("Nearest depth of a low point.", ge=0.0)
    min_age_s: float = setting("Least age of a track.", ge=0.0)
    min_height_m: float = setting("Least height above the road.", ge=0.0)
    max_height_m: float = setting("Largest height above the road.", ge=0.0)
    sigma_height_m: float = setting("Largest standard deviation of the height.", ge=0.0)
    chi2_margin: float = setting("Least excess of the chi2 of a point on the road.", ge=0.0)
    line_m: float = setting(
        "Distance to a lane line below which points do not count, since ends of dashes slide.", ge=0.0
    )
    line_px: float = setting("Distance in the image that adds to `line_m`: half of the flow window.", ge=0.0)
    edge_m: float = setting("Points within this distance of an edge line do not count.", ge=0.0)
    link_right_m: float = setting("Distance across below which points belong to one obstacle.", ge=0.0)
    link_forward_m: float = setting("Points nearer than this, along the road, belong to one obstacle.", ge=0.0)
    least_texture: float = setting("Least texture of a point (small eigenvalue, grey levels^2 / px^2).", ge=0.0)
    least_points: int = setting("Least number of points of an obstacle.", ge=0)
    least_margin: float = setting("Least sum of the chi2 margins over the points of an obstacle.", ge=0.0)
    most_margin: float = setting("Largest margin that one point adds.", ge=0.0)
    beside_m: float = setting(
        "Distance to a taller obstacle below which points belong to it, unless they stick out.", ge=0.0
    )
    sticks_out_m: float = setting(
        "Distance beyond a taller obstacle's side at which points stick out; the corner of a car's shadow does not.",
        ge=0.0,
    )
    sticks_out_share: float = setting("Share of a narrow obstacle's width by which points stick out beside it.", gt=0.0)
    before_m: float = setting("Distance before a taller obstacle's face at which points stick out.", ge=0.0)
    part: NearbyConfig = setting("Counts points beside a taller obstacle as a part of it.")
    on_top: OnTopConfig = setting("Takes a narrower taller obstacle for the upper edge of a low one.")
    parallax: ParallaxMatchConfig = setting("Takes the width of low points from planar parallax.")


@settings
class RefinementConfig:
    """Which points are matched with the frame of their first observation."""

    near_m: float = setting("Nearest depth of a refined point.", ge=0.0)
    far_m: float = setting("Farthest depth of a refined point; grows with speed, see `reported_s`.", ge=0.0)
    edge_m: float = setting("Largest distance of a refined point outside the carriageway.", ge=0.0)
    least_height_m: float = setting("Least height of a refined point.", ge=0.0)
    most_height_m: float = setting("Largest height of a refined point.", ge=0.0)
    chi2_limit: float = setting("Largest chi2 of a point at its own depth.", ge=0.0)
    chi2_margin: float = setting("Least excess of the chi2 of a point on the road.", ge=0.0)
    road_m: float = setting(
        "Distance to the road along its ray below which a point is matched as a road point, too.", gt=0.0
    )


@settings
class LoomingConsistencyConfig:
    """Which points belong together, and how little they spread if they are far away."""

    baseline_s: float = setting("Time over which points are compared.", gt=0.0)
    near_px: float = setting("Largest distance between points that belong together.", gt=0.0)
    depth_ratio: float = setting("Largest difference of the inverse depths of two points, as a share.", gt=0.0)
    noise_px: float = setting("Standard deviation of a point's motion over the baseline.", gt=0.0)
    least_growth: float = setting("Least growth, as a share of what the inverse depth predicts.", gt=0.0)
    sigmas: float = setting("Standard deviations by which the growth must differ.", gt=0.0)
    memory_s: float = setting("Largest weight of earlier results, as a time.", gt=0.0)


@settings
class OncomingConfig:
    """Points that hang in the air before the lanes of oncoming traffic."""

    hangs_m: float = setting("Least height of a point of oncoming traffic.", gt=0.0)
    across_m: float = setting("Largest distance across between points of one vehicle.", gt=0.0)
    lowest_m: float = setting("Height above which a point below does not belong to the road.", gt=0.0)
    along_share: float = setting(
        "Largest difference in depth between points of one vehicle, as a share of the depth.", gt=0.0
    )
    nearest_ratio: float = setting("Least factor by which the vehicle is farther than it seems.", gt=1.0)
    farthest_ratio: float = setting("Largest factor by which the vehicle is farther than it seems.", gt=1.0)


@settings
class StaticObstacleConfig:
    """Thresholds and time constants of the static obstacle tracker."""

    update_period_s: float = setting("Time between two updates of the points.", ge=0.0)
    min_age_s: float = setting("Least age of a track.", ge=0.0)
    chi2_limit: float = setting("Largest chi2 of a point at its own depth.", ge=0.0)
    chi2_margin: float = setting("Least excess of the chi2 of a point on the road.", ge=0.0)
    depth_ratio: float = setting("Largest standard deviation of the depth, as a share of it.", ge=0.0)
    min_height_m: float = setting("Least height above the road.", ge=0.0)
    max_height_m: float = setting("Largest height above the road.", ge=0.0)
    near_m: float = setting("Nearest depth of a point.", ge=0.0)
    far_m: float = setting("Farthest depth of a point; grows with speed, see `reported_s`.", ge=0.0)
    precise_m: float = setting("Farthest depth of low points, and of single ones.", ge=0.0)
    sure_sigmas: float = setting("Standard deviations of the depth between separate points.", ge=0.0)
    hits_s: float = setting("Time after which a point is confirmed.", ge=0.0)
    hits_share: float = setting(
        "Least share of the frames since its first observation in which a confirmed point was above the road.", ge=0.0
    )
    steady_m: float = setting("Largest change of a point's place in the world; `steady_ratio` adds to it.", ge=0.0)
    steady_ratio: float = setting("Share of the depth that adds to the largest change of a point's place.", ge=0.0)
    memory_s: float = setting("Half of the time over which hits count.", ge=0.0)
    edge_margin_m: float = setting("Least distance of a point inside the carriageway's edges.", ge=0.0)
    corner_texture: float = setting("Texture of a clear corner (small eigenvalue, grey levels^2 / px^2).", ge=0.0)
    corner_ratio: float = setting("Least ratio of the eigenvalues of a clear corner; edges have 0.2.", ge=0.0)
    foot_m: float = setting("Distance from which the road is far, for points whose ray meets it there.", ge=0.0)
    link_right_m: float = setting(
        "Distance across below which points belong to one obstacle; grows with speed, see `reported_s`.", ge=0.0
    )
    link_most_m: float = setting(
        "Most that `link_right_m` grows to, and that of low obstacles: no way leads through a narrower gap.", ge=0.0
    )
    link_forward_m: float = setting("Distance along the road below which points belong to one obstacle.", ge=0.0)
    face_sigma_m: float = setting("Largest standard deviation of a reported obstacle's face.", ge=0.0)
    reported_m: float = setting(
        "Largest distance of a reported obstacle, since depth errors grow with its square; grows with speed.", gt=0.0
    )
    reported_s: float = setting(
        "Time ahead up to which obstacles are reported, where it reaches beyond `reported_m`: from a longer way depths "
        "are known farther. `far_m`, that of `track_refinement` and both `link_right_m` grow alike.",
        ge=0.0,
    )
    beside_m: float = setting("Margin added to each reported side.", ge=0.0)
    least_width_m: float = setting("Least reported width: a cone's base is wider than its stripes.", ge=0.0)
    behind_m: float = setting("Distance behind the car at which an obstacle is pruned.", ge=0.0)
    low_tracks: LowTrackConfig = setting("Tracks of low obstacles.")
    planar_parallax: ParallaxConfig = setting("Detects low obstacles by planar parallax.")
    looming_consistency: LoomingConsistencyConfig = setting("Rejects points that expand too little.")
    track_refinement: RefinementConfig = setting("Matches points again with their first frame.")
    far_road: FarRoadConfig = setting("Gives points before far road less seed weight.")
    dash_seed: DashSeedConfig = setting("Takes no low points on far lines as seeds.")
    seed_texture: float = setting(
        "Least texture of a seed (small eigenvalue, grey levels^2 / px^2), since edges of puddles slide.", gt=0.0
    )
    travel_share: float = setting(
        "Least distance travelled since a point's first observation, as a share of its depth: drops seem near.", gt=0.0
    )
    recent_motion: RecentMotionConfig = setting("Requires that a point's last motion fits its place.")
    oncoming: OncomingConfig = setting("Leaves out points of oncoming traffic.")
    split: SplitConfig = setting("Splits off points behind and beside an obstacle as another one.")
    fragment: FragmentConfig = setting("Drops fragments behind an obstacle.")
    sharpest: SharpestConfig = setting("Takes the sides from the points observed from nearest.")
    noise: NoiseModel = setting("Noise of the point tracks.", default_factory=NoiseModel)
    low_obstacles: LowObstacleConfig | None = setting("Detects low obstacles by several low points.", default=None)

    def range_factor(self, speed_mps: float) -> float:
        """The factor by which `reported_m` and what depends on it grow at a speed, at least 1.

        Far away few points are found, so those of one obstacle lie farther apart.
        """
        return max(1.0, speed_mps * self.reported_s / self.reported_m)
