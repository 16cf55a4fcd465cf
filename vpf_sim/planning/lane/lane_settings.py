"""Settings of the lane planner. Costs have no unit: only their ratios matter. Ways go from the bumper to a face."""

from vpf_sim.configuration import setting, settings
from vpf_sim.planning.lane.recovery_config import RecoveryConfig


@settings
class ClearanceConfig:
    """Clearances between the sides of the car and what it passes."""

    wanted_m: float = setting("Clearance beside an obstacle where there is room.", gt=0.0)
    full_speed_m: float = setting("Least clearance beside an obstacle at full speed.", gt=0.0)
    least_m: float = setting("Least clearance beside an obstacle at walking speed; a narrower gap is blocked.", gt=0.0)
    edge_m: float = setting("Least clearance to an edge of the road.", gt=0.0)


@settings
class BrakingConfig:
    """Stops and speed changes, the same in all parts of the planner."""

    comfort_mps2: float = setting("Deceleration before a blocked road.", gt=0.0)
    emergency_mps2: float = setting("Deceleration before an obstacle that is too near for comfort.", gt=0.0)
    reaction_s: float = setting("Time until brake or steering takes effect.", ge=0.0)
    standoff_m: float = setting("Distance to an obstacle that is kept when stopping.", gt=0.0)
    closest_standoff_m: float = setting("Distance to an obstacle that is kept when creeping up to it.", gt=0.0)
    rise_mps2: float = setting("Acceleration of the speed reference.", gt=0.0)


@settings
class PartsConfig:
    """Which obstacles are a part of another one before them."""

    least_behind_m: float = setting("Least distance of a part behind the face of the other one.", ge=0.0)
    most_behind_m: float = setting("Largest distance of a part behind the face of the other one.", gt=0.0)
    beyond_m: float = setting("Largest distance of a part beyond a side of the other obstacle.", ge=0.0)
    share: float = setting("Least share of a part's width that lies behind the other obstacle.", ge=0.0, le=1.0)


@settings
class MeetConfig:
    time_s: float = setting("Time before the encounter from which a moving obstacle is avoided.", gt=0.0)
    gap_m: float = setting("Gap that is kept from a moving obstacle in addition.", ge=0.0)


@settings
class CornerSwingConfig:
    pass


@settings
class ObstacleConfig:
    """Which obstacles count, and how they lie to each other."""

    visible_m: float = setting("Distance ahead within which an obstacle counts.", gt=0.0)
    full_m: float = setting("Distance ahead within which an obstacle counts in full.", gt=0.0)
    length_m: float = setting("Least length that is assumed of an obstacle, whose rear is not visible.", gt=0.0)
    long_m: float = setting("Least length that is assumed of a truck or of a moving obstacle.", gt=0.0)
    truck_width_m: float = setting("Width from which an obstacle may be a truck.", gt=0.0)
    row_depth_m: float = setting("Distance of faces along the road below which obstacles are met together.", gt=0.0)
    row_gap_m: float = setting(
        "Distance of a face behind the rear of another obstacle up to which it is in its row.", ge=0.0
    )
    slower_mps: float = setting("Speed below the reference from which an obstacle is overtaken.", ge=0.0)
    beside_m: float = setting("Distance along the road up to which other obstacles are avoided.", ge=0.0)
    parts: PartsConfig | None = setting("Merges what lies behind a face into one longer obstacle.", default=None)
    meet: MeetConfig | None = setting("Leaves moving obstacles alone until they are met soon.", default=None)
    catch_up_s: float | None = setting("Faster obstacles behind that come up in this time count.", default=None, gt=0.0)
    passage_m: float | None = setting("Obstacles nearer than this bound the path like edges.", default=None, gt=0.0)
    corner_swing: CornerSwingConfig | None = setting("Keeps the car's side off an obstacle beside it.", default=None)
    keep_aside_m: float | None = setting("Moving obstacles nearer than this keep the path off.", default=None, gt=0.0)


@settings
class TailConfig:
    height: float = setting("Height h_t of the cost beyond the clearance.", ge=0.0)
    decay_m: float = setting("Distance d_t over which the cost beyond the clearance decays.", gt=0.0)


@settings
class RowCostConfig:
    height: float = setting("Height h_r of the cost of a row without a gap.", ge=0.0)
    gap_m: float = setting("Gap b_r in a row from which on it costs nothing.", gt=0.0)


