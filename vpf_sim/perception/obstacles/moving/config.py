"""Settings of the moving-object tracker. A section that may be None is a mechanism that a variant can switch off."""

from vpf_sim.configuration import setting, settings
from vpf_sim.perception.egomotion.config import NoiseModel
from vpf_sim.perception.obstacles.config import CollisionAlarmConfig
from vpf_sim.perception.obstacles.moving.filter_config import FilterConfig

Pair = tuple[float, float]


@settings
class TransparencyConfig:
    """Road that shines through a track's outline."""

    least_share: float = setting("least ratio of points for the track to points against it", gt=0.0)


@settings
class ContrastConfig:
    """Contrast as evidence. Contrasts are logarithms of squared gradients, 0 is that of upright objects."""

    weight: float = setting("log-odds per unit of contrast of the upper quartile", ge=0.0)
    wet_faint: float = setting("contrast below which points speak against a track, on a wet road")
    dry_faint: Pair = setting("the same on a dry road, near and far: far points may be asphalt")
    faint_m: Pair = setting("the depths that near and far mean")

    def __post_init__(self) -> None:
        if not self.faint_m[0] < self.faint_m[1]:
            raise ValueError(f"faint_m: expected two increasing distances, got {self.faint_m}")


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
    least: float = setting("log-odds of one observation, at least", lt=0.0)
    most: float = setting("log-odds of one observation, at most", gt=0.0)
    transparency: TransparencyConfig | None = setting(
        "transparency: an outline that the standing scene shines through is no vehicle", default=None
    )
    contrast: ContrastConfig | None = setting(
        "contrast evidence: faint points speak against a track, since mirror images are faint", default=None
    )


@settings
class ReflectivityConfig:
    """Estimate of how far the road mirrors, by the share of its points that seem to lie below it."""

    dry_share: float = setting("of these points on a dry road", ge=0.0)
    wet_share: float = setting("of these points on a mirroring road", gt=0.0)
    memory_s: float = setting("time constant", gt=0.0)

    def __post_init__(self) -> None:
        if not self.dry_share < self.wet_share:
            raise ValueError(f"dry_share: expected < wet_share = {self.wet_share}, got {self.dry_share}")


@settings
class MirrorImageConfig:
    """A vehicle's own mirror image. Contrasts as in `ContrastConfig`."""

    wet: float = setting("contrast below which points belong to the image, on a wet road")
    dry: float = setting("contrast below which points belong to the image, on a dry road")
    fainter: float = setting("contrast of a faint vehicle's image below the vehicle's own", ge=0.0)
    above_m: float = setting("height from which points are the vehicle's own, not its image's")
    ramp: float = setting("contrast over which a faint vehicle is told from an image", gt=0.0)

    def __post_init__(self) -> None:
        if not self.dry < self.wet:
            raise ValueError(f"dry: expected < wet = {self.wet}, got {self.dry}")


@settings
class MirroredPlaceConfig:
    """Where an object would stand whose mirror image looks like the track."""

    far_m: float = setting("range up to which the road is known well enough", gt=0.0)


@settings
class CandidateContrastConfig:
    """Weight of a point in the choice between candidates."""

    contrast: Pair = setting("from which a point counts least, and in full")
    least: float = setting("least weight", gt=0.0, le=1.0)

    def __post_init__(self) -> None:
        if not self.contrast[0] < self.contrast[1]:
            raise ValueError(f"contrast: expected two increasing contrasts, got {self.contrast}")


@settings
class ContradictionConfig:
    """Points in a candidate's outline that do not move as it does."""

    stray: float = setting("weight of a point that no hypothesis explains, relative to one that stands", ge=0.0)


@settings
class ShapeConfig:
    """Shape of a vehicle's face."""

    least_height_m: float = setting("from its lowest to its highest point", ge=0.0)
    least_width_m: float = setting("observed width", ge=0.0)
    foot_m: float = setting("its lowest point is not higher", gt=0.0)


@settings
class ThicknessConfig:
    """Spread of a tentative track's points about a straight line."""

    least_m: float = setting("root mean square distance", ge=0.0)


@settings
class LeastSpeedConfig:
    """Speed of a tentative track."""

    least_mps: float = setting("speed", ge=0.0)


