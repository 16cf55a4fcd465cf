"""The velocity of tracked vehicles, by the motion of the image points on them.

With the place of a vehicle known, the motion of its points gives its velocity at once, whether it drives, brakes or
stands: no detection with a memory of its own follows a car that brakes hard. A point that shows the road behind does
not count. Above what stands, which may be low, other things are seen that stand farther away, and seem to drive off:
such a thing, at twice the distance or more, is above half the camera's height there.

The motion fixes the time to contact. A vehicle that drove our way and now seems to come is nearer than it was believed
to be, and stands: cars ahead do not reverse.
"""

from typing import NamedTuple

import numpy as np

from vpf_sim.perception.obstacles.point_motion import PointMotions
from vpf_sim.types import Bools, Camera, Floats

BESIDE_M, FACE_M = 0.1, 0.3  # points at least so far inside the sides; mean depth of a rear beyond its face
HEIGHTS_M = (0.15, 1.5)  # of points on it
STANDING_MPS, HIGHEST_SHARE = 0.4, 0.5  # a slower body stands; of the camera's height, below which its points are
ROAD_CHI2 = 9.0  # of a point as one of the road
PASSES, CHI2_MEMBER = 6, 25.0
LEAST_POINTS, LEAST_SHARE = 5, 0.5  # that agree
PRIOR_MPS = 4.0  # standard deviation about the track's velocity
SIGMA_MPS = (0.5, 0.25)  # of the velocity found, along and across, at least: pitching moves all points alike


class Seen(NamedTuple):
    """The motion of a vehicle, in vehicle axes."""

    velocity_mps: Floats  # (2,) forward and to the right
    sigma_mps: Floats  # (2,)
    nearer: float  # the factor of its distance at which it would stand, or 1


def seen_motion(
    forward_m: float,
    right_m: float,
    width_m: float,
    sigma_m: float,
    expected_mps: Floats,
    own_mps: float,
    points: PointMotions,
    camera: Camera,
) -> Seen | None:
    """The motion of the vehicle with its face's middle at a place in vehicle axes; None if too few points show it.

    `sigma_m` is the standard deviation of its distance.
    """
    depth = forward_m - camera.forward_m + FACE_M
    stands = float(np.hypot(*expected_mps)) < STANDING_MPS
    highest_m = HIGHEST_SHARE * camera.height_m if stands else HEIGHTS_M[1]
    rows = np.flatnonzero(_on_face(points, depth, right_m, 0.5 * width_m, highest_m, camera))
    if len(rows) < LEAST_POINTS:
        return None
    mine = points.select(rows)
    inverse, slope = 1.0 / depth, np.stack([mine.by_depth, mine.by_along, mine.by_across], axis=2)
    mean = inverse * np.array([1.0, *expected_mps])
    sigma = inverse * np.array([sigma_m / depth, PRIOR_MPS, PRIOR_MPS])
    solved, spread, chi2 = mine.fit(slope, mean, sigma, PASSES)
    agree = int(np.count_nonzero(chi2 < CHI2_MEMBER))
    if agree < max(LEAST_POINTS, LEAST_SHARE * len(rows)) or solved[0] < 0.3 * inverse:
        return None
    found, sigma_mps = solved[1:] / solved[0], np.hypot(spread[1:] / solved[0], SIGMA_MPS)
    if found[0] < 0.0 < expected_mps[0]:
        return Seen(np.array([0.0, found[1]]), sigma_mps, own_mps / (own_mps - found[0]))
    return Seen(found, sigma_mps, 1.0)


def _on_face(
    points: PointMotions, depth_m: float, right_m: float, half_m: float, highest_m: float, camera: Camera
) -> Bools:
    """(N,) points within the outline that the road behind it does not explain."""
    height = camera.height_m - points.drop * depth_m
    on: Bools = np.abs(points.bearing * depth_m - right_m) < half_m - BESIDE_M
    on &= (height > HEIGHTS_M[0]) & (height < highest_m)
    inverse = np.maximum(points.drop, 0.0) / camera.height_m
    return on & (points.chi2(points.by_depth * inverse[:, None] - points.far) > ROAD_CHI2)
