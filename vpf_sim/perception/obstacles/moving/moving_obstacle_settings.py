"""Settings of the moving-object tracker."""

from vpf_sim.configuration import setting, settings

Pair = tuple[float, float]


@settings
class ExtentConfig:
    """How points bound the sides of a vehicle."""

    narrowest_m: float = setting("Least width of a vehicle with its mirrors.", gt=0.0)
    widest_m: float = setting("Largest width of a vehicle.", gt=0.0)
    width_sigma_m: float = setting("Standard deviation of the width above the narrowest.", gt=0.0)
    blur_m: float = setting("Standard deviation of a silhouette's edge.", gt=0.0)
    blur_rad: float = setting("Standard deviation of a silhouette's edge as an angle, in addition.", ge=0.0)
    stray: float = setting("Share of a vehicle's points that are outliers.", gt=0.0, lt=1.0)
    sigma_m: float = setting("Standard deviation of the middle of a new track.", gt=0.0)
    least_sigma_m: float = setting("Standard deviation of the middle of a well observed vehicle.", gt=0.0)
    drift_mps: float = setting("Noise of the middle across the course, over a second.", ge=0.0)
    cap: float = setting("Largest log-odds of one point.", gt=0.0)
    flank_m: float = setting("Length of the side turned to the camera.", gt=0.0)
    through: float = setting("Share of the background that is visible within the outline.", gt=0.0)
    window_rad: float = setting("Angle across below which points count as one.", gt=0.0)


@settings
class FilterConfig:
    """Noise of the measurements and of the vehicle's own driving."""

    foot_height_m: float = setting("Height of the lowest points that can be tracked.", ge=0.0)
    foot_px: float = setting("Standard deviation of the foot's image row.", ge=0.0)
    foot_ratio: float = setting("Standard deviation of the foot's depth, as a share of it.", ge=0.0)
    acceleration_mps2: float = setting("Process noise of the speed, over a second.", ge=0.0)
    slip_mps: float = setting("Process noise of the range, over a second.", ge=0.0)
    face_m: float = setting("Mean depth of the tracked points behind the face.")
    face_sigma_m: float = setting("Standard deviation of the depth of the tracked points behind the face.", gt=0.0)
    turn_rad: float = setting("Standard deviation of the course.", gt=0.0)
    track_sigma_mps: float = setting("Standard deviation of the speed by one point track.", gt=0.0)
    least_sigma_mps: float = setting("Least standard deviation of the speed.", gt=0.0)
    most_sigma_mps: float = setting("Largest standard deviation of the speed.", gt=0.0)
    speed_share: float = setting("Share of the speed's standard deviation that adds to the range's per second.", ge=0.0)
    range_ratio: float = setting("Standard deviation of a new track's range, as a share of it.", gt=0.0)
    side_s: float = setting("Time constant of the observed width.", gt=0.0)
    nearest_m: float = setting("Range from which the sides are observed.", gt=0.0)
    chi2_limit: float = setting("Largest chi2 of a point track that fits a hypothesis.", gt=0.0)
    hidden_foot: float = setting("Factor of a foot's sigma beyond a confirmed face.", ge=1.0)
    memory_s: float = setting("Time within which observations of the same points count once.", gt=0.0)
    extent: ExtentConfig = setting("Filter of middle and width.")


@settings
class ContrastConfig:
    """Contrast as evidence. Contrasts are logarithms of squared gradients, 0 is that of upright objects."""

    weight: float = setting("Log-odds per unit of contrast of the upper quartile.", ge=0.0)
    wet_faint: float = setting("Contrast below which points speak against a track, on a wet road.")
    dry_faint: Pair = setting(
        "Contrast below which points speak against a track on a dry road, near and far: far points may be asphalt."
    )
    faint_m: Pair = setting("The depths that near and far mean in `dry_faint`.")


@settings
class EvidenceConfig:
    """Log-odds that the points of one observation give a track."""

    cap: float = setting("Chi2 of a point track that no hypothesis explains.", gt=0.0)
    speaks_for: float = setting("Log-odds of a point from which it speaks for the track.", gt=0.0)
    speaks_against: float = setting("Log-odds of a point from which it speaks against the track.", gt=0.0)
    low_m: float = setting("Lowest height of points that belong to the vehicle alone.")
    high_m: float = setting("Highest height of points that belong to the vehicle alone.")
    per_for: float = setting("Log-odds per ln(1 + number of points for a track).", ge=0.0)
    per_against: float = setting("Log-odds per ln(1 + number of points against a track).", ge=0.0)
    per_other: float = setting("Log-odds per ln(1 + number of undecided points).", ge=0.0)
    least: float = setting("Least log-odds of one observation, as without an upright face.", lt=0.0)
    most: float = setting("Largest log-odds of one observation.", gt=0.0)
    transparency: float = setting("Least ratio of points for the track to those against.", gt=0.0)
    contrast: ContrastConfig = setting("Counts faint points, as of mirror images, against a track.")


@settings
class ReflectivityConfig:
    """Estimate of how far the road mirrors, by the share of its points that seem to lie below it."""

    dry_share: float = setting("Share of these points on a dry road.", ge=0.0)
    wet_share: float = setting("Share of these points on a mirroring road.", gt=0.0)
    memory_s: float = setting("Time constant of the road's reflectivity.", gt=0.0)


@settings
class MirrorImageConfig:
    """A vehicle's own mirror image. Contrasts as in `ContrastConfig`."""

    wet: float = setting("Contrast below which points belong to the mirror image, on a wet road.")
    dry: float = setting("Contrast below which points belong to the mirror image, on a dry road.")
    fainter: float = setting("Contrast of a faint vehicle's image below the vehicle's own.", ge=0.0)
    above_m: float = setting("Height from which points are the vehicle's own, not its image's.")
    ramp: float = setting("Range of contrast over which a faint vehicle is distinguished from a mirror image.", gt=0.0)


