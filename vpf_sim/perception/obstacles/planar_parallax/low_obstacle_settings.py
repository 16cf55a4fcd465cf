"""Settings of planar parallax and of its tracks. A section that may be None is a mechanism that can be switched off."""

from vpf_sim.configuration import setting, settings

Pair = tuple[float, float]


def odd_cells(window_m: Pair, cell_m: float) -> tuple[int, int]:
    """Cells across and along, odd numbers, of a window along and across."""
    along, across = (2 * round(0.5 * (size / cell_m - 1.0)) + 1 for size in window_m)
    return across, along


@settings
class SensingRangeConfig:
    """The difference that a faint pallet 0.12 to 0.15 m high makes, and how observations are averaged."""

    grains: float = setting("Difference that the pallet makes, in multiples of the grain's.", gt=0.0)
    grains_at_m: float = setting("Distance from the pose at which the difference is `grains`.", gt=0.0)
    power: float = setting("Power of the distance by which the difference falls.", gt=0.0)
    far_m: float = setting("Distance beyond which few observations show a height.", gt=0.0)
    half_width_m: float = setting("Half of the width of the strip of road ahead.", gt=0.0)
    spare_looks: float = setting("observations more than a tentative track needs: some fail by chance", gt=0.0)
    good_share: float = setting("of observations that detect a pallet on a dry, grainy road", gt=0.0)
    looks: float = setting("Number of observations that are averaged.", gt=0.0)
    grain_looks: float = setting(
        "Number of observations of the grain that are averaged: mirror images pass, the grain stays.", gt=0.0
    )


@settings
class HighPassConfig:
    """Subtraction of the local mean of differences."""

    window_m: Pair = setting("along and across, of the mean")


@settings
class TemporalAverageConfig:
    """Exponential average of the differences, moved with the road."""

    newest: float = setting("weight of the newest observation", gt=0.0, le=1.0)


@settings
class ParallaxConfig:
    """The patch of road that is observed, the heights that are tested, and what counts as one."""

    period_s: float = setting("between observations", gt=0.0)
    baseline_m: float = setting("the own way between the two frames, at least", gt=0.0)
    longest_ratio: float = setting("the own way between the two frames at most, in baselines", ge=1.0)
    reach_ratio: float = setting("baselines by which the older patch is longer", ge=1.0)
    near_m: float = setting("near end of the patch, from the pose", gt=0.0)
    far_m: float = setting("far end of the patch, from the pose", gt=0.0)
    noise_far_m: float = setting("up to which the noise is measured: farther, two pictures of a road hardly differ")
    half_width_m: float = setting("Half of the width of the patch.", gt=0.0)
    border_m: float = setting("by which the older patch is wider, for turns", ge=0.0)
    cell_m: float = setting("Side of a cell of the patch.", gt=0.0)
    above_m: tuple[float, ...] = setting("heights above the road that are tested", min_length=1)
    window_m: Pair = setting("along and across, over which differences are summed")
    floor_levels2: float = setting("of the noise, grey levels^2", gt=0.0)
    least_gain: float = setting("by which a height above the road fits better, in multiples of the noise", gt=0.0)
    most_share: float = setting("of the difference that is left with that height", gt=0.0)
    outline_gain: float = setting("least difference of an object's outline, in multiples of the noise", gt=0.0)
    least_seen: float = setting("share of a window that is not masked", gt=0.0, le=1.0)
    sensing_range: SensingRangeConfig = setting("sensing range of low obstacles")
    high_pass: HighPassConfig | None = setting("high pass: long changes, as of mirror images, cancel", default=None)
    temporal_average: TemporalAverageConfig | None = setting("average the differences over observations", default=None)


@settings
class GainWeightConfig:
    """Weight of an observation. Mirror images gain 6 to 12 times the noise, pallets 12 to 45 in hard rain."""

    usual_gain: float = setting("gain of an observation that counts as one", gt=0.0)
    least: float = setting("least weight of an observation", gt=0.0)
    most: float = setting("largest weight of an observation", gt=0.0)


@settings
class ClutterConfig:
    """Where new tracks begin often, as in rain, a track needs more hits."""

    rate: float = setting("new tracks per look, from which there is clutter", ge=0.0)
    looks: float = setting("looks averaged over", ge=1.0)
    more_hits: int = setting("additional hits of a confirmed track", ge=0)


@settings
class LowTrackConfig:
    """When a low obstacle is confirmed: observed so often at one place of the world, over so long a way."""

    hits: int = setting("of a confirmed track", gt=0)
    way_m: float = setting("of the car between the first and the last observation of a confirmed track", ge=0.0)
    misses: int = setting("in a row, after which a tentative track is pruned", gt=0)
    along_m: float = setting("observations nearer than this are of one track", gt=0.0)
    across_m: float = setting("observations nearer than this are of one track", gt=0.0)
    newest: float = setting("weight of the newest observation for place and sides", gt=0.0, le=1.0)
    sigma_m: float = setting("of the face of a low obstacle", gt=0.0)
    beside_m: float = setting("A track within this distance beside a taller obstacle belongs to it.", ge=0.0)
    sticks_out_m: float = setting("Distance by which a track of its own reaches out beside a taller obstacle.", ge=0.0)
    before_m: float = setting(
        "Distance before an obstacle's face from which a low one begins, farther than mirror images do.", ge=0.0
    )
    least_width_m: float = setting("of a reported obstacle", ge=0.0)
    gain_weight: GainWeightConfig | None = setting("faint observations count less than clear ones", default=None)
    clutter: ClutterConfig | None = setting("tracks need more hits while new ones begin often", default=None)
    approach_share: float | None = setting(
        "Confirms only what comes nearer by more than this share of the own way.", default=None, gt=0.0, le=1.0
    )