@settings
class MemoryConfig:
    height: float = setting("Cost of leaving the surroundings of the last minimum.", ge=0.0)
    reach_m: float = setting("Half of the width of the surroundings of the last minimum.", gt=0.0)


@settings
class NarrowPlanConfig:
    height: float = setting("Height of the latch towards a narrow gap.", ge=0.0)
    near_m: float = setting("Distance from the minimum within which the car has entered the gap.", gt=0.0)


@settings
class LatchConfig:
    """The side of an obstacle is kept once it is near."""

    ahead_m: float = setting("Distance ahead within which an obstacle is near.", gt=0.0)
    height: float = setting("Cost of changing the side of an obstacle.", ge=0.0)
    turned_rad: float | None = setting("A car turned by more keeps its side of farther ones.", default=None, gt=0.0)
    narrow_plan: NarrowPlanConfig | None = setting("Leaves a narrow gap again while far from it.", default=None)
    overlap_m: float | None = setting("An overlap with the last minimum that frees the side.", default=None, gt=0.0)


@settings
class CrossingConfig:
    time_s: float = setting("Time to get to the other side behind a moving obstacle.", gt=0.0)
    gap_m: float = setting("Gap that is kept in addition.", gt=0.0)
    behind_m: float = setting("Distance to the obstacle's middle below which the car has not selected a side.", ge=0.0)


@settings
class BesideConfig:
    height: float = setting("Cost of what lies beyond an obstacle beside the car.", ge=0.0)
    crossing: CrossingConfig | None = setting("Crosses behind a moving obstacle if that is safe.", default=None)


@settings
class LateralCostConfig:
    """The cost across the lane."""

    reach_m: float = setting("Reach of the grid to both sides of the own lane's middle.", gt=0.0, le=100.0)
    spacing_m: float = setting("Spacing of the grid.", ge=0.01)
    target_per_m2: float = setting("Weight k of the squared distance to the target.", gt=0.0)
    obstacle_height: float = setting("Height h_o of the cost of an obstacle.", ge=0.0)
    obstacle_slope_per_m: float = setting("Slope s_o of the cost of an obstacle.", ge=0.0)
    narrow_height: float = setting("Height h_n of the cost where there is no gap.", ge=0.0)
    wall_height: float = setting("Height h_w of the cost at an edge of the road.", ge=0.0)
    wall_reach_m: float = setting("Distance d_w from the edge up to which it has a cost.", gt=0.0)
    tail: TailConfig | None = setting("Repels from obstacles beyond the clearance wanted.", default=None)
    row: RowCostConfig | None = setting("Makes narrow gaps in a row of obstacles cost more.", default=None)
    unstopped_share: float | None = setting("Raises obstacles too near for a stop, if none is free.", default=None)
    memory: MemoryConfig | None = setting("Makes it cost to leave the last minimum.", default=None)
    latch: LatchConfig | None = setting("Keeps the side of a near obstacle.", default=None)
    beside: BesideConfig | None = setting("Does not cross an obstacle beside the car.", default=None)
    unreached_height: float | None = setting("Cost of what the car cannot reach in time.", default=None, ge=0.0)


@settings
class EdgeConfig:
    turning_m: float = setting("Distance along the road in which a corner turns back from the edge.", gt=0.0)
    least_ratio: float = setting("Ratio of the lateral motion where there is no room at all.", gt=0.0)


@settings
class LimitsConfig:
    """Limits of the lateral motion; a ratio is the largest lateral speed as a share of the vehicle's."""

    ratio: float = setting("Largest lateral speed at full speed, as a share of the vehicle's.", gt=0.0, lt=1.0)
    walking_ratio: float = setting(
        "Largest lateral speed at walking speed, as a share of the vehicle's.", gt=0.0, lt=1.0
    )
    walking_mps: float = setting("Speed at which `walking_ratio` holds.", gt=0.0)
    fast_mps: float = setting("Speed from which on `ratio` holds.", gt=0.0)
    acceleration_mps2: float = setting("Largest lateral acceleration.", gt=0.0)
    steering_radps: float = setting("Largest steering rate that a path needs.", gt=0.0)
    yaw_acceleration_radps2: float = setting("Largest yaw acceleration of the car.", gt=0.0)
    radius_factor: float = setting("Factor of the tightest curve's radius, since steering takes time.", ge=1.0)
    edge: EdgeConfig | None = setting("Turns towards an edge no more than the car's corners allow.", default=None)


