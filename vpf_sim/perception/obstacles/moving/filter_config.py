"""Settings of the filters of one moving track. A section that may be None can be switched off."""

from vpf_sim.configuration import setting, settings


@settings
class FlankConfig:
    """The side of a vehicle that is turned to the camera."""

    length_m: float = setting("of the side, over which its points grow rarer", gt=0.0)


@settings
class BackgroundConfig:
    """Points of what stands behind a vehicle."""

    through: float = setting("share of these points that seem to lie in the silhouette", gt=0.0, lt=1.0)


@settings
class SharedWindowConfig:
    """Points whose flow windows overlap."""

    apart_rad: float = setting("points nearer across than this share a window", gt=0.0)


@settings
class ExtentConfig:
    """How points bound the sides of a vehicle."""

    narrowest_m: float = setting("width of a vehicle with its mirrors, at least", gt=0.0)
    widest_m: float = setting("width of a vehicle, at most", gt=0.0)
    width_sigma_m: float = setting("standard deviation of the width above the narrowest", gt=0.0)
    widths: int = setting("number of width hypotheses", ge=2)
    blur_m: float = setting("of a silhouette's edge", gt=0.0)
    blur_rad: float = setting("of a silhouette's edge, besides", ge=0.0)
    reach_m: float = setting("of the grid of middles, to each side", gt=0.0)
    step_m: float = setting("of the grid of middles", gt=0.0)
    stray: float = setting("share of a vehicle's points that seem to lie elsewhere", gt=0.0, lt=1.0)
    sigma_m: float = setting("of the middle of a new track", gt=0.0)
    least_sigma_m: float = setting("of the middle of a well-seen vehicle", gt=0.0)
    drift_mps: float = setting("noise of the middle across the course, over a second", ge=0.0)
    cap: float = setting("largest log-odds of one point", gt=0.0)
    flank: FlankConfig | None = setting(
        "flank rejection: points of the side turned to the camera do not widen the face", default=None
    )
    background: BackgroundConfig | None = setting(
        "background bounds: points of what stands behind bound the silhouette from outside", default=None
    )
    shared_window: SharedWindowConfig | None = setting(
        "shared windows: points whose flow windows overlap count as one", default=None
    )

    def __post_init__(self) -> None:
        if not self.narrowest_m < self.widest_m:
            raise ValueError(f"narrowest_m: expected < widest_m = {self.widest_m}, got {self.narrowest_m}")


@settings
class HiddenFootConfig:
    """A lowest point that lies beyond the face of a confirmed vehicle."""

    sigma_ratio: float = setting("factor of its standard deviation", ge=1.0)


@settings
class InnovationConfig:
    """Limit of one correction of the range."""

    clip_sigma: float = setting("largest innovation, in standard deviations", gt=0.0)


@settings
class SideDriftConfig:
    """Growth of the reported width while the sides are not observed."""

    rate_mps: float = setting("of each side", ge=0.0)
    most_m: float = setting("of each side: a vehicle keeps its lane", ge=0.0)


@settings
class CorrelationConfig:
    """Correlation of consecutive observations."""

    memory_s: float = setting("observations of the same tracks within this time count once", gt=0.0)


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
    least_sigma_mps: float = setting("of the speed, at least", gt=0.0)
    most_sigma_mps: float = setting("of the speed, at most", gt=0.0)
    speed_share: float = setting("of the speed's standard deviation that adds to the range's, per second", ge=0.0)
    range_ratio: float = setting("standard deviation of a new track's range, as a share of it", gt=0.0)
    side_s: float = setting("time constant of the observed width", gt=0.0)
    nearest_m: float = setting("range from which the sides are observed", gt=0.0)
    chi2_limit: float = setting("of a point track that fits a hypothesis", gt=0.0)
    hidden_foot: HiddenFootConfig | None = setting(
        "hidden foot: a foot beyond a confirmed vehicle's face counts less, since its lowest point need not be seen",
        default=None,
    )
    innovation: InnovationConfig | None = setting(
        "innovation limit: one foot moves the range by a few standard deviations at most", default=None
    )
    side_drift: SideDriftConfig | None = setting(
        "side drift: a vehicle whose sides are not observed is reported wider and wider", default=None
    )
    correlation: CorrelationConfig | None = setting(
        "correlation in time: observations of the same tracks in a row count less", default=None
    )
    extent: ExtentConfig | None = setting(
        "silhouette bounds: a Bayesian filter of middle and width; none: a low-pass of the face's outermost points",
        default=None,
    )
