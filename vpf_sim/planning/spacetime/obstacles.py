"""The potential of objects in space and time: occupied places, nearness, and distance behind who drives ahead.

An object's rectangle grows by the quantile of its uncertainty: a place inside is occupied with more than the stated
probability. Two rectangles are apart if an axis of one of them separates them (Gottschalk, Lin, Manocha 1996,
doi:10.1145/237170.237244).
"""

from dataclasses import dataclass
from math import hypot
from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

from vpf_sim.planning.spacetime.motions import Motions
from vpf_sim.planning.spacetime.settings import CostSettings, LimitSettings
from vpf_sim.scene.prediction import Prediction
from vpf_sim.scene.scene import EgoState, Scene
from vpf_sim.types import Bools, Integers, Reals, VehicleModel

PER_CONTACT = 600.0
CONTACT_S = 2.5  # a contact counts e times less so much later: the motion will have been planned again
NEAR_S = 4.0  # and nearness
ALONG_SHARE = 0.4  # a metre ahead is as near as so much to the side
IN_LANE_M = 0.25  # who is nearer to the own path, across, is followed
BRAKING_MPS2 = 5.5  # of the braking distance, for both cars
REACTION_S = 0.3
TURNED = 0.8  # of the largest curvature, with which a car that stands turns away: it drives while its wheels turn
GAP_S = 0.9
DEEP_M = 0.4  # overlap of the car with an object and the distance to be kept from it, from which the price is full
STANDING_MPS, STANDING_SHARE = 0.1, np.float32(0.5)  # of the price, where the car stands and is hit
BESIDE_M = 0.1  # a track that would pass the car by more does not follow it
LEAST_RATE = np.float32(1e-6)
OUT_OF_REACH_M = 40.0


class Gaps(NamedTuple):
    """Distances between the car and an object along axes, (N, T) each; the largest is < 0 where they overlap."""

    along: Reals  # the car's axes
    across: Reals
    object_along: Reals  # the object's axes
    object_across: Reals
    forward: Reals  # place of the object's middle, in the car's axes
    lengthwise: Reals  # and from the car's middle, in the object's axes
    sideways: Reals
    same_way: Reals  # of the car's heading, in the object's axes
    other_way: Reals

    @property
    def largest(self) -> Reals:
        """(N, T) m, along the axis that shows most."""
        most: Reals = np.maximum.reduce([self.along, self.across, self.object_along, self.object_across])
        return most


@dataclass(frozen=True, slots=True)
class Body:
    """The car's rectangles along N motions at T times, from the motions' origin."""

    x_m: Reals
    y_m: Reals
    cosine: Reals
    sine: Reals
    speed_mps: Reals
    half_length_m: float
    half_width_m: float

    @classmethod
    def of(cls, motions: Motions, rows: Integers, vehicle: VehicleModel) -> "Body":
        """The bodies of some motions, by their rows in the flattened (P, M)."""
        p, m = np.unravel_index(rows, motions.d_m.shape[:2])
        heading = motions.heading_rad[p, m]
        place = motions.x_m[p, m], motions.y_m[p, m]
        size = 0.5 * vehicle.length_m, 0.5 * vehicle.width_m
        return cls(*place, np.cos(heading), np.sin(heading), motions.speed_mps[0, m], *size)


def gaps(body: Body, prediction: Prediction, k: int, origin_m: tuple[float, float], quantile: float) -> Gaps:
    """The distances from track k, grown by `quantile` standard deviations."""
    x, y = prediction.x_m[k] - origin_m[0], prediction.y_m[k] - origin_m[1]
    dx, dy = np.float32(x) - body.x_m, np.float32(y) - body.y_m
    heading = prediction.heading_rad[k]
    cosine, sine = np.cos(heading).astype(np.float32), np.sin(heading).astype(np.float32)
    half_length = np.float32(0.5 * prediction.tracks.length_m[k] + quantile * prediction.along_sigma_m[k])
    half_width = np.float32(0.5 * prediction.tracks.width_m[k] + quantile * prediction.across_sigma_m[k])
    same_way, other_way = cosine * body.cosine + sine * body.sine, cosine * body.sine - sine * body.cosine
    same, turned = np.abs(same_way), np.abs(other_way)
    forward, right = body.cosine * dx + body.sine * dy, body.cosine * dy - body.sine * dx
    lengthwise, sideways = cosine * dx + sine * dy, cosine * dy - sine * dx
    along = np.abs(forward) - (body.half_length_m + same * half_length + turned * half_width)
    across = np.abs(right) - (body.half_width_m + turned * half_length + same * half_width)
    object_along = np.abs(lengthwise) - (half_length + same * body.half_length_m + turned * body.half_width_m)
    object_across = np.abs(sideways) - (half_width + turned * body.half_length_m + same * body.half_width_m)
    return Gaps(along, across, object_along, object_across, forward, lengthwise, sideways, same_way, other_way)


