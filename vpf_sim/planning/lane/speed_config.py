"""Settings of the speed reference. Ways go from the bumper to a face."""

from vpf_sim.configuration import setting, settings


@settings
class BendConfig:
    acceleration_mps2: float = setting("largest lateral acceleration", gt=0.0)


@settings
class EasingConfig:
    firm_mps2: float = setting("deceleration from which more than comfort is needed", gt=0.0)


@settings
class RowStopConfig:
    pass


@settings
class LookConfig:
    gap_m: float = setting("a gap so wide is not closed by one more obstacle", gt=0.0)
    beside_m: float = setting("from the car, what stands bounds the gap", gt=0.0)
    ahead_m: float = setting("way before the row", gt=0.0)
    speed_mps: float = setting("speed there", gt=0.0)


@settings
class HeadedConfig:
    time_s: float = setting("until the obstacle is met, at least", gt=0.0)


@settings
class NarrowGapConfig:
    pass


@settings
class ApproachConfig:
    turned_m: float = setting("by which a turned car is wider to each side", ge=0.0)


@settings
class FollowGapConfig:
    time_gap_s: float = setting("kept besides the standoff", ge=0.0)
    fall_back_mps: float = setting("by which a too near obstacle is let go ahead", gt=0.0)


@settings
class RestConfig:
    tolerance_m: float = setting("beyond the clearance: less is not seen", ge=0.0)


@settings
class UnwindConfig:
    pass


@settings
class RiseConfig:
    acceleration_mps2: float = setting("of the speed reference", gt=0.0)


@settings
class FarStandoffConfig:
    most_m: float = setting("largest standoff", gt=0.0)


@settings
class CreepConfig:
    standing_s: float = setting("at standstill, before each of two stages", gt=0.0)
    speed_mps: float = setting("of creeping", gt=0.0)


@settings
class SpeedConfig:
    """Limits of the speed by what is ahead."""

    standoff_m: float = setting("kept when stopping", gt=0.0)
    near_m: float = setting("where an emergency stop ends", gt=0.0)
    turn_m: float = setting("least way on which the tightest turn leads out", gt=0.0)
    bends: BendConfig | None = setting("Slows in bends.", default=None)
    narrow_gap: NarrowGapConfig | None = setting("Slows beside near obstacles.", default=None)
    approach: ApproachConfig | None = setting("Slows so that a shift is done before the obstacle.", default=None)
    follow: FollowGapConfig | None = setting("Follows a moving obstacle at its speed.", default=None)
    row_stop: RowStopConfig | None = setting(
        "Stops before the first of a row of which any closes the way.", default=None
    )
    look: LookConfig | None = setting("Slows before a gap that one more obstacle would close.", default=None)
    headed_at: HeadedConfig | None = setting("Slows where the car is headed at an obstacle.", default=None)
    easing: EasingConfig | None = setting("Brakes in comfort, unless an obstacle is too near.", default=None)
    rest: RestConfig | None = setting("Slows a path that would run wide into an obstacle.", default=None)
    unwind: UnwindConfig | None = setting("Slows until the wheels are straight in time.", default=None)
    rise: RiseConfig | None = setting("Limits how fast the speed rises again.", default=None)
    far_standoff: FarStandoffConfig | None = setting(
        "Stops farther off where that keeps a side in reach.", default=None
    )
    creep: CreepConfig | None = setting("Creeps up to what blocks the way after a stand.", default=None)

    def __post_init__(self) -> None:
        if self.far_standoff is not None and not self.standoff_m <= self.far_standoff.most_m:
            raise ValueError(f"standoff_m: expected <= far_standoff.most_m, got {self.standoff_m}")


@settings
class ClearDistanceConfig:
    """The stop that must be possible within what is seen."""

    brake_mps2: float = setting("of the stop", gt=0.0)
    reaction_s: float = setting("of the stop", gt=0.0)
    standoff_m: float = setting("of the stop", gt=0.0)
    least_mps: float = setting("however little is seen: nearer by, obstacles are detected in other ways", gt=0.0)
    enough_share: float = setting("of the reference speed: a view that allows as much is a good one", gt=0.0)


@settings
class LostRoadConfig:
    speed_mps: float = setting("while the road is not seen", gt=0.0)
    way_m: float = setting("after which the car stops", gt=0.0)


@settings
class TentativeLimitConfig:
    """The stop that must be possible before a tentative obstacle, and how the speed changes."""

    brake_mps2: float = setting("of the stop, and of slowing down", gt=0.0)
    reaction_s: float = setting("of the stop", gt=0.0)
    standoff_m: float = setting("of the stop: where a way aside begins", gt=0.0)
    least_mps: float = setting("however near the obstacle is", gt=0.0)
    clearance_m: float = setting("beside the car, in which an obstacle is in the way", gt=0.0)
    rise_mps2: float = setting("of the speed, once the obstacle is gone", gt=0.0)
