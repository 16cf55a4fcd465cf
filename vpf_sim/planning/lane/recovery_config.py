"""Settings of the recovery from a dead end."""

from vpf_sim.configuration import setting, settings


@settings
class CandidatesConfig:
    """The manoeuvres that are compared: a turn, a straight and a turn back."""

    way_m: float = setting("length that is checked", gt=0.0)
    locks: tuple[float, ...] = setting("shares of the full lock, tried in this order", min_length=1)
    angles_deg: tuple[float, ...] = setting("largest angles to the road", min_length=1)
    straight_m: float = setting("longest straight", gt=0.0)
    aside_m: float = setting("lateral distance between two candidates", gt=0.0)
    beyond_m: float = setting("behind its end, a candidate must be free", ge=0.0)


@settings
class CostConfig:
    """Costs in rad: the largest angle to the road counts in full."""

    clearance_per_m: float = setting("Cost that a metre of clearance saves.", ge=0.0)
    enough_m: float = setting("clearance, more is no better", gt=0.0)
    length_per_m: float = setting("Cost of a metre of length.", ge=0.0)


@settings
class BeginConfig:
    way_m: float = setting("Length of a manoeuvre.", gt=0.0)
    least_m: float = setting("clearance on it, at least", gt=0.0)


@settings
class NewObstacleConfig:
    width_m: float = setting("wider obstacles that are detected on the way are ignored", gt=0.0)
    beyond_m: float = setting("past the end of the manoeuvre, others are ignored", ge=0.0)


@settings
class PassConfig:
    width_m: float = setting("an obstacle that is wider may be a truck", gt=0.0)
    length_m: float = setting("Length of a truck.", gt=0.0)


@settings
class RelocationConfig:
    """The lane is known by odometry during a manoeuvre, until the camera sees it there."""

    lateral_m: float = setting("difference between camera and odometry, at most", gt=0.0)
    heading_rad: float = setting("difference between camera and odometry, at most", gt=0.0)
    way_m: float = setting("along the road, after which odometry is not trusted", gt=0.0)


@settings
class RecoveryConfig:
    """When a manoeuvre is searched for and how it is driven."""

    standing_s: float = setting("at standstill, before the first search", gt=0.0)
    again_s: float = setting("between two searches", gt=0.0)
    clearance_m: float = setting("to obstacles", gt=0.0)
    speed_mps: float = setting("on the manoeuvre", gt=0.0)
    steering_mps: float = setting("while the wheels are turned", gt=0.0)
    steering_radps: float = setting("rate of the steering", gt=0.0)
    measured_mps: float = setting("speed from which on the yaw rate gives the steering angle", gt=0.0)
    ahead_m: float = setting("obstacles that are farther away are ignored", gt=0.0)
    back_rad: float = setting("from the road's direction: a car turned by less is along the road", gt=0.0)
    settling_m: float = setting("straight on after the end: the car lags behind", ge=0.0)
    steering_ahead_m: float = setting("of the manoeuvre, on which a turn of the wheels slows the car", gt=0.0)
    correction_rad_per_m: float = setting("feedback of the lateral error into the heading", gt=0.0)
    correction_rad: float = setting("largest feedback", gt=0.0)
    candidates: CandidatesConfig
    cost: CostConfig
    tight_share: float | None = setting("Share of the clearance that is enough if nothing else is free.", default=None)
    begin: BeginConfig | None = setting("May begin as near to an obstacle as the car stands.", default=None)
    recheck_share: float | None = setting("Gives up where the rest keeps less of the clearance.", default=None)
    new_obstacles: NewObstacleConfig | None = setting("Considers narrow obstacles detected on the way.", default=None)
    passing: PassConfig | None = setting("Ends only past all obstacles that may be long.", default=None)
    relocation: RelocationConfig | None = setting("Keeps the lane by odometry until it is seen again.", default=None)
