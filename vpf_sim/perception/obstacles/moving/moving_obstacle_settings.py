"""Settings of the moving-object tracker. A section that may be None is a mechanism that a variant can switch off."""

from vpf_sim.configuration import setting, settings

Pair = tuple[float, float]


@settings
class ExtentConfig:
    """How points bound the sides of a vehicle."""

    narrowest_m: float = setting("width of a vehicle with its mirrors, at least", gt=0.0)
    widest_m: float = setting("width of a vehicle, at most", gt=0.0)
    width_sigma_m: float = setting("standard deviation of the width above the narrowest", gt=0.0)
    blur_m: float = setting("Standard deviation of a silhouette's edge.", gt=0.0)
    blur_rad: float = setting("Standard deviation of a silhouette's edge as an angle, in addition.", ge=0.0)
    stray: float = setting("share of a vehicle's points that seem to lie elsewhere", gt=0.0, lt=1.0)
    sigma_m: float = setting("of the middle of a new track", gt=0.0)
    least_sigma_m: float = setting("of the middle of a well-seen vehicle", gt=0.0)
    drift_mps: float = setting("noise of the middle across the course, over a second", ge=0.0)
    cap: float = setting("largest log-odds of one point", gt=0.0)
    flank_m: float | None = setting("length of the side turned to the camera; none: no flank", default=None, gt=0.0)
    through: float | None = setting("share of the background seen in the outline; none: no bound", default=None, gt=0.0)
    window_rad: float | None = setting("points nearer across count as one; none: all count", default=None, gt=0.0)


@settings
class FilterConfig:
    """Noise of the measurements and of the vehicle's own driving."""

    foot_height_m: float = setting("of the lowest points that can be tracked", ge=0.0)
    foot_px: float = setting("standard deviation of the foot's image row", ge=0.0)
    foot_ratio: float = setting("standard deviation of the foot's depth, as a share of it", ge=0.0)
    acceleration_mps2: float = setting("process noise of the speed, over a second", ge=0.0)
    slip_mps: float = setting("process noise of the range, over a second", ge=0.0)
    face_m: float = setting("mean depth of the tracked points behind the face")
    face_sigma_m: float = setting("standard deviation of that depth", gt=0.0)
    turn_rad: float = setting("standard deviation of the course", gt=0.0)
    track_sigma_mps: float = setting("standard deviation of the speed by one point track", gt=0.0)
    least_sigma_mps: float = setting("Least standard deviation of the speed.", gt=0.0)
    most_sigma_mps: float = setting("Largest standard deviation of the speed.", gt=0.0)
    speed_share: float = setting("of the speed's standard deviation that adds to the range's, per second", ge=0.0)
    range_ratio: float = setting("standard deviation of a new track's range, as a share of it", gt=0.0)
    side_s: float = setting("time constant of the observed width", gt=0.0)
    nearest_m: float = setting("range from which the sides are observed", gt=0.0)
    chi2_limit: float = setting("of a point track that fits a hypothesis", gt=0.0)
    hidden_foot: float | None = setting("factor of a foot's sigma beyond a confirmed face", default=None, ge=1.0)
    memory_s: float | None = setting("observations of the same points within this count once", default=None, gt=0.0)
    extent: ExtentConfig | None = setting("filter of middle and width; none: a low-pass of the sides", default=None)


@settings
class ContrastConfig:
    """Contrast as evidence. Contrasts are logarithms of squared gradients, 0 is that of upright objects."""

    weight: float = setting("log-odds per unit of contrast of the upper quartile", ge=0.0)
    wet_faint: float = setting("contrast below which points speak against a track, on a wet road")
    dry_faint: Pair = setting(
        "Contrast below which points speak against a track on a dry road, near and far: far points may be asphalt."
    )
    faint_m: Pair = setting("the depths that near and far mean")


@settings
class EvidenceConfig:
    """Log-odds that the points of one observation give a track."""

    cap: float = setting("chi2 of a point track that no hypothesis explains", gt=0.0)
    speaks_for: float = setting("log-odds of a point from which it speaks for the track", gt=0.0)
    speaks_against: float = setting("log-odds of a point from which it speaks against the track", gt=0.0)
    low_m: float = setting("lowest height of points that belong to the vehicle alone")
    high_m: float = setting("highest height of points that belong to the vehicle alone")
    per_for: float = setting("log-odds per ln(1 + number of points for)", ge=0.0)
    per_against: float = setting("log-odds per ln(1 + number of points against)", ge=0.0)
    per_other: float = setting("log-odds per ln(1 + number of undecided points)", ge=0.0)
    least: float = setting("log-odds of one observation, at least, as without an upright face", lt=0.0)
    most: float = setting("log-odds of one observation, at most", gt=0.0)
    transparency: float | None = setting("least ratio of points for the track to those against", default=None, gt=0.0)
    contrast: ContrastConfig | None = setting(
        "contrast: faint points, as of mirror images, speak against", default=None
    )


@settings
class ReflectivityConfig:
    """Estimate of how far the road mirrors, by the share of its points that seem to lie below it."""

    dry_share: float = setting("Share of these points on a dry road.", ge=0.0)
    wet_share: float = setting("Share of these points on a mirroring road.", gt=0.0)
    memory_s: float = setting("time constant", gt=0.0)


