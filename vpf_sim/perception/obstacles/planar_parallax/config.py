"""Settings of planar parallax and of its tracks. A section that may be None is a mechanism that can be switched off."""

from vpf_sim.configuration import setting, settings

Pair = tuple[float, float]
MOST_CELLS = 255  # of a window, whose cells bytes count


def odd_cells(size_m: float, cell_m: float) -> int:
    """Cells, an odd number."""
    return 2 * round(0.5 * (size_m / cell_m - 1.0)) + 1


@settings
class RoadMotionConfig:
    """Texture that moves with the road."""

    lead: float = setting("share of its power by which a texture must fit better in place than moved", ge=0.0)


@settings
class RimConfig:
    """Border about static texture."""

    size_m: Pair = setting("along and across, half to each side")


@settings
class WindscreenMaskConfig:
    """What counts as static texture between two layouts. Sizes are along and across."""

    least_way_m: float = setting("of the car between the two layouts", gt=0.0)
    texture_m: float = setting("of the road, over which brightness is averaged", gt=0.0)
    window_m: Pair = setting("over which textures are compared")
    share: float = setting("of their power that both have in common", gt=0.0, lt=1.0)
    contrast: float = setting("least power, in multiples of its median", gt=0.0)
    floor_levels2: float = setting("least power, grey levels^2: the grain of asphalt agrees by chance", ge=0.0)
    road_motion: RoadMotionConfig | None = setting(
        "road motion: a texture that fits better where the road has moved is road", default=None
    )
    rim: RimConfig | None = setting("rim: cells about static texture are masked as well", default=None)


@settings
class SensingRangeConfig:
    """The difference that a faint pallet 0.12 to 0.15 m high makes, and how observations are averaged."""

    grains: float = setting("that difference in multiples of the grain's", gt=0.0)
    grains_at_m: float = setting("from the pose, where it is so large", gt=0.0)
    power: float = setting("of the distance, by which it falls", gt=0.0)
    far_m: float = setting("beyond it few observations show a height", gt=0.0)
    step_m: float = setting("of the distances", gt=0.0)
    half_width_m: float = setting("of the strip of road ahead", gt=0.0)
    spare_looks: float = setting("observations more than a tentative track needs: some fail by chance", gt=0.0)
    good_share: float = setting("of observations that detect a pallet on a dry, grainy road", gt=0.0)
    looks: float = setting("observations averaged over", gt=0.0)
    grain_looks: float = setting("the same for the grain: mirror images pass, it stays", gt=0.0)
    grain_quantile: float = setting("of the differences, that is the grain's", gt=0.0, lt=1.0)


@settings
class TentativeGainConfig:
    """Weak observations."""

    least_gain: float = setting("of an observation, in multiples of the noise", gt=0.0)


@settings
class HighPassConfig:
    """Subtraction of the local mean of differences."""

    window_m: Pair = setting("along and across, of the mean")


@settings
class MirrorHeightsConfig:
    """Heights below the road, where mirror images fit."""

    heights_m: tuple[float, ...] = setting("below the road, negative", min_length=1)


@settings
class PaintEdgesConfig:
    """Difference that a small misalignment makes at sharp paint."""

    along_m: float = setting("misalignment along the way", ge=0.0)
    across_m: float = setting("misalignment across", ge=0.0)


@settings
class TemporalAverageConfig:
    """Exponential average of the differences, moved with the road."""

    newest: float = setting("weight of the newest observation", gt=0.0, le=1.0)


@settings
class DashConfig:
    """A dash that runs into an object."""

    before_m: float = setting("first cell above the road, at most, that an object begins", ge=0.0)


@settings
class FarEdgeConfig:
    """The far edge of an object."""

    length_m: float = setting(
        "of an object: what begins so near behind another, and overlaps it, is its far edge", ge=0.0
    )


@settings
class NarrowConfig:
    """Slivers at the rim of something else."""

    least_width_m: float = setting("of an observation", ge=0.0)


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
    outline_gain: float = setting("difference of the outline of an object, in multiples of the noise", gt=0.0)
    least_seen: float = setting("share of a window that is not masked", gt=0.0, le=1.0)
    scaled_share: float = setting("share of a window below which its difference is not scaled up", gt=0.0)
    tentative: TentativeGainConfig | None = setting(
        "weak observations: they make and support tentative tracks; none: only sure ones are reported", default=None
    )
    high_pass: HighPassConfig | None = setting(
        "high pass: slow changes along the way do not count, since mirror images are long", default=None
    )
    mirror_heights: MirrorHeightsConfig | None = setting(
        "mirror heights: what fits a height below the road better is a mirror image", default=None
    )
    paint_edges: PaintEdgesConfig | None = setting(
        "paint edges: a difference that a small misalignment of the picture explains is no object", default=None
    )
    temporal_average: TemporalAverageConfig | None = setting(
        "temporal average: differences are averaged over observations while the road moves by", default=None
    )
    dash: DashConfig | None = setting(
        "dash rejection: a painted dash that runs into an object does not bring it nearer", default=None
    )
    far_edge: FarEdgeConfig | None = setting(
        "far edge: an observation just behind a nearer one is no object of its own", default=None
    )
    narrow: NarrowConfig | None = setting("narrow observations are rejected", default=None)
    windscreen_mask: WindscreenMaskConfig | None = setting(
        "windscreen mask: cells whose texture does not move with the road are ignored", default=None
    )
    sensing_range: SensingRangeConfig | None = setting(
        "sensing range: measured from the observations; none: the whole patch is taken as observed", default=None
    )

    def __post_init__(self) -> None:
        if not self.near_m < self.far_m:
            raise ValueError(f"near_m, far_m: expected near < far, got {self.near_m}, {self.far_m}")
        if not self.near_m < self.noise_far_m <= self.far_m:
            raise ValueError(f"noise_far_m: expected {self.near_m} to {self.far_m}, got {self.noise_far_m}")
        for key, (across, along) in (
            ("window_m", self.window_cells),
            ("high_pass.window_m", self.even_cells or (1, 1)),
        ):
            if across * along > MOST_CELLS:
                raise ValueError(f"{key}: expected {MOST_CELLS} cells at most, got {across} x {along}")
        if not self.least_seen >= self.scaled_share:
            raise ValueError(f"least_seen: expected >= scaled_share = {self.scaled_share}, got {self.least_seen}")
        if not self.tentative_gain <= self.least_gain:
            raise ValueError(
                f"tentative.least_gain: expected <= least_gain = {self.least_gain}, got {self.tentative_gain}"
            )

    @property
    def tentative_gain(self) -> float:
        """The gain from which an observation is reported."""
        return self.tentative.least_gain if self.tentative else self.least_gain

    @property
    def window_cells(self) -> tuple[int, int]:
        """Across and along, of the window whose mean is compared."""
        return round(self.window_m[1] / self.cell_m), round(self.window_m[0] / self.cell_m)

    @property
    def even_cells(self) -> tuple[int, int] | None:
        """Across and along, of the window whose mean is subtracted."""
        if self.high_pass is None:
            return None
        along_m, across_m = self.high_pass.window_m
        return odd_cells(across_m, self.cell_m), odd_cells(along_m, self.cell_m)


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
    beside_m: float = setting("a track so near a taller obstacle belongs to it,", ge=0.0)
    sticks_out_m: float = setting("unless it reaches so far out of it,", ge=0.0)
    before_m: float = setting("or begins farther before its face than mirror images do", ge=0.0)
    least_width_m: float = setting("of a reported obstacle", ge=0.0)
    behind_m: float = setting("where a confirmed track is pruned", ge=0.0)
