"""The ego car: the paper's kinematic bicycle with actuator limits."""

from collections.abc import Mapping
from math import asin, atan, cos, hypot, sin, tan

import numpy as np
from highway_env.road.road import Road
from highway_env.vehicle.kinematics import Vehicle

from vpf_sim.envs.network import Network
from vpf_sim.scenarios.kinds import EGO_SIZE, ObjectKind
from vpf_sim.types import Floats, VehicleModel

MAX_SPEED_MPS = 60.0
YAW_RATE_LIMIT_RADPS = 4.0  # range of the sensor
GRAVITY_MPS2 = 9.81


class Ego(Vehicle):  # type: ignore[misc]
    """Kinematic bicycle about the centre of mass (paper, VI), slip angle beta = atan(l_r / (l_f + l_r) tan delta):

        x' = v cos(psi + beta),  y' = v sin(psi + beta),  psi' = v sin(beta) / l_r,  v' = a >= -v / dt.

    One step is an arc: its curvature is that of the mean steering angle, its length the exact distance under constant
    acceleration. So a constant steering angle keeps the car on its circle at every step size. The steering angle
    follows its command at a limited rate. Braking ends at standstill.

    With a friction coefficient mu the total acceleration is limited to mu g (friction circle: Rajamani, Vehicle
    Dynamics and Control, 2012, ch. 13). Beyond it, both components are scaled down alike: the car brakes less and runs
    wide. Without a coefficient the tyres never slip.
    """

    LENGTH = EGO_SIZE.length_m
    WIDTH = EGO_SIZE.width_m
    HEIGHT = EGO_SIZE.height_m
    MAX_SPEED = MAX_SPEED_MPS
    MIN_SPEED = 0.0
    kind: ObjectKind = "car"

    road: Road
    position: Floats  # (2,) m
    heading: float  # rad
    speed: float  # m/s
    action: dict[str, float]

    def __init__(
        self, road: Road, position: Floats, heading: float = 0.0, speed: float = 0.0, friction: float | None = None
    ) -> None:
        self.model = VehicleModel()
        self.friction = friction
        self.steering_rad = 0.0
        self.place = (0.0, 0.0)  # s, lateral on the road's reference line
        super().__init__(road, position, heading, speed)
        self.on_state_update()

    def act(self, action: Mapping[str, float] | None = None) -> None:
        """Hold a command, {"acceleration": m/s2, "steering": rad}, until the next; the mapping is copied."""
        if action is not None:
            self.action = dict(action)

    def step(self, dt: float) -> None:
        """Move for dt seconds. highway-env's `impact`, which displaces objects on contact, is ignored."""
        before_rad = self.steering_rad
        self.steering_rad = self._steer(dt)
        beta, acceleration = self._held(0.5 * (before_rad + self.steering_rad))
        distance_m = self._accelerate(acceleration, dt)
        turn_rad = distance_m * sin(beta) / self.model.l_r_m
        half_turn = 0.5 * turn_rad
        chord_m = distance_m if abs(half_turn) < 1e-9 else distance_m * sin(half_turn) / half_turn
        direction = self.heading + beta + half_turn
        self.position = self.position + chord_m * np.array([cos(direction), sin(direction)])
        self.heading = self.heading + turn_rad
        self.impact = None
        self.on_state_update()

    def _steer(self, dt: float) -> float:
        """The steering angle after dt, within the limits of angle and rate."""
        limit, most = self.model.steering_limit_rad, self.model.steering_rate_limit_radps * dt
        wanted = min(max(float(self.action["steering"]), -limit), limit)
        return self.steering_rad + min(max(wanted - self.steering_rad, -most), most)

    def _accelerate(self, acceleration: float, dt: float) -> float:
        """Update the speed and return the distance travelled; a car that stops within dt travels less."""
        before_mps = self.speed
        after_mps = before_mps + acceleration * dt
        self.speed = min(max(after_mps, 0.0), MAX_SPEED_MPS)
        if after_mps < 0.0:
            return -0.5 * before_mps**2 / acceleration
        return 0.5 * (before_mps + self.speed) * dt

    def _slip_rad(self, steering_rad: float) -> float:
        """Angle from the heading to the velocity of the centre of mass."""
        return atan(self.model.l_r_m / self.model.wheelbase_m * tan(steering_rad))

    def _held(self, steering_rad: float) -> tuple[float, float]:
        """Slip angle and acceleration for a steering angle and the command, within the friction circle."""
        beta, along = self._slip_rad(steering_rad), float(self.action["acceleration"])
        if self.friction is None:
            return beta, along
        requested = hypot(along, self.speed**2 * sin(beta) / self.model.l_r_m)
        held = self.friction * GRAVITY_MPS2
        if requested <= held:
            return beta, along
        return asin(sin(beta) * held / requested), along * held / requested

    @property
    def yaw_rate_radps(self) -> float:
        return self.speed * sin(self._held(self.steering_rad)[0]) / self.model.l_r_m

    @property
    def velocity(self) -> Floats:
        """(2,) m/s of the centre of mass, with the slip angle."""
        course = self.heading + self._held(self.steering_rad)[0]
        return self.speed * np.array([cos(course), sin(course)])

    def on_state_update(self) -> None:
        """Update the car's place on the road and its lane."""
        network: Network = self.road.network
        self.place = network.place_at(float(self.position[0]), float(self.position[1]), self.place[0])
        self.lane_index = network.lane_of(self)
        self.lane = network.get_lane(self.lane_index)

    def predict_trajectory_constant_speed(self, times: Floats) -> tuple[list[Floats], list[float]]:
        """Positions and headings at some times, s, at constant speed and steering angle.

        highway-env's cars look ahead with it when they yield; its own version copies the whole road.
        """
        radius_inverse = sin(self._slip_rad(self.steering_rad)) / self.model.l_r_m
        course = self.heading + self._slip_rad(self.steering_rad)
        positions, headings = [], []
        for time_s in times:
            distance_m = self.speed * float(time_s)
            half_turn = 0.5 * distance_m * radius_inverse
            chord_m = distance_m if abs(half_turn) < 1e-9 else distance_m * sin(half_turn) / half_turn
            direction = course + half_turn
            positions.append(self.position + chord_m * np.array([cos(direction), sin(direction)]))
            headings.append(self.heading + 2.0 * half_turn)
        return positions, headings
