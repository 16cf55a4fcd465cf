"""Settings of the lane planner but for speed and recovery. Potentials have no unit: only their ratios matter."""

from vpf_sim.configuration import setting, settings
from vpf_sim.planning.lane.speed_config import SpeedConfig

MOST_CELLS = 10_000  # of the grid, to one side


@settings
class ClearanceConfig:
    """Clearances between the sides of the car and what it passes."""

    wanted_m: float = setting("beside an obstacle, where there is room", gt=0.0)
    full_speed_m: float = setting("beside an obstacle, at least, at full speed", gt=0.0)
    least_m: float = setting("beside an obstacle, at least, at walking speed; a narrower gap is blocked", gt=0.0)
    edge_m: float = setting("to an edge of the road, at least", gt=0.0)

    def __post_init__(self) -> None:
        if not self.least_m < self.full_speed_m:
            raise ValueError(f"least_m: expected < full_speed_m = {self.full_speed_m}, got {self.least_m}")


@settings
class PartsConfig:
    """Which obstacles are a part of another one before them."""

    least_behind_m: float = setting("from the face of the other one to a part, at least", ge=0.0)
    most_behind_m: float = setting("and at most", gt=0.0)
    beyond_m: float = setting("a part lies at most so far beyond a side of the other one", ge=0.0)
    share: float = setting("of a part's width that lies behind the other one, at least", ge=0.0, le=1.0)


@settings
class FollowConfig:
    slower_mps: float = setting("an obstacle is overtaken that is slower than the reference speed by more", ge=0.0)
    beside_m: float = setting("others are avoided only where the way to them is shorter", ge=0.0)


@settings
class MeetConfig:
    time_s: float = setting("a moving obstacle is avoided from when it is met in this time", gt=0.0)
    gap_m: float = setting("kept from it besides", ge=0.0)


@settings
class CatchUpConfig:
    time_s: float = setting("time in which an obstacle behind comes beside the car", gt=0.0)


@settings
class RowsConfig:
    beyond_m: float = setting("a face so far behind the rear of another obstacle is in its row", ge=0.0)


@settings
class PassageConfig:
    ahead_m: float = setting("an obstacle nearer than this bounds the passage", gt=0.0)


@settings
class CornerSwingConfig:
    pass


@settings
class KeepAsideConfig:
    ahead_m: float = setting("a moving obstacle is being passed from this way to its face on", gt=0.0)


@settings
class ObstacleConfig:
    """Which obstacles count, from bumper to face, and how they lie to each other."""

    visible_m: float = setting("an obstacle counts from this way on", gt=0.0)
    full_m: float = setting("and in full from this way on", gt=0.0)
    length_m: float = setting("length of an obstacle, at least: its rear is not seen", gt=0.0)
    long_m: float = setting("length of a truck, or of a moving obstacle, at least", gt=0.0)
    truck_width_m: float = setting("an obstacle that is wider may be a truck", gt=0.0)
    row_depth_m: float = setting("obstacles whose faces are nearer along the road are met together", gt=0.0)
    parts: PartsConfig | None = setting("Merges what lies behind a face into one longer obstacle.", default=None)
    follow: FollowConfig | None = setting("Leaves obstacles alone that are about as fast, unless near.", default=None)
    meet: MeetConfig | None = setting("Leaves moving obstacles alone until they are met soon.", default=None)
    catch_up: CatchUpConfig | None = setting("Avoids faster obstacles that come from behind.", default=None)
    rows: RowsConfig | None = setting("Chooses a side for a row of obstacles as a whole.", default=None)
    passage: PassageConfig | None = setting(
        "Bounds the path by the obstacles beside the car as by the road's edges.", default=None
    )
    corner_swing: CornerSwingConfig | None = setting(
        "Limits the path's slope so that the car's side does not swing into an obstacle.", default=None
    )
    keep_aside: KeepAsideConfig | None = setting(
        "Keeps the path from a moving obstacle that is being passed.", default=None
    )

    def __post_init__(self) -> None:
        if not self.full_m < self.visible_m:
            raise ValueError(f"full_m: expected < visible_m = {self.visible_m}, got {self.full_m}")