@settings
class MirrorImageConfig:
    """A vehicle's own mirror image. Contrasts as in `ContrastConfig`."""

    wet: float = setting("contrast below which points belong to the image, on a wet road")
    dry: float = setting("contrast below which points belong to the image, on a dry road")
    fainter: float = setting("contrast of a faint vehicle's image below the vehicle's own", ge=0.0)
    above_m: float = setting("height from which points are the vehicle's own, not its image's")
    ramp: float = setting("contrast over which a faint vehicle is told from an image", gt=0.0)


@settings
class ShapeConfig:
    """Shape of a vehicle's face."""

    least_height_m: float = setting("from its lowest to its highest point", ge=0.0)
    least_width_m: float = setting("observed width", ge=0.0)
    foot_m: float = setting("its lowest point is not higher", gt=0.0)


@settings
class MergingConfig:
    """When two tracks are one vehicle."""

    speed_mps: float = setting("largest difference of their speeds", gt=0.0)
    beside_m: float = setting("largest gap between their sides", ge=0.0)
    predicted_m: float = setting("largest distance across where the surer one is predicted", ge=0.0)


@settings
class MovingObstacleConfig:
    """When points move, how many make a vehicle, and how long its track is kept."""

    search_s: float = setting("period of the search for new tracks", gt=0.0)
    look_s: float = setting("period of the observations of tracks", gt=0.0)
    chi2_margin: float = setting("by which the road must fit a moving point worse", ge=0.0)
    chi2_ratio: float = setting("largest ratio of a moving point's chi2 as a standing one to that as road", ge=0.0)
    odds: float = setting("chi2 by which a point may fit the track worse than the standing scene", ge=0.0)
    below_ratio: float = setting("of the road's inverse depth, by which a moving point lies below the road", ge=0.0)
    least_baseline_m: float = setting("own way since the first sighting of a point", gt=0.0)
    least_drop: float = setting("tangent below the horizon of moving points", gt=0.0)
    near_m: float = setting("range of depth in which tracks begin", gt=0.0)
    far_m: float = setting("range of depth in which tracks begin, and to which they are kept behind us", gt=0.0)
    slow_mps: float = setting("speed of a new track, at least", ge=0.0)
    fast_mps: float = setting("speed of a new track, at most", gt=0.0)
    most_tentative: int = setting("tentative tracks at a time", ge=0)
    least_points: int = setting("moving points that start a search", ge=1)
    least_members: int = setting("points of a new track, or of an observation that speaks for one", ge=1)
    side_quantile: float = setting("of the face's points, that is its side", ge=0.0, lt=0.5)
    follow_m: float = setting("nearer than this a vehicle reaches beyond the image and is predicted", ge=0.0)
    follow_bearing: float = setting("tangent beyond which a vehicle is predicted", gt=0.0)
    link_m: float = setting("half the width of a candidate's outline", gt=0.0)
    foot_ratio: float = setting("a candidate's points lie below its foot by this ratio of the drop, at most", ge=1.0)
    half_width_m: float = setting("Half of the width of a narrow vehicle.", gt=0.0)
    speed_sigma_mps: float = setting("standard deviation of a new track's speed", gt=0.0)
    speed_sigma_ratio: float = setting(
        "Standard deviation of the speed that adds to it, as a share of the vehicle's closing speed.", ge=0.0
    )
    glass_m: float = setting("depth below the camera from which up windows show the background")
    alike_ratio: float = setting("of the inverse depth, by which the points of a candidate may differ", ge=0.0)
    slowest_share: float = setting("largest closing speed of a candidate, as a share of the own speed", gt=0.0)
    as_fast_share: float = setting("of the own speed: vehicles as fast seem to stick to the windscreen", ge=0.0)
    length_m: float = setting("Length of a vehicle.", gt=0.0)
    steep_m: float = setting("nearer than this the road is seen too steeply to mirror", ge=0.0)
    edge_margin_m: float = setting("inside the carriageway's edges is the middle of a vehicle")
    margin_m: float = setting("about the outline of a track", ge=0.0)
    margin_ratio: float = setting("Margin about a track's outline that adds to it, as a share of its depth.", ge=0.0)
    below_road: float = setting("lower end of an outline, in heights of the camera", ge=1.0)
    about_m: float = setting("beyond that margin, where its sides are searched", ge=0.0)
    tallest_m: float = setting("Largest height of a vehicle.", gt=0.0)
    independent_s: float = setting("observations this far apart count in full", gt=0.0)
    confirmed: float = setting("log-odds from which a track is confirmed")
    most: float = setting("log-odds, at most; below the negative a tentative track is pruned", gt=0.0)
    vague_m: float = setting("standard deviation of the range from which a track is pruned", gt=0.0)
    filter: FilterConfig = setting("of a track's state")
    evidence: EvidenceConfig = setting("of one observation")
    merging: MergingConfig = setting("of tracks of one vehicle")
    prior: float | None = setting("log-odds of a new track; none: even odds", default=None, le=0.0)
    decay_per_s: float | None = setting("log-odds lost while a track cannot be observed", default=None, ge=0.0)
    mask: float | None = setting("log-odds from which a track's points are not for static obstacles", default=None)
    mirrored_place_m: float | None = setting(
        "range of the road on which a mirrored object stands", default=None, gt=0.0
    )
    reflectivity: ReflectivityConfig | None = setting("how far the road mirrors; none: it always mirrors", default=None)
    mirror_image: MirrorImageConfig | None = setting("reject points as faint as a vehicle's own image", default=None)
    shape: ShapeConfig | None = setting("only an upright face as wide as a vehicle speaks for a track", default=None)
