"""The potential of objects in space and time: occupied places, nearness, and distance behind who drives ahead.

An object's rectangle grows by the quantile of its uncertainty: a place inside is occupied with more than the stated
probability.
"""

from math import hypot

import numpy as np
from scipy.special import ndtri

from vpf_sim.planning.spacetime.motions import Motions
from vpf_sim.planning.spacetime.rectangles import ALONG_SHARE, Gaps, Rectangles, beside, gaps, nearness_m, way_ahead
from vpf_sim.planning.spacetime.settings import CostSettings, LimitSettings
from vpf_sim.scene.prediction import Prediction
from vpf_sim.scene.scene import EgoState, Scene
from vpf_sim.types import Bools, Integers, Reals, VehicleModel

PER_CONTACT = 600.0
CONTACT_S = 2.5  # a contact counts e times less so much later: the motion will have been planned again
NEAR_S = 4.0  # and nearness
IN_LANE_M = 0.25  # who is nearer to the own path, across, is followed
BRAKING_MPS2 = 5.5  # of the braking distance, for both cars
REACTION_S = 0.3
TURNED = 0.8  # of the largest curvature, with which a car that stands turns away: it drives while its wheels turn
GAP_S = 0.9
DEEP_M = 0.4  # overlap of the car with an object and the distance to be kept from it, from which the price is full
STANDING_MPS, STANDING_SHARE = 0.1, np.float32(0.5)  # of the price, where the car stands and is hit
BESIDE_M = 0.1  # a track that would pass the car by more does not follow it
NEAR_SCALES = np.float32(6.0)  # in which the potential of an object falls to 0


def turning_gap_m(vehicle: VehicleModel, curvature_per_m: float) -> float:
    """m before a wall from which the car can turn away from it: how far its outer corner moves forward in a circle."""
    front_m = vehicle.l_r_m + 0.5 * vehicle.length_m
    return hypot(front_m, 1.0 / curvature_per_m + 0.5 * vehicle.width_m) - front_m


class ObstaclePotential:
    """The objects' part of the field, for one scene and motions from one origin."""

    def __init__(
        self,
        limits: LimitSettings,
        cost: CostSettings,
        prediction: Prediction,
        times_s: Reals,
        vehicle: VehicleModel,
        scene: Scene,
        origin_m: tuple[float, float],
    ) -> None:
        self._limits, self._cost = limits, cost
        tracks = np.flatnonzero(~_follows(prediction, scene.ego, vehicle))
        self._speed_mps = prediction.tracks.speed_mps[tracks].astype(np.float32)
        self._vehicle, self._reference_mps = vehicle, scene.speed_reference_mps
        self.standing_gap_m = np.float32(turning_gap_m(vehicle, TURNED * limits.curvature_per_m))
        self.quantile = float(ndtri(1.0 - limits.occupied))
        self._objects = Rectangles.of_tracks(prediction, origin_m, self.quantile).at(tracks)
        self._contact_decay = np.exp(-times_s / CONTACT_S).astype(np.float32)
        self._near_decay = np.exp(-times_s / NEAR_S).astype(np.float32)

    def of(self, motions: Motions, rows: Integers) -> tuple[Reals, Reals]:
        """(R,) price of contacts, and (R,) cost of nearness and short distances, of some motions.

        `rows` are those of the motions in the flattened (P, M).
        """
        path, profile = np.divmod(rows, motions.shape[1])
        poses = [motions.along(values, path, profile) for values in motions.poses]
        car, speeds = Rectangles.of_car(poses, self._vehicle), motions.speed_mps[profile]
        n, k, t = np.nonzero(self._in_reach(car.at(slice(None), None), speeds))
        gap = gaps(car.at(n, t), self._objects.at(k, t))
        speed, other = speeds[n, t], self._speed_mps[k] * gap.same_way
        contact = np.zeros(len(rows), np.float32)
        np.maximum.at(contact, n, np.where(t > 0, self._contact(gap, t, speed, other), np.float32(0.0)))
        near = self._nearness(gap, t, speed) + self._distance_behind(gap, speed, other)
        return PER_CONTACT * contact, np.bincount(n, near, len(rows)) / speeds.shape[1]

    def _in_reach(self, car: Rectangles, speeds: Reals) -> Bools:
        """(R, K, T) whether the car is near enough to an object for any cost."""
        seen = beside(car, self._objects)
        limits = self._limits
        near = max(float(NEAR_SCALES) * self._cost.near_scale_m, limits.along_m, limits.across_m)
        stopping = np.maximum(REACTION_S * speeds + 0.5 * speeds**2 / BRAKING_MPS2, GAP_S * speeds)
        ahead = (stopping + self.standing_gap_m)[:, None]
        found: Bools = (seen.along * ALONG_SHARE < near) & (seen.across < near)
        found |= (seen.across < IN_LANE_M) & (seen.forward > 0.0) & (seen.along < ahead)
        return found

    def _contact(self, gap: Gaps, t: Integers, speed: Reals, other: Reals) -> Reals:
        """Price of an occupied place: more for a hard impact, a deep overlap, and soon."""
        limits = self._limits
        apart = np.maximum(
            np.maximum(gap.along - limits.along_m, gap.across - limits.across_m),
            np.maximum(gap.object_along, gap.object_across) - limits.across_m,
        )
        impact = 0.4 + 0.15 * np.minimum(np.abs(speed - np.maximum(other, 0.0)), 12.0)
        share = np.where(speed < STANDING_MPS, STANDING_SHARE, np.float32(1.0))
        price = self._contact_decay[t] * share * impact * np.minimum(-apart / DEEP_M, np.float32(1.0))
        return np.where(apart < 0.0, price, np.float32(0.0))

    def _nearness(self, gap: Gaps, t: Integers, speed: Reals) -> Reals:
        """Potential of an object: more beside it than behind it, and at speed."""
        scales = np.clip(nearness_m(gap) / np.float32(self._cost.near_scale_m), 0.0, NEAR_SCALES)
        share = 0.15 + speed / (self._reference_mps + 0.1)
        potential: Reals = self._cost.near * (np.exp(-scales) - np.exp(-NEAR_SCALES)) * share * self._near_decay[t]
        return potential

    def _distance_behind(self, gap: Gaps, speed: Reals, other: Reals) -> Reals:
        """Cost of less than the braking distance, and of less than a second, behind what is ahead."""
        ahead = way_ahead(gap, IN_LANE_M) - self.standing_gap_m
        closing = np.maximum(speed**2 - np.maximum(other, 0.0) ** 2, 0.0)
        braking = np.maximum(REACTION_S * speed + 0.5 * closing / BRAKING_MPS2 - ahead, 0.0)
        second = np.maximum(GAP_S * speed - ahead, 0.0)
        cost: Reals = self._cost.follow * braking**2 / (1.0 + 0.05 * speed**2)
        cost += self._cost.time_gap * second**2 / (1.0 + 0.02 * speed**2)
        return cost


def _follows(prediction: Prediction, ego: EgoState, vehicle: VehicleModel) -> Bools:
    """(K,) whether a track drives behind the car on its part of the road: it brakes for it."""
    tracks = prediction.tracks
    behind = prediction.on_road & (prediction.along_mps > 0.0) & (tracks.s_m < ego.s_m)
    follows: Bools = behind & (np.abs(tracks.d_m - ego.d_m) < 0.5 * (tracks.width_m + vehicle.width_m) + BESIDE_M)
    return follows
