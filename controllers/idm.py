"""highway-env's driver for the ego car: IDM along the lane, MOBIL for lane changes.

Intelligent Driver Model: M. Treiber, A. Hennecke, D. Helbing, Phys. Rev. E 62, 1805, 2000. Lane changes by MOBIL:
A. Kesting, M. Treiber, D. Helbing, Transp. Res. Rec. 1999, 86, 2007. Parameters: highway-env's IDMVehicle.
Its steering is a heading controller with time constants T_y (lateral) and T_h (heading): near the centre of a straight
lane the offset y obeys y'' + y' / T_h + y / (T_h T_y) = 0. It is privileged: it reads all objects on the road and uses
no frame.
"""

from math import hypot

from highway_env.road.road import Road
from highway_env.vehicle.behavior import IDMVehicle
from highway_env.vehicle.kinematics import Vehicle

from vpf_sim import configuration
from vpf_sim.configuration import setting, settings
from vpf_sim.driver_interface import Command, DriverSetup, Observation
from vpf_sim.seeding import stream


@settings
class Gains:
    lateral_s: float = setting("Time T_y in which an offset from the lane's centre is corrected.", gt=0.0)
    heading_s: float = setting(
        "Time T_h in which the heading is corrected, and how far ahead the lane's heading is read.", gt=0.0
    )


def load_gains() -> Gains:
    """The section [idm] of gains.toml."""
    table = configuration.read("vpf_sim.controllers", "gains.toml")["idm"]
    return configuration.build(Gains, table, "gains.toml: [idm]")


class EgoCopy(IDMVehicle):  # type: ignore[misc]
    """An IDMVehicle that copies the ego's state and never moves by itself."""

    # highway-env's defaults, held here since its intersection changes those of its class for the whole process
    COMFORT_ACC_MAX, COMFORT_ACC_MIN, DISTANCE_WANTED = 3.0, -5.0, 10.0

    def __init__(self, gains: Gains, road: Road, observation: Observation, setup: DriverSetup) -> None:
        place = (observation.x_m, observation.y_m)
        route = list(getattr(road.network, "route_lanes", ())) or None
        target_mps = setup.speed_reference_mps
        super().__init__(road, place, observation.yaw_rad, observation.speed_mps, target_speed=target_mps, route=route)
        # Its steering law assumes axles half the length before and behind the centre; the ego's are nearer.
        self.LENGTH = setup.vehicle.wheelbase_m
        self.KP_LATERAL, self.KP_HEADING = 1.0 / gains.lateral_s, 1.0 / gains.heading_s
        self.TAU_PURSUIT = gains.heading_s  # so that the command matches a bend's yaw rate

    def sync(self, observation: Observation, elapsed_s: float) -> None:
        """Copy the ego's state and advance the timer."""
        self.position[:] = observation.x_m, observation.y_m
        self.heading, self.speed = observation.yaw_rad, observation.speed_mps
        self.timer += elapsed_s
        self.on_state_update()


class Idm:
    """Accelerates, brakes and changes lanes on a highway-env road, which it only reads."""

    def __init__(self, gains: Gains, setup: DriverSetup, world: Road) -> None:
        self._gains = gains
        self._setup = setup
        self._world = world
        self._copy: EgoCopy | None = None
        self._ego: Vehicle | None = None

    def command(self, observation: Observation) -> Command:
        """The command for one step of 1 / rate_hz."""
        if self._copy is None:
            self._copy = self._new_copy(observation)
        else:
            self._copy.sync(observation, 1.0 / self._setup.rate_hz)
        self._copy.road.vehicles = [vehicle for vehicle in self._world.vehicles if vehicle is not self._ego]
        self._copy.act()
        vehicle, action = self._setup.vehicle, self._copy.action
        acceleration = float(action["acceleration"])
        throttle = acceleration / vehicle.full_mps2(acceleration)
        steering = float(action["steering"]) / vehicle.steering_limit_rad
        return Command(min(max(throttle, -1.0), 1.0), min(max(steering, -1.0), 1.0))

    def _new_copy(self, observation: Observation) -> EgoCopy:
        """The copy on its own road, which has the world's lanes and objects.

        The ego is the vehicle nearest to the observation. `neighbour_vehicles_connected_lanes` includes leaders on the
        next segment of a lane.
        """
        here, world = [observation.x_m, observation.y_m], self._world
        self._ego = min(world.vehicles, key=lambda other: hypot(*(other.position - here)))
        road = Road(
            network=world.network,
            road_objects=list(world.objects),
            np_random=stream(self._setup.seed, "idm"),
            neighbour_vehicles_connected_lanes=True,
        )
        return EgoCopy(self._gains, road, observation, self._setup)