def way_ahead(gap: Gaps, wider_m: float) -> Reals:
    """(N, T) m straight ahead until the car, `wider_m` wider on each side, meets the object; inf where it passes.

    They meet while they overlap along all axes: from the last axis's beginning to the first one's end.
    """
    begin, end = gap.along, 2.0 * gap.forward - gap.along
    axes = (gap.lengthwise, gap.object_along, gap.same_way), (gap.sideways, gap.object_across, gap.other_way)
    for (place, apart, rate), (_, _, other) in zip(axes, axes[::-1], strict=True):
        towards = np.where(rate < 0.0, -place, place)
        reach = np.abs(place) - apart + np.float32(wider_m) * np.abs(other)
        rate = np.maximum(np.abs(rate), LEAST_RATE)
        begin, end = np.maximum(begin, (towards - reach) / rate), np.minimum(end, (towards + reach) / rate)
    meets = (gap.forward > 0.0) & (gap.across < wider_m) & (begin < end)
    return np.where(meets, begin, np.float32(np.inf))


def nearness_m(gap: Gaps) -> Reals:
    """(N, T) distance from the object, with lengths along the car's heading shortened to `ALONG_SHARE`."""
    same, turned = gap.same_way**2 / ALONG_SHARE**2, gap.other_way**2 / ALONG_SHARE**2
    lengthwise = gap.object_along / np.sqrt(same + gap.other_way**2)
    sideways = gap.object_across / np.sqrt(turned + gap.same_way**2)
    apart: Reals = np.maximum(np.maximum(gap.along * ALONG_SHARE, gap.across), np.maximum(lengthwise, sideways))
    return apart


def turning_gap_m(vehicle: VehicleModel, curvature_per_m: float) -> float:
    """m before a wall from which the car can turn away from it: how far its outer corner moves forward in a circle."""
    front_m = vehicle.l_r_m + 0.5 * vehicle.length_m
    return hypot(front_m, 1.0 / curvature_per_m + 0.5 * vehicle.width_m) - front_m


class ObstaclePotential:
    """The objects' part of the field, for one scene."""

    def __init__(
        self,
        limits: LimitSettings,
        cost: CostSettings,
        prediction: Prediction,
        times_s: Reals,
        vehicle: VehicleModel,
        scene: Scene,
    ) -> None:
        self._limits, self._cost = limits, cost
        self._prediction = prediction
        self._follows = _follows(prediction, scene.ego, vehicle)
        self._vehicle, self._reference_mps = vehicle, scene.speed_reference_mps
        self.standing_gap_m = np.float32(turning_gap_m(vehicle, TURNED * limits.curvature_per_m))
        self.quantile = float(ndtri(1.0 - limits.occupied))
        self._contact_decay = np.exp(-times_s / CONTACT_S).astype(np.float32)
        self._near_decay = np.exp(-times_s / NEAR_S).astype(np.float32)

    def of(self, motions: Motions, rows: Integers) -> tuple[Reals, Reals]:
        """(N,) price of contacts, and (N,) cost of nearness and short distances, of some motions."""
        body = Body.of(motions, rows, self._vehicle)
        contact, near = np.zeros_like(body.x_m), np.zeros_like(body.x_m)
        for k in range(len(self._prediction.tracks)):
            if self._follows[k] or self._is_far(body, k, motions.origin_m):
                continue
            gap = gaps(body, self._prediction, k, motions.origin_m, self.quantile)
            speed = np.float32(self._prediction.tracks.speed_mps[k]) * gap.same_way
            contact = np.maximum(contact, self._contact(gap, body.speed_mps, speed))
            near += self._nearness(gap, body.speed_mps) + self._distance_behind(gap, body.speed_mps, speed)
        return PER_CONTACT * contact[:, 1:].max(axis=1), near.mean(axis=1)

    def _is_far(self, body: Body, k: int, origin_m: tuple[float, float]) -> bool:
        """Whether no motion comes near track k."""
        dx = self._prediction.x_m[k] - origin_m[0] - body.x_m
        dy = self._prediction.y_m[k] - origin_m[1] - body.y_m
        return float((np.abs(dx) + np.abs(dy)).min()) > OUT_OF_REACH_M + 0.8 * self._reference_mps

    def _contact(self, gap: Gaps, speed: Reals, other: Reals) -> Reals:
        """(N, T) price of an occupied place: more for a hard impact, a deep overlap, and soon."""
        limits = self._limits
        apart = np.maximum(
            np.maximum(gap.along - limits.along_m, gap.across - limits.across_m),
            np.maximum(gap.object_along, gap.object_across) - limits.across_m,
        )
        impact = 0.4 + 0.15 * np.minimum(np.abs(speed - np.maximum(other, 0.0)), 12.0)
        share = np.where(speed < STANDING_MPS, STANDING_SHARE, np.float32(1.0))
        price = self._contact_decay * share * impact * np.minimum(-apart / DEEP_M, np.float32(1.0))
        return np.where(apart < 0.0, price, np.float32(0.0))

    def _nearness(self, gap: Gaps, speed: Reals) -> Reals:
        """(N, T) potential of an object: more beside it than behind it, and at speed."""
        apart = np.maximum(nearness_m(gap), 0.0)
        share = 0.15 + speed / (self._reference_mps + 0.1)
        potential: Reals = self._cost.near * np.exp(-apart / self._cost.near_scale_m) * share * self._near_decay
        return potential

    def _distance_behind(self, gap: Gaps, speed: Reals, other: Reals) -> Reals:
        """(N, T) cost of less than the braking distance, and of less than a second, behind what is ahead."""
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
