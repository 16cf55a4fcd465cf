"""Settings of the recovery from a dead end."""

from vpf_sim.configuration import setting, settings


@settings
class CandidatesConfig:
    """The manoeuvres that are compared: a turn, a straight and a turn back."""

    way_m: float = setting("Length of a manoeuvre that is checked.", gt=0.0)
    locks: tuple[float, ...] = setting("Shares of the full steering lock, tried in this order.", min_length=1)
    angles_deg: tuple[float, ...] = setting("Largest angles of a manoeuvre to the road.", min_length=1)
    straight_m: float = setting("Longest straight of a manoeuvre.", gt=0.0)
    aside_m: float = setting("Lateral distance between two candidates.", gt=0.0)
    beyond_m: float = setting("Distance behind its end over which a candidate must be free.", ge=0.0)


@settings
class CostConfig:
    """Costs in rad: the largest angle to the road counts in full."""

    clearance_per_m: float = setting("Cost that a metre of clearance saves.", ge=0.0)
    enough_m: float = setting("Clearance from which on more is no better.", gt=0.0)
    length_per_m: float = setting("Cost of a metre of length.", ge=0.0)


@settings
class BeginConfig:
    way_m: float = setting("Length of a manoeuvre.", gt=0.0)
    least_m: float = setting("Least clearance on the manoeuvre.", gt=0.0)


@settings
class NewObstacleConfig:
    width_m: float = setting("Width from which obstacles that are detected during the manoeuvre are ignored.", gt=0.0)
    beyond_m: float = setting("Distance past the end of the manoeuvre from which other obstacles are ignored.", ge=0.0)


@settings
class PassConfig:
    width_m: float = setting("Width from which an obstacle may be a truck.", gt=0.0)
    length_m: float = setting("Length of a truck.", gt=0.0)


@settings
class RelocationConfig:
    """The lane is known by odometry during a manoeuvre, until the camera sees it there."""

    lateral_m: float = setting("Largest lateral difference between camera and odometry.", gt=0.0)
    heading_rad: float = setting("Largest difference of the heading between camera and odometry.", gt=0.0)
    way_m: float = setting("Distance along the road after which odometry is not trusted.", gt=0.0)


@settings
class RecoveryConfig:
    """When a manoeuvre is searched for and how it is driven."""

    standing_s: float = setting("Time at standstill before the first search.", gt=0.0)
    again_s: float = setting("Time between two searches.", gt=0.0)
    clearance_m: float = setting("Clearance to obstacles on a manoeuvre.", gt=0.0)
    speed_mps: float = setting("Speed on a manoeuvre.", gt=0.0)
    steering_mps: float = setting("Speed while the wheels are turned.", gt=0.0)
    steering_radps: float = setting("Rate of the steering on a manoeuvre.", gt=0.0)
    measured_mps: float = setting("Speed from which on the yaw rate gives the steering angle.", gt=0.0)
    ahead_m: float = setting("Distance from which on obstacles are ignored.", gt=0.0)
    back_rad: float = setting("Angle to the road's direction below which a car is along the road.", gt=0.0)
    settling_m: float = setting("Length of the straight after the end, since the car lags behind.", ge=0.0)
    steering_ahead_m: float = setting("Length of the manoeuvre on which a turn of the wheels slows the car.", gt=0.0)
    correction_rad_per_m: float = setting("Feedback of the lateral error into the heading.", gt=0.0)
    correction_rad: float = setting("Largest feedback of the lateral error into the heading.", gt=0.0)
    candidates: CandidatesConfig
    cost: CostConfig
    tight_share: float | None = setting("Share of the clearance that is enough if nothing else is free.", default=None)
    begin: BeginConfig | None = setting("May begin as near to an obstacle as the car stands.", default=None)
    recheck_share: float | None = setting("Gives up where the rest keeps less of the clearance.", default=None)
    new_obstacles: NewObstacleConfig | None = setting("Considers narrow obstacles detected on the way.", default=None)
    passing: PassConfig | None = setting("Ends only past all obstacles that may be long.", default=None)
    relocation: RelocationConfig | None = setting("Keeps the lane by odometry until it is seen again.", default=None)