@settings
class WallConfig:
    height: float = setting("h_w, at the edge", ge=0.0)
    reach_m: float = setting("d_w, from the edge", gt=0.0)


@settings
class TailConfig:
    height: float = setting("h_t", ge=0.0)
    decay_m: float = setting("d_t", gt=0.0)


@settings
class NarrowConfig:
    height: float = setting("h_n, at no gap", ge=0.0)


@settings
class RowCostConfig:
    height: float = setting("h_r, at no gap", ge=0.0)
    gap_m: float = setting("b_r, a wider gap costs nothing", gt=0.0)


@settings
class UnstoppedConfig:
    share: float = setting("by which the obstacle potential is higher", ge=0.0)
    brake_mps2: float = setting("of an emergency stop", gt=0.0)
    reaction_s: float = setting("of an emergency stop", ge=0.0)


@settings
class MemoryConfig:
    height: float = setting("for leaving the surroundings of the last minimum", ge=0.0)
    reach_m: float = setting("of these surroundings", gt=0.0)


@settings
class TurnedConfig:
    angle_rad: float = setting("from the road's direction, at least", gt=0.0)


@settings
class NarrowPlanConfig:
    height: float = setting("of the latch towards a narrow gap", ge=0.0)
    near_m: float = setting("from the minimum, a car has gone there", gt=0.0)


@settings
class OverlapConfig:
    within_m: float = setting("an overlap with the last minimum from which on the side is free", gt=0.0)


@settings
class LatchConfig:
    """The side of an obstacle is kept once it is near."""

    ahead_m: float = setting("an obstacle is near, from bumper to face", gt=0.0)
    height: float = setting("for changing the side", ge=0.0)
    turned: TurnedConfig | None = setting("Keeps the side of farther obstacles, too, once turned to it.", default=None)
    narrow_plan: NarrowPlanConfig | None = setting(
        "Keeps a side less where it leads to a narrow gap and the car does not go there yet.", default=None
    )
    overlap: OverlapConfig | None = setting(
        "Keeps no side of an obstacle that is reported where the car was going.", default=None
    )


@settings
class CrossingConfig:
    time_s: float = setting("to get to the other side", gt=0.0)
    gap_m: float = setting("kept besides", gt=0.0)
    behind_m: float = setting("a car nearer to the obstacle's middle has chosen no side", ge=0.0)


@settings
class BesideConfig:
    """Obstacles beside the car are not crossed."""

    height: float = setting("for what lies beyond an obstacle beside the car", ge=0.0)
    crossing: CrossingConfig | None = setting(
        "Crosses behind a moving obstacle only where it is not reached meanwhile.", default=None
    )


@settings
class UnreachedConfig:
    height: float = setting("for what cannot be reached before an obstacle", ge=0.0)


@settings
class LateralCostConfig:
    """The potential across the lane."""

    reach_m: float = setting("of the grid, to both sides of the own lane's middle", gt=0.0)
    spacing_m: float = setting("of the grid", gt=0.0)
    target_per_m2: float = setting("k", gt=0.0)
    obstacle_height: float = setting("h_o", ge=0.0)
    obstacle_slope_per_m: float = setting("s_o", ge=0.0)
    wall: WallConfig | None = setting("Repels from the road's edges.", default=None)
    tail: TailConfig | None = setting("Repels from obstacles beyond the clearance wanted.", default=None)
    narrow: NarrowConfig | None = setting("Makes a gap below the least clearance cost more than an edge.", default=None)
    row: RowCostConfig | None = setting("Makes narrow gaps in a row of obstacles cost more.", default=None)
    unstopped: UnstoppedConfig | None = setting(
        "Keeps clear first of obstacles that are too near for a stop, where no place is free.", default=None
    )
    memory: MemoryConfig | None = setting("Makes it cost to leave the last minimum.", default=None)
    latch: LatchConfig | None = setting("Keeps the side of a near obstacle.", default=None)
    beside: BesideConfig | None = setting("Does not cross an obstacle beside the car.", default=None)
    unreached: UnreachedConfig | None = setting(
        "Avoids places that the car cannot reach before an obstacle.", default=None
    )

    def __post_init__(self) -> None:
        if self.reach_m / self.spacing_m > MOST_CELLS:
            raise ValueError(f"reach_m: expected at most {MOST_CELLS} times spacing_m, got {self.reach_m}")


