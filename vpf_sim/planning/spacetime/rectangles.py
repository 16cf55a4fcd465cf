"""Distances between the car and objects, which are rectangles.

Two rectangles are apart if an axis of one of them separates them (Gottschalk, Lin, Manocha 1996,
doi:10.1145/237170.237244).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vpf_sim.scene.prediction import Prediction
from vpf_sim.types import Integers, Reals, VehicleModel

ALONG_SHARE = np.float32(0.4)  # a metre ahead is as near as so much to the side
LEAST_RATE = np.float32(1e-6)


@dataclass(frozen=True, slots=True)
class Rectangles:
    """Cars or objects, in arrays of one shape or of shapes that spread to one."""

    x_m: Reals
    y_m: Reals
    cosine: Reals  # of the heading
    sine: Reals
    half_length_m: Reals
    half_width_m: Reals

    @classmethod
    def of_car(cls, pose: Sequence[Reals], vehicle: VehicleModel) -> "Rectangles":
        """The car at some places, by x m, y m and heading rad."""
        x_m, y_m, heading_rad = pose
        size = np.array([0.5 * vehicle.length_m, 0.5 * vehicle.width_m], np.float32)
        return cls(x_m, y_m, np.cos(heading_rad), np.sin(heading_rad), size[:1], size[1:])

    @classmethod
    def of_tracks(cls, prediction: Prediction, origin_m: tuple[float, float], quantile: float) -> "Rectangles":
        """(K, T) tracks, from an origin, larger by `quantile` standard deviations of their places."""
        size, heading = prediction.tracks, prediction.heading_rad
        values = (
            prediction.x_m - origin_m[0], prediction.y_m - origin_m[1], np.cos(heading), np.sin(heading),
            0.5 * size.length_m[:, None] + quantile * prediction.along_sigma_m,
            0.5 * size.width_m[:, None] + quantile * prediction.across_sigma_m,
        )  # fmt: skip
        return cls(*(value.astype(np.float32) for value in values))

    def at(self, *index: Integers | slice | int | None) -> "Rectangles":
        """Some of a two-dimensional array of them; a size that is the same for all stays so."""
        values = (getattr(self, name) for name in self.__slots__)
        return Rectangles(*(value[index] if value.ndim > 1 else value for value in values))


class Beside(NamedTuple):
    """Where objects are in the car's axes, in arrays."""

    dx: Reals  # m from the car's middle to theirs
    dy: Reals
    along: Reals  # m between their sides, along the car's heading
    across: Reals
    forward: Reals  # m to their middles
    same_way: Reals  # cosine and sine of the car's heading, in the objects' axes
    other_way: Reals


class Gaps(NamedTuple):
    """Distances between the car and an object along axes, in arrays; the largest is < 0 where they overlap."""

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
        """m, along the axis that shows most."""
        most: Reals = np.maximum.reduce([self.along, self.across, self.object_along, self.object_across])
        return most


def beside(car: Rectangles, other: Rectangles) -> Beside:
    """Objects as seen from cars, of shapes that spread to one."""
    dx, dy = other.x_m - car.x_m, other.y_m - car.y_m
    same_way = other.cosine * car.cosine + other.sine * car.sine
    other_way = other.cosine * car.sine - other.sine * car.cosine
    same, turned = np.abs(same_way), np.abs(other_way)
    forward, right = car.cosine * dx + car.sine * dy, car.cosine * dy - car.sine * dx
    along = np.abs(forward) - (car.half_length_m + same * other.half_length_m + turned * other.half_width_m)
    across = np.abs(right) - (car.half_width_m + turned * other.half_length_m + same * other.half_width_m)
    return Beside(dx, dy, along, across, forward, same_way, other_way)


def gaps(car: Rectangles, other: Rectangles) -> Gaps:
    """The distances between cars and objects, of shapes that spread to one."""
    dx, dy, along, across, forward, same_way, other_way = beside(car, other)
    same, turned = np.abs(same_way), np.abs(other_way)
    lengthwise, sideways = other.cosine * dx + other.sine * dy, other.cosine * dy - other.sine * dx
    object_along = np.abs(lengthwise) - (other.half_length_m + same * car.half_length_m + turned * car.half_width_m)
    object_across = np.abs(sideways) - (other.half_width_m + turned * car.half_length_m + same * car.half_width_m)
    return Gaps(along, across, object_along, object_across, forward, lengthwise, sideways, same_way, other_way)


def way_ahead(gap: Gaps, wider_m: float) -> Reals:
    """m straight ahead until the car, `wider_m` wider on each side, meets the object; inf where it passes.

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
    """Distance from the object, m, with lengths along the car's heading shortened to `ALONG_SHARE`."""
    same, turned = gap.same_way**2 / ALONG_SHARE**2, gap.other_way**2 / ALONG_SHARE**2
    lengthwise = gap.object_along / np.sqrt(same + gap.other_way**2)
    sideways = gap.object_across / np.sqrt(turned + gap.same_way**2)
    apart: Reals = np.maximum(np.maximum(gap.along * ALONG_SHARE, gap.across), np.maximum(lengthwise, sideways))
    return apart
