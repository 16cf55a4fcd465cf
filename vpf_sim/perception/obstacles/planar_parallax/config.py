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

    grains: float = setting("that difference in multiples of the grain's", gt=0.0)
    grains_at_m: float = setting("from the pose, where it is so large", gt=0.0)
    power: float = setting("of the distance, by which it falls", gt=0.0)
    far_m: float = setting("beyond it few observations show a height", gt=0.0)
    half_width_m: float = setting("of the strip of road ahead", gt=0.0)
    spare_looks: float = setting("observations more than a tentative track needs: some fail by chance", gt=0.0)
    good_share: float = setting("of observations that detect a pallet on a dry, grainy road", gt=0.0)
    looks: float = setting("observations averaged over", gt=0.0)
    grain_looks: float = setting("the same for the grain: mirror images pass, it stays", gt=0.0)


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
    half_width_m: float = setting("of the patch", gt=0.0)
    border_m: float = setting("by which the older patch is wider, for turns", ge=0.0)
    cell_m: float = setting("of the patch", gt=0.0)
    above_m: tuple[float, ...] = setting("heights above the road that are tested", min_length=1)
    window_m: Pair = setting("along and across, over which differences are summed")
    floor_levels2: float = setting("of the noise, grey levels^2", gt=0.0)
    least_gain: float = setting("by which a height above the road fits better, in multiples of the noise", gt=0.0)
    most_share: float = setting("of the difference that is left with that height", gt=0.0)
    outline_gain: float = setting("least difference of an object's outline, in multiples of the noise", gt=0.0)
    least_seen: float = setting("share of a window that is not masked", gt=0.0, le=1.0)
    foot_m: Pair = setting("along from where an obstacle begins, and beside it, where its foot is compared")
    foot_width_m: float = setting("observed width of a foot, at least", ge=0.0)
    foot_share: float = setting("observed share of a foot, at least", ge=0.0, le=1.0)
    sensing_range: SensingRangeConfig = setting("sensing range of low obstacles")
    high_pass: HighPassConfig | None = setting("high pass: long changes, as of mirror images, cancel", default=None)
    temporal_average: TemporalAverageConfig | None = setting("average the differences over observations", default=None)


@settings
class GainWeightConfig:
    """Weight of an observation. Mirror images gain 6 to 12 times the noise, pallets 12 to 45 in hard rain."""

    usual_gain: float = setting("an observation counts by its gain over this,", gt=0.0)
    least: float = setting("but no less than this,", gt=0.0)
    most: float = setting("and no more", gt=0.0)


@settings
class ClutterConfig:
    """Rate of new tentative tracks, as in rain."""

    rate: float = setting("new tracks per observation, from which there is clutter", ge=0.0)
    looks: float = setting("observations averaged over", gt=0.0)
    more_hits: int = setting("that a track needs besides in clutter", ge=0)


@settings
class ApproachConfig:
    """How an object comes nearer as the car drives."""

    share: float = setting("of the own way: a drop comes no nearer, a mirror image by less", gt=0.0, le=1.0)


@settings
class TruncatedConfig:
    """Observations that reach to the near end of the patch."""

    share: float = setting("of the own way by which it comes nearer at least", gt=0.0, le=1.0)
    more_hits: int = setting("that a track needs besides where its place was not observed all the way", ge=0)


@settings
class TentativeTrackConfig:
    """Tracks that are not confirmed."""

    hits: int = setting("observations, sure ones or not, until a tentative track is reported", gt=0)


@settings
class SpotOcclusionConfig:
    """The road that known obstacles hide."""

    beyond_m: float = setting("behind an obstacle's face begins what it hides", ge=0.0)
    margin_m: float = setting("beside an obstacle, hidden as well", ge=0.0)
    least_seen_m: float = setting("width that an observation keeps beside an obstacle, at least", gt=0.0)


@settings
class LowTrackConfig:
    """When a low obstacle is confirmed: observed so often at one place of the world, over so long a way."""

    hits: int = setting("of a confirmed track", gt=0)
    way_m: float = setting("of the car between the first and the last observation of a confirmed track", ge=0.0)
    least_way_m: float = setting("travel before which nothing has come nearer", ge=0.0)
    misses: int = setting("in a row, after which a tentative track is pruned", gt=0)
    along_m: float = setting("observations nearer than this are of one track", gt=0.0)
    across_m: float = setting("observations nearer than this are of one track", gt=0.0)
    newest: float = setting("weight of the newest observation for place and sides", gt=0.0, le=1.0)
    edge_m: float = setting("inside the carriageway's edges")
    low_hides_m: float = setting("behind its face a low obstacle hides the road up to here", ge=0.0)
    sigma_m: float = setting("of the face of a low obstacle", gt=0.0)
    beside_m: float = setting("a track so near a taller obstacle belongs to it,", ge=0.0)
    sticks_out_m: float = setting("unless it reaches so far out of it,", ge=0.0)
    before_m: float = setting("or begins farther before its face than mirror images do", ge=0.0)
    least_width_m: float = setting("of a reported obstacle", ge=0.0)
    gain_weight: GainWeightConfig | None = setting("a clear observation counts more than a faint one", default=None)
    clutter: ClutterConfig | None = setting("a track needs more hits while new ones appear often", default=None)
    approach: ApproachConfig | None = setting("reject drops and mirror images: they come no nearer", default=None)
    truncated: TruncatedConfig | None = setting("observations at the near end of the patch have no place", default=None)
    tentative: TentativeTrackConfig | None = setting("tentative tracks are reported as well", default=None)
    occlusion: SpotOcclusionConfig | None = setting("cut off what known obstacles hide", default=None)

    @property
    def doubts(self) -> int:
        """Observations until a track is reported."""
        return self.tentative.hits if self.tentative else self.hits
