"""Settings of planar parallax and of its tracks."""

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
    spare_looks: float = setting(
        "Observations beyond those that a tentative track needs, since some fail by chance.", gt=0.0
    )
    good_share: float = setting("Share of observations that detect a pallet on a dry, grainy road.", gt=0.0)
    looks: float = setting("Number of observations that are averaged.", gt=0.0)
    grain_looks: float = setting(
        "Number of observations of the grain that are averaged: mirror images pass, the grain stays.", gt=0.0
    )


@settings
class HighPassConfig:
    """Subtraction of the local mean of differences."""

    window_m: Pair = setting("Window of the mean, along and across.")


@settings
class TemporalAverageConfig:
    """Exponential average of the differences, moved with the road."""

    newest: float = setting("Weight of the newest observation.", gt=0.0, le=1.0)


@settings
class ParallaxConfig:
    """The patch of road that is observed, the heights that are tested, and what counts as one."""

    period_s: float = setting("Time between two observations.", gt=0.0)
    baseline_m: float = setting("Least distance travelled between the two frames.", gt=0.0)
    longest_ratio: float = setting("Largest distance travelled between the two frames, in baselines.", ge=1.0)
    reach_ratio: float = setting("Baselines by which the older patch is longer.", ge=1.0)
    near_m: float = setting("Near end of the patch, from the pose.", gt=0.0)
    far_m: float = setting("Far end of the patch, from the pose.", gt=0.0)
    noise_far_m: float = setting(
        "Depth up to which the noise is measured; farther, two pictures of a road hardly differ."
    )
    half_width_m: float = setting("Half of the width of the patch.", gt=0.0)
    border_m: float = setting("Margin by which the older patch is wider, for turns.", ge=0.0)
    cell_m: float = setting("Side of a cell of the patch.", gt=0.0)
    above_m: tuple[float, ...] = setting("Heights above the road that are tested.", min_length=1)
    window_m: Pair = setting("Window over which differences are summed, along and across.")
    floor_levels2: float = setting("Least noise, in grey levels^2.", gt=0.0)
    least_gain: float = setting("Gain by which a height above the road fits better, in multiples of the noise.", gt=0.0)
    most_share: float = setting("Largest share of the difference that is left with that height.", gt=0.0)
    outline_gain: float = setting("Least difference of an object's outline, in multiples of the noise.", gt=0.0)
    least_seen: float = setting("Share of a window that is not masked.", gt=0.0, le=1.0)
    sensing_range: SensingRangeConfig = setting("Estimates the sensing range of low obstacles.")
    high_pass: HighPassConfig = setting("Removes long changes, as of mirror images.")
    temporal_average: TemporalAverageConfig = setting("Averages the differences over observations.")


@settings
class GainWeightConfig:
    """Weight of an observation. Mirror images gain 6 to 12 times the noise, pallets 12 to 45 in hard rain."""

    usual_gain: float = setting("Gain of an observation that counts as one.", gt=0.0)
    least: float = setting("Least weight of an observation.", gt=0.0)
    most: float = setting("Largest weight of an observation.", gt=0.0)


@settings
class ClutterConfig:
    """Where new tracks begin often, as in rain, a track needs more hits."""

    rate: float = setting("New tracks per observation from which there is clutter.", ge=0.0)
    looks: float = setting("Observations over which the rate is averaged.", ge=1.0)
    more_hits: int = setting("Additional hits of a confirmed track in clutter.", ge=0)


@settings
class LowTrackConfig:
    """When a low obstacle is confirmed: observed so often at one place of the world, over so long a way."""

    hits: int = setting("Hits of a confirmed track.", gt=0)
    way_m: float = setting(
        "Distance travelled between the first and the last observation of a confirmed track.", ge=0.0
    )
    misses: int = setting("Misses in a row after which a tentative track is pruned.", gt=0)
    along_m: float = setting("Distance along the road below which observations are of one track.", gt=0.0)
    across_m: float = setting("Distance across the road below which observations are of one track.", gt=0.0)
    newest: float = setting("Weight of the newest observation for place and sides.", gt=0.0, le=1.0)
    sigma_m: float = setting("Standard deviation of the face of a low obstacle.", gt=0.0)
    beside_m: float = setting("A track within this distance beside a taller obstacle belongs to it.", ge=0.0)
    sticks_out_m: float = setting("Distance by which a track of its own reaches out beside a taller obstacle.", ge=0.0)
    before_m: float = setting(
        "Distance before an obstacle's face from which a low one begins, farther than mirror images do.", ge=0.0
    )
    least_width_m: float = setting("Least width of a reported obstacle.", ge=0.0)
    gain_weight: GainWeightConfig = setting("Counts faint observations less than clear ones.")
    clutter: ClutterConfig = setting("Requires more hits while new tracks begin often.")
    approach_share: float = setting(
        "Confirms only what comes nearer by more than this share of the own way.", gt=0.0, le=1.0
    )
