"""Settings of the filters of one moving track. A section that may be None can be switched off."""

from vpf_sim.configuration import setting, settings


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