@settings
class WaitConfig:
    reaction_s: float = setting("Time to react, in addition to the distance that the shift takes.", ge=0.0)
    slope: float = setting("Largest slope of a path that has not left its place yet.", gt=0.0)


@settings
class PathConfig:
    speed_mps: float = setting("Largest lateral speed.", gt=0.0)
    shift_s: float = setting("Duration of a shift when there is time.", gt=0.0)
    shift_share: float = setting("Share of the remaining time that a shift takes where there is less time.", gt=0.0)
    shortest_s: float = setting("Shortest duration of a shift.", gt=0.0)
    lead_m: float = setting("Largest distance from the rear axle to the path.", gt=0.0)
    slowest_closing_mps: float = setting(
        "Least speed towards an obstacle by which the remaining time is computed.", gt=0.0
    )
    wait: WaitConfig | None = setting("Leaves the lane no sooner than it must.", default=None)
    hold_m: float | None = setting("Stays straight until this near to a row without a gap.", default=None, gt=0.0)


@settings
class CorrectionConfig:
    """Feedback of the lateral error into the heading."""

    per_s: float = setting("Gain k of the lateral error.", gt=0.0)
    per_m: float = setting("Largest k / v: the slower the car, the longer it takes to turn.", gt=0.0)
    speed_mps: float = setting("Largest lateral speed.", gt=0.0)


@settings
class RowStopConfig:
    pass


@settings
class LookConfig:
    gap_m: float = setting("Gap from which on one more obstacle does not close it.", gt=0.0)
    beside_m: float = setting("Distance from the car within which a static obstacle bounds the gap.", gt=0.0)
    ahead_m: float = setting("Distance before the row from which the car is slow.", gt=0.0)
    speed_mps: float = setting("Speed before the row.", gt=0.0)


@settings
class NarrowGapConfig:
    pass


@settings
class UnwindConfig:
    pass


@settings
class CreepConfig:
    standing_s: float = setting("Time at standstill before each of the two stages of creeping.", gt=0.0)
    speed_mps: float = setting("Speed of creeping.", gt=0.0)


@settings
class SpeedConfig:
    """Limits of the speed by what is ahead."""

    near_m: float = setting("Distance to an obstacle at which an emergency stop ends.", gt=0.0)
    turn_m: float = setting("Least distance in which the tightest turn leads out.", gt=0.0)
    time_gap_s: float = setting("Time gap that is kept from a moving obstacle in addition to the standoff.", ge=0.0)
    fall_back_mps: float = setting(
        "Speed below that of a moving obstacle that is too near, until the distance is kept.", gt=0.0
    )
    bend_mps2: float | None = setting("Largest lateral acceleration in bends.", default=None, gt=0.0)
    narrow_gap: NarrowGapConfig | None = setting("Slows beside near obstacles.", default=None)
    turned_m: float | None = setting("Shifts before obstacles; a turned car is so much wider.", default=None, ge=0.0)
    row_stop: RowStopConfig | None = setting("Stops before the first of a row that is closed.", default=None)
    look: LookConfig | None = setting("Slows before a gap that one more obstacle would close.", default=None)
    headed_s: float | None = setting("Slows where an obstacle is met sooner.", default=None, gt=0.0)
    firm_mps2: float | None = setting("Brakes in comfort up to this deceleration.", default=None, gt=0.0)
    rest_m: float | None = setting("Slows a path that runs wide into an obstacle by more.", default=None, ge=0.0)
    unwind: UnwindConfig | None = setting("Slows until the wheels are straight in time.", default=None)
    far_standoff_m: float | None = setting("Stops at most so far off to keep a side in reach.", default=None, gt=0.0)
    creep: CreepConfig | None = setting("Creeps up to what blocks the way after a stand.", default=None)


@settings
class LanePlannerConfig:
    clearance: ClearanceConfig
    braking: BrakingConfig
    obstacles: ObstacleConfig
    lateral_cost: LateralCostConfig
    limits: LimitsConfig
    correction: CorrectionConfig
    path: PathConfig | None = setting("Leads to the minimum with least jerk instead of straight.", default=None)
    speed: SpeedConfig | None = setting("Adapts the speed to what is ahead.", default=None)
    recovery: RecoveryConfig | None = setting("Turns out of a dead end on the tightest curve.", default=None)