@settings
class ShapeConfig:
    """Shape of a vehicle's face."""

    least_height_m: float = setting("Least height of a face, from its lowest to its highest point.", ge=0.0)
    least_width_m: float = setting("Least observed width of a face.", ge=0.0)
    foot_m: float = setting("Largest height of a face's lowest point.", gt=0.0)


@settings
class MergingConfig:
    """When two tracks are one vehicle."""

    speed_mps: float = setting("Largest difference in speed of two tracks of one vehicle.", gt=0.0)
    beside_m: float = setting("Largest gap between the sides of two tracks of one vehicle.", ge=0.0)
    predicted_m: float = setting(
        "Largest distance across of a track that is merged with a surer one while that is predicted.", ge=0.0
    )


@settings
class MovingObstacleConfig:
    """When points move, how many make a vehicle, and how long its track is kept."""

    search_s: float = setting("Period of the search for new tracks.", gt=0.0)
    look_s: float = setting("Period of the observations of tracks.", gt=0.0)
    chi2_margin: float = setting("Excess of chi2 by which the road fits a moving point worse.", ge=0.0)
    chi2_ratio: float = setting("Largest ratio of a moving point's chi2 as a standing one to that as road.", ge=0.0)
    odds: float = setting("Chi2 by which a point may fit the track worse than the standing scene.", ge=0.0)
    below_ratio: float = setting(
        "Share of the road's inverse depth by which a moving point lies below the road.", ge=0.0
    )
    least_baseline_m: float = setting("Least distance travelled since the first observation of a point.", gt=0.0)
    least_drop: float = setting("Least tangent of the angle below the horizon of moving points.", gt=0.0)
    near_m: float = setting("Least depth at which tracks begin.", gt=0.0)
    far_m: float = setting(
        "Largest depth at which tracks begin, and distance behind the car to which they are kept.", gt=0.0
    )
    slow_mps: float = setting("Least speed of a new track.", ge=0.0)
    fast_mps: float = setting("Largest speed of a new track.", gt=0.0)
    most_tentative: int = setting("Largest number of tentative tracks at a time.", ge=0)
    least_points: int = setting("Least number of moving points that start a search.", ge=1)
    least_members: int = setting("Least number of points of a new track, or of an observation that supports one.", ge=1)
    side_quantile: float = setting("Quantile of the face's points that is its side.", ge=0.0, lt=0.5)
    follow_m: float = setting("Depth below which a vehicle reaches beyond the image and is predicted.", ge=0.0)
    follow_bearing: float = setting("Tangent of the bearing beyond which a vehicle is predicted.", gt=0.0)
    link_m: float = setting("Half the width of a candidate's outline.", gt=0.0)
    foot_ratio: float = setting("Largest ratio of the drop by which a candidate's points lie below its foot.", ge=1.0)
    half_width_m: float = setting("Half of the width of a narrow vehicle.", gt=0.0)
    speed_sigma_mps: float = setting("Standard deviation of a new track's speed.", gt=0.0)
    speed_sigma_ratio: float = setting(
        "Standard deviation of the speed that adds to it, as a share of the vehicle's closing speed.", ge=0.0
    )
    glass_m: float = setting("Depth below the camera above which windows show the background.")
    alike_ratio: float = setting("Share of the inverse depth by which the points of a candidate may differ.", ge=0.0)
    slowest_share: float = setting("Largest closing speed of a candidate, as a share of the own speed.", gt=0.0)
    as_fast_share: float = setting(
        "Share of the own speed from which vehicles seem to stick to the windscreen.", ge=0.0
    )
    length_m: float = setting("Length of a vehicle.", gt=0.0)
    steep_m: float = setting("Depth below which the road is viewed too steeply to mirror.", ge=0.0)
    edge_margin_m: float = setting("Least distance of a vehicle's middle inside the carriageway's edges.")
    margin_m: float = setting("Margin about the outline of a track.", ge=0.0)
    margin_ratio: float = setting("Margin about a track's outline that adds to it, as a share of its depth.", ge=0.0)
    below_road: float = setting("Lower end of an outline, in heights of the camera.", ge=1.0)
    about_m: float = setting("Distance beyond that margin in which the sides of a track are searched.", ge=0.0)
    tallest_m: float = setting("Largest height of a vehicle.", gt=0.0)
    independent_s: float = setting("Time between observations that count in full.", gt=0.0)
    confirmed: float = setting("Log-odds from which a track is confirmed.")
    most: float = setting("Largest log-odds; below the negative value a tentative track is pruned.", gt=0.0)
    vague_m: float = setting("Standard deviation of the range from which a track is pruned.", gt=0.0)
    filter: FilterConfig = setting("Filter of a track's state.")
    evidence: EvidenceConfig = setting("Evidence of one observation.")
    merging: MergingConfig = setting("Merging of several tracks of one vehicle.")
    prior: float = setting("Log-odds of a new track.", le=0.0)
    decay_per_s: float = setting("Log-odds lost while a track cannot be observed.", ge=0.0)
    mask: float = setting("Log-odds from which the points of a track are not used for static obstacles.")
    mirrored_place_m: float = setting("Range of the road on which a mirrored object stands.", gt=0.0)
    reflectivity: ReflectivityConfig = setting("Estimate of how far the road mirrors.")
    mirror_image: MirrorImageConfig = setting("Rejects points as faint as a vehicle's own mirror image.")
    shape: ShapeConfig = setting("Lets only an upright face as wide as a vehicle support a track.")
