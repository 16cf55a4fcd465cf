"""The planner in space and time, on one page: candidates, limits, field, choice.

candidates -> limits -> field of road, target and comfort -> objects in space and time -> the least cost
"""

from collections.abc import Mapping
from dataclasses import replace
from math import tan

import numpy as np

from vpf_sim.geometry import bounded
from vpf_sim.planning.spacetime import candidates, limits
from vpf_sim.planning.spacetime.candidates import Paths, PathState, Profiles
from vpf_sim.planning.spacetime.field import ending_lanes, field
from vpf_sim.planning.spacetime.limits import REJECTED
from vpf_sim.planning.spacetime.motion import Motion, Rejected
from vpf_sim.planning.spacetime.motions import Motions, motions, path_second, rear_axle, rear_speed
from vpf_sim.planning.spacetime.obstacles import ObstaclePotential
from vpf_sim.planning.spacetime.settings import SpacetimeSettings
from vpf_sim.planning.spacetime.way import way_m
from vpf_sim.scene import Scene, predict
from vpf_sim.scene.road import stretch_at
from vpf_sim.types import Reals, VehicleModel

BATCH = 100  # motions that are compared with the objects at a time
ON_PLAN_M, ON_PLAN_RAD, ON_PLAN_MPS = 0.3, 0.1, 0.7  # a car that is nearer to its plan goes on from the plan
LARGEST_ANGLE_RAD = 0.9
SLOW_MPS = 0.3  # below it the yaw rate tells nothing of the curvature
SHARPEST_PER_M = 1.0  # of the own course; more is no car's
CHANGE_S, CHANGE_M = 1.0, 4.0  # ahead, at least, where a plan is compared with the last