@settings
class EdgeConfig:
    turning_m: float = setting("of way until a corner turns back from the edge", gt=0.0)
    least_ratio: float = setting("where there is no room at all", gt=0.0)


@settings
class LimitsConfig:
    """Limits of the lateral motion; a ratio is the largest lateral speed as a share of the vehicle's."""

    ratio: float = setting("at speed", gt=0.0, lt=1.0)
    walking_ratio: float = setting("at walking speed", gt=0.0, lt=1.0)
    walking_mps: float = setting("walking speed", gt=0.0)
    fast_mps: float = setting("from this speed on `ratio` holds", gt=0.0)
    acceleration_mps2: float = setting("largest lateral acceleration", gt=0.0)
    steering_radps: float = setting("rate that a path asks of the steering at most", gt=0.0)
    yaw_acceleration_radps2: float = setting("and of the car", gt=0.0)
    reaction_s: float = setting("until the steering shows across the lane", ge=0.0)
    radius_factor: float = setting("of the tightest curve: the steering takes time to get there", ge=1.0)
    edge: EdgeConfig | None = setting("Turns towards an edge no more than the car's corners allow.", default=None)

    def __post_init__(self) -> None:
        if not self.ratio <= self.walking_ratio:
            raise ValueError(f"ratio: expected <= walking_ratio = {self.walking_ratio}, got {self.ratio}")
        if not self.walking_mps < self.fast_mps:
            raise ValueError(f"walking_mps: expected < fast_mps = {self.fast_mps}, got {self.walking_mps}")


@settings
class WaitConfig:
    reaction_s: float = setting("besides the way that the shift takes", ge=0.0)
    slope: float = setting("of a path that has not left its place yet, at most", gt=0.0)


@settings
class HoldConfig:
    ahead_m: float = setting("from bumper to face: from farther away a gap may still prove wider", gt=0.0)


@settings
class PathConfig:
    speed_mps: float = setting("largest lateral speed", gt=0.0)
    shift_s: float = setting("duration of a shift when there is time", gt=0.0)
    shift_share: float = setting("of the time that is left, otherwise", gt=0.0)
    shortest_s: float = setting("shortest duration of a shift", gt=0.0)
    lead_m: float = setting("from the rear axle to the path, at most", gt=0.0)
    slowest_closing_mps: float = setting("speed towards an obstacle, at least, for the time that is left", gt=0.0)
    wait: WaitConfig | None = setting("Leaves the lane no sooner than it must.", default=None)
    hold: HoldConfig | None = setting("Stays straight before a row without a free gap.", default=None)


@settings
class CorrectionConfig:
    """Feedback of the lateral error into the heading."""

    per_s: float = setting("k, of the lateral error", gt=0.0)
    per_m: float = setting("k / v, at most: the slower, the longer the car takes to turn", gt=0.0)
    speed_mps: float = setting("largest lateral speed", gt=0.0)
    ratio: float = setting("largest lateral speed as a share of the vehicle's", gt=0.0)


@settings
class LaneReferenceConfig:
    """Heading and speed towards the minimum."""

    brake_mps2: float = setting("of a stop before a blocked road", gt=0.0)
    closest_standoff_m: float = setting("from the bumper to a face, of any stop", gt=0.0)
    correction: CorrectionConfig
    path: PathConfig | None = setting("Leads to the minimum with least jerk instead of straight.", default=None)
    speed: SpeedConfig | None = setting("Adapts the speed to what is ahead.", default=None)

    def __post_init__(self) -> None:
        if self.speed is not None and not self.closest_standoff_m <= self.speed.standoff_m:
            most = self.speed.standoff_m
            raise ValueError(
                f"closest_standoff_m: expected <= speed.standoff_m = {most}, got {self.closest_standoff_m}"
            )