@settings
class EqualSpeedConfig:
    """Closing speeds near 0, as a share of the own speed."""

    closing: float = setting("a tentative track closes in by more,", gt=0.0)
    receding: float = setting("or falls back by more", gt=0.0)


@settings
class EdgeLineConfig:
    """A strip about an edge line."""

    inside_m: float = setting("of the line", ge=0.0)
    outside_m: float = setting("of the line", ge=0.0)


@settings
class CarriagewayConfig:
    """Place of a track across the road."""

    outside_m: float = setting("a track farther outside the edges is pruned", ge=0.0)


@settings
class MergingConfig:
    """When two tracks are one vehicle."""

    speed_mps: float = setting("largest difference of their speeds", gt=0.0)
    beside_m: float = setting("largest gap between their sides", ge=0.0)
    predicted_m: float = setting("largest distance across where the surer one is predicted", ge=0.0)


@settings
class PatienceConfig:
    """Evidence against a confirmed track."""

    most: float = setting("log-odds of one observation against it", ge=0.0)


@settings
class CreditConfig:
    """Log-odds of a confirmed track that leaves the image."""

    log_odds: float = setting("that a track keeps once it had more", gt=0.0)


@settings
class DecayConfig:
    """Loss of confidence while a track cannot be observed."""

    per_s: float = setting("log-odds", ge=0.0)


@settings
class PriorConfig:
    """Confidence of a new track."""

    log_odds: float = setting("of a new track", le=0.0)


@settings
class MaskConfig:
    """Points that the static obstacle tracker must not use."""

    log_odds: float = setting("from which the points of a track are masked")