class SpacetimePlanner:
    """Plans from scene to scene; it keeps its last motion."""

    def __init__(self, settings: SpacetimeSettings, vehicle: VehicleModel) -> None:
        self._settings, self._vehicle = settings, vehicle
        steps = round(settings.candidates.horizon_s / settings.candidates.step_s)
        self._times_s = settings.candidates.step_s * np.arange(steps + 1)
        self.motion: Motion | None = None

    def plan(self, scene: Scene) -> Motion:
        """The motion of least cost."""
        start = self._start(scene)
        paths, profiles = self._candidates(scene, start)
        considered = motions(scene.road, start, paths, profiles, self._vehicle)
        prices = limits.prices(self._settings.limits, considered, self._times_s, scene.road.overhang_m)
        objects = self._objects(scene, considered.origin_m)
        ways = way_m(scene, start, considered, self._vehicle, objects.quantile) - objects.standing_gap_m
        potentials = field(self._settings.cost, considered, ways, profiles, scene.road, scene.speed_reference_mps)
        beyond = self._ending_lanes(scene, start, paths)
        price = np.broadcast_to(sum(prices.values()), considered.shape).ravel()
        cost = sum(potentials.values()) + beyond[:, None] + self._changes(scene, start, paths, profiles)
        cost = np.broadcast_to(cost, considered.shape).ravel() + price
        best, least, contact_price, collisions = self._cheapest(objects, considered, cost)
        path, profile = (np.array([row]) for row in divmod(best, considered.shape[1]))
        rejected = _reasons(prices, considered.shape, collisions)
        broken = float(price[best]) + contact_price > REJECTED
        chosen_path, chosen_profile = paths.select(path), profiles.select(profile)
        self.motion = Motion(scene.time_s, start, chosen_path, chosen_profile, self._times_s, least, rejected, broken)
        return self.motion

    def _objects(self, scene: Scene, origin_m: tuple[float, float]) -> ObstaclePotential:
        prediction = predict(scene.road, scene.tracks, self._times_s)
        settings = self._settings
        return ObstaclePotential(
            settings.limits, settings.cost, prediction, self._times_s, self._vehicle, scene, origin_m
        )

    def _ending_lanes(self, scene: Scene, start: PathState, paths: Paths) -> Reals:
        return ending_lanes(self._settings.cost, scene.road, start, self._vehicle.width_m, paths.end_m)

    def _candidates(self, scene: Scene, start: PathState) -> tuple[Paths, Profiles]:
        settings, last = self._settings.candidates, self.motion
        kept_path, kept_mps = (None, None) if last is None else (last.path, self._last_speeds(scene.time_s))
        found = candidates.paths(settings, start, scene.road, self._vehicle.width_m, kept_path)
        return found, candidates.profiles(settings, start, scene.speed_reference_mps, self._times_s, kept_mps)

    def _last_speeds(self, time_s: float) -> Reals | None:
        """(T,) the last motion's speeds from now on."""
        last = self.motion
        if last is None:
            return None
        speeds: Reals = np.interp(self._times_s + time_s - last.time_s, last.times_s, last.profile.speed_mps[0])
        return speeds

    def _start(self, scene: Scene) -> PathState:
        """The last motion's state, or the car's where it has left that; the wheels of a car that stands may turn."""
        ego, last = scene.ego, self.motion
        s, own_d, angle = rear_axle(scene.road, ego.s_m, ego.d_m, ego.yaw_rad, self._vehicle)
        measured = self._measured(scene, s, own_d, angle)
        if last is None:
            return measured
        d, slope, bend = last.path_at(s)
        turned, speed = abs(angle - last.course_at(scene.road, s)), last.speed_at(scene.time_s)
        if abs(own_d - d) > ON_PLAN_M or turned > ON_PLAN_RAD or abs(ego.speed_mps - speed) > ON_PLAN_MPS:
            return measured
        limit = self._settings.limits
        acceleration = min(max(last.acceleration_at(scene.time_s), -limit.deceleration_mps2), limit.acceleration_mps2)
        if ego.speed_mps < SLOW_MPS:
            return replace(measured, speed_mps=speed, acceleration_mps2=acceleration)
        return PathState(s, d, slope, bend, speed, acceleration)

    def _measured(self, scene: Scene, s_m: float, d_m: float, angle_rad: float) -> PathState:
        """The state of the rear axle at a place on the road, turned from its direction there by an angle."""
        ego, bend = scene.ego, scene.road.direction_at(s_m)[1]
        stretch, turn = stretch_at(bend, d_m), tan(bounded(angle_rad, LARGEST_ANGLE_RAD))
        speed = rear_speed(ego.speed_mps, ego.yaw_rate_radps, self._vehicle)
        own = bounded(ego.yaw_rate_radps / speed, SHARPEST_PER_M) if speed > SLOW_MPS else 0.0
        return PathState(s_m, d_m, turn * stretch, path_second(turn, own, bend, stretch), ego.speed_mps, 0.0)

    def _changes(self, scene: Scene, start: PathState, paths: Paths, profiles: Profiles) -> Reals:
        """(P, M) cost of another path and another speed, soon, than in the last plan.

        Paths are compared some metres ahead also while the car is slow, so that it keeps to its way.
        """
        last = self.motion
        if last is None:
            return np.zeros((1, 1))
        soon = round(CHANGE_S / self._settings.candidates.step_s)
        there = np.array([start.s_m + max(start.speed_mps * CHANGE_S, CHANGE_M)])
        aside = np.abs(paths.at(there[None])[0] - last.path.at(there)[0])
        faster = np.abs(profiles.speed_mps[:, soon] - last.speed_at(scene.time_s + CHANGE_S))
        changed: Reals = self._settings.cost.change_side * aside + self._settings.cost.change_speed * faster
        return changed

    def _cheapest(self, objects: ObstaclePotential, considered: Motions, cost: Reals) -> tuple[int, float, float, int]:
        """Row, cost and price of contacts of the cheapest motion, and how many others meet an object.

        The objects' cost is >= 0, so the motions are gone through from the cheapest until none can be better.
        """
        order = np.argsort(cost, kind="stable")
        best, least, price, collisions = int(order[0]), np.inf, 0.0, 0
        for first in range(0, len(order), BATCH):
            rows = order[first : first + BATCH]
            if cost[rows[0]] >= least:
                break
            contact, near = objects.of(considered, rows)
            collisions += int((contact > REJECTED).sum())
            total = cost[rows] + contact + near
            if total.min() < least:
                index = int(np.argmin(total))
                best, least, price = int(rows[index]), float(total[index]), float(contact[index])
        return best, least, price, collisions


def _reasons(prices: Mapping[str, Reals], shape: tuple[int, ...], collisions: int) -> Rejected:
    """The number of rejected candidates by the limit that they break most; of objects, as far as they were compared."""
    table = np.stack([np.broadcast_to(price, shape).ravel() for price in prices.values()])
    is_rejected = table.sum(axis=0) > REJECTED
    counts = np.bincount(table[:, is_rejected].argmax(axis=0), minlength=len(table)).tolist()
    return Rejected(**dict(zip(prices, counts, strict=True)), collision=collisions)
