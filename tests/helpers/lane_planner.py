"""Parts of the lane planner with the settings of the variant `robust`."""

import driver_settings
from driver_settings import unwrap

from vpf_sim.driver_interface import DriverSetup
from vpf_sim.planning.lane.frame import Lane, LaneObstacles
from vpf_sim.planning.lane.kinematic_limits import KinematicLimits
from vpf_sim.planning.lane.lane_settings import LanePlannerConfig
from vpf_sim.planning.lane.lateral_cost import LateralCost
from vpf_sim.planning.lane.lateral_path import LateralPath
from vpf_sim.planning.lane.obstacle_geometry import ObstacleGeometry
from vpf_sim.planning.lane.planner import LanePlanner
from vpf_sim.planning.lane.recovery import Recovery
from vpf_sim.planning.lane.reference import LaneReference
from vpf_sim.planning.lane.speed.limits import SpeedLimits
from vpf_sim.planning.visibility import SpeedInSight
from vpf_sim.types import Camera, VehicleModel

CAR, SPEED_MPS, RATE_HZ = VehicleModel(), 5.55, 60.0
HALF_M, BUMPER_M = 0.5 * CAR.width_m, 0.5 * CAR.length_m


def driver_setup(speed_mps: float = SPEED_MPS, rate_hz: float = RATE_HZ) -> DriverSetup:
    return DriverSetup(Camera(), CAR, rate_hz, speed_mps, (1e3, 0.0), 0)


ROBUST, SETUP = unwrap(driver_settings.ROBUST.lane_planner), driver_setup()
CLEARANCE, BRAKING = ROBUST.clearance, ROBUST.braking
SPEED, PATH, RECOVERY = unwrap(ROBUST.speed), unwrap(ROBUST.path), unwrap(ROBUST.recovery)
LIMITS = KinematicLimits(ROBUST, CAR)


def lane_planner(setup: DriverSetup = SETUP, config: LanePlannerConfig = ROBUST) -> LanePlanner:
    return LanePlanner(setup, config, SpeedInSight(unwrap(driver_settings.ROBUST.visibility), setup))


def geometry(obstacles: LaneObstacles) -> ObstacleGeometry:
    return ObstacleGeometry(obstacles, ROBUST, SETUP)


def lateral_cost(last_m: float | None = None) -> LateralCost:
    """With a minimum that was chosen before, if any."""
    cost = LateralCost(ROBUST, SETUP, LIMITS)
    if last_m is not None:
        cost.keep(last_m)
    return cost


def lane_reference(speed_mps: float = SPEED_MPS, rate_hz: float = RATE_HZ) -> LaneReference:
    return LaneReference(ROBUST, driver_setup(speed_mps, rate_hz), LIMITS)


def speed_limits() -> SpeedLimits:
    return SpeedLimits(SPEED, ROBUST, SETUP, LIMITS)


def lateral_path(y_m: float, shift_m: float) -> LateralPath:
    return LateralPath(PATH, LIMITS, y_m, shift_m)


def recovery() -> Recovery:
    return Recovery(RECOVERY, ROBUST, SETUP)


def straight_lane(y_m: float = 0.0, left_m: float = -8.75, right_m: float = 5.25) -> Lane:
    return Lane(y_m, right_m, left_m, 0.0, 0.0)