@settings
class MovingObstacleConfig:
    """When points move, how many make a vehicle, and how long its track is kept."""

    window_px: int = setting("of the optical flow, for the noise of a point track", gt=0)
    search_s: float = setting("period of the search for new tracks", gt=0.0)
    look_s: float = setting("period of the observations of tracks", gt=0.0)
    chi2_margin: float = setting("by which the road must fit a moving point worse", ge=0.0)
    chi2_ratio: float = setting("largest ratio of a moving point's chi2 as a standing one to that as road", ge=0.0)
    odds: float = setting("chi2 by which a point may fit the track worse than the standing scene", ge=0.0)
    below_ratio: float = setting("of the road's inverse depth, by which a moving point lies below the road", ge=0.0)
    least_baseline_m: float = setting("own way since the first sighting of a point", gt=0.0)
    least_drop: float = setting("tangent below the horizon of moving points", gt=0.0)
    near_m: float = setting("range of depth in which tracks begin", gt=0.0)
    far_m: float = setting("range of depth in which tracks begin", gt=0.0)
    slow_mps: float = setting("speed of a new track, at least", ge=0.0)
    fast_mps: float = setting("speed of a new track, at most", gt=0.0)
    least_upright: int = setting("points above the horizon that the reference contrast needs", ge=0)
    most_tentative: int = setting("tentative tracks at a time", ge=0)
    least_points: int = setting("moving points that start a search", ge=1)
    least_members: int = setting("points of a new track, or of an observation that speaks for one", ge=1)
    front_m: float = setting("points nearer behind the face than this show its width")
    side_quantile: float = setting("of the face's points, that is its side", ge=0.0, lt=0.5)
    follow_m: float = setting("nearer than this a vehicle reaches beyond the image and is predicted", ge=0.0)
    follow_bearing: float = setting("tangent beyond which a vehicle is predicted", gt=0.0)
    link_m: float = setting("half the width of a candidate's outline", gt=0.0)
    foot_side_m: float = setting("from a candidate's middle to a foot at its side", ge=0.0)
    foot_ratio: float = setting("a candidate's points lie below its foot by this ratio of the drop, at most", ge=1.0)
    least_half_m: float = setting("half the width of a new track, at least", gt=0.0)
    speed_sigma_mps: float = setting("standard deviation of a new track's speed", gt=0.0)
    speed_sigma_ratio: float = setting("the same besides, as a share of its closing speed", ge=0.0)
    glass_m: float = setting("depth below the camera from which up windows show the background")
    alike_ratio: float = setting("of the inverse depth, by which the points of a candidate may differ", ge=0.0)
    slowest_share: float = setting("largest closing speed of a candidate, as a share of the own speed", gt=0.0)
    as_fast_share: float = setting(
        "of the own speed: a vehicle whose speed differs by less seems to stick to the windscreen", ge=0.0
    )
    length_m: float = setting("of a vehicle", gt=0.0)
    nearest_m: float = setting("depth from which a vehicle beside the camera is in the image", gt=0.0)
    steep_m: float = setting("nearer than this the road is seen too steeply to mirror", ge=0.0)
    edge_margin_m: float = setting("inside the carriageway's edges is the middle of a vehicle")
    margin_m: float = setting("about the outline of a track", ge=0.0)
    margin_ratio: float = setting("about the outline of a track besides, as a share of its depth", ge=0.0)
    below_road: float = setting("lower end of an outline, in heights of the camera", ge=1.0)
    about_m: float = setting("beyond that margin, where its sides are searched", ge=0.0)
    tallest_m: float = setting("of a vehicle", gt=0.0)
    dropped: float = setting("log-odds below which a tentative track is pruned", lt=0.0)
    speaks_against: float = setting("log-odds against a track by an observation without an upright face", ge=0.0)
    independent_s: float = setting("observations this far apart count in full", gt=0.0)
    confirmed: float = setting("log-odds from which a track is confirmed")
    most: float = setting("log-odds, at most")
    vague_m: float = setting("standard deviation of the range from which a track is pruned", gt=0.0)
    behind_m: float = setting("distance behind the vehicle where a track is pruned", ge=0.0)
    noise: NoiseModel = setting("of the point tracks")
    filter: FilterConfig = setting("of a track's state")
    evidence: EvidenceConfig = setting("of one observation")
    collision_alarm: CollisionAlarmConfig | None = setting(
        "collision alarm: points that expand fast are an obstacle before any tracker knows it", default=None
    )
    candidate_contrast: CandidateContrastConfig | None = setting(
        "candidate contrast: faint points count less in the choice of new tracks", default=None
    )
    contradiction: ContradictionConfig | None = setting(
        "contradiction: points in a candidate's outline that move otherwise reject it", default=None
    )
    reflectivity: ReflectivityConfig | None = setting(
        "reflectivity: how far the road mirrors is measured; none: it always mirrors", default=None
    )
    mirror_image: MirrorImageConfig | None = setting(
        "mirror-image rejection: points as faint as a vehicle's own mirror image are not its", default=None
    )
    mirrored_place: MirroredPlaceConfig | None = setting(
        "mirrored place: a track is tested less for contrast where the mirrored object would stand on the road",
        default=None,
    )
    shape: ShapeConfig | None = setting(
        "shape: only an upright face as wide as a vehicle speaks for a track", default=None
    )
    thickness: ThicknessConfig | None = setting(
        "thickness: a tentative track whose points lie on one line is not supported", default=None
    )
    least_speed: LeastSpeedConfig | None = setting("least speed: a slow tentative track is not supported", default=None)
    equal_speed: EqualSpeedConfig | None = setting(
        "equal speed: a tentative track as fast as the camera is rejected, like the image of far scenery", default=None
    )
    edge_lines: EdgeLineConfig | None = setting(
        "edge lines: points near an edge line start no track, since tracks slip along it", default=None
    )
    carriageway: CarriagewayConfig | None = setting(
        "carriageway: tracks begin on the carriageway and are pruned off it", default=None
    )
    merging: MergingConfig | None = setting("merging: tracks of one vehicle are joined", default=None)
    patience: PatienceConfig | None = setting(
        "patience: one observation lowers a confirmed track's log-odds by little, as while the wiper passes",
        default=None,
    )
    credit: CreditConfig | None = setting(
        "credit: a track that was sure is not doubted for what the image's edge leaves of it", default=None
    )
    decay: DecayConfig | None = setting(
        "decay: a track that cannot be observed loses confidence, a tentative one is pruned", default=None
    )
    prior: PriorConfig | None = setting(
        "prior: a new track begins with odds against it; none: with even odds", default=None
    )
    mask: MaskConfig | None = setting(
        "mask: points of sure tracks are withheld from the static obstacle tracker", default=None
    )
