"""Where the tracks will be: constant velocity along their lane or the road, or constant turn rate off both, with
growing uncertainty.

A vehicle whose lane is known is expected to follow it, and to come to its middle. Another that drives along the road
and moves to the side is expected to stay in the lane that it comes to. Both keep their lanes also where no camera sees
them and while they stand, so along the road a vehicle's uncertainty across stays bounded. What crosses the road, or is
beside it as in a junction, keeps its speed and turn rate (CTRV: Schubert, Richter, Wanielik, Fusion 2008).
"""

from dataclasses import dataclass

import numpy as np

from vpf_sim.geometry import wrap_angles
from vpf_sim.scene.road import Road
from vpf_sim.scene.tracks import Tracks, vehicle_sized
from vpf_sim.types import Bools, Floats, Integers, Reals

ALONG_RAD = 0.5  # a track at a smaller angle to the road, in either direction, drives along it
LANE_CHANGE_MPS = 0.05  # lateral speed of a vehicle that changes its lane
NEXT_LANE_SHARE = 0.05  # of a lane's width; who is nearer to a lane's middle is in that lane
BESIDE_M = 1.0  # beyond an edge, a track along the road still follows it
MOVING_MPS = 0.2
KEEPS_LANE_M = 0.4  # standard deviation across, at most, of what drives along the road, and of vehicles that stand
TO_MIDDLE_S = 0.8  # in which the distance from the lane's middle falls to its e-th part


@dataclass(frozen=True, slots=True)
class Prediction:
    """K tracks at T times: middles and headings in the world, and the standard deviations along and across them."""

    tracks: Tracks
    x_m: Floats  # (K, T)
    y_m: Floats  # (K, T)
    heading_rad: Floats  # (K, T)
    along_sigma_m: Floats  # (K, T)
    across_sigma_m: Floats  # (K, T)
    on_road: Bools  # (K,) follows the road
    along_mps: Floats  # (K,) speed along the road, of those on it


def predict(road: Road, tracks: Tracks, times_s: Reals) -> Prediction:
    """The tracks at future times (T,), seconds from now."""
    place = road.at(np.nan_to_num(tracks.s_m))
    relative = wrap_angles(tracks.heading_rad - place.heading_rad)
    on_road = _follows(place.left_m, place.right_m, relative, tracks)
    along = tracks.speed_mps * np.cos(relative)
    along = along / np.maximum(1.0 - place.curvature_per_m * np.nan_to_num(tracks.d_m), 0.3)
    across = tracks.speed_mps * np.sin(relative)
    x, y, heading = _turning(tracks, times_s)
    if on_road.any():
        rows = np.flatnonzero(on_road)
        s = tracks.s_m[rows, None] + along[rows, None] * times_s
        d = tracks.d_m[rows, None] + _aside(road, tracks.d_m[rows], across[rows], times_s)
        x[rows], y[rows], road_heading = road.world(s, d)
        heading[rows] = road_heading + relative[rows, None]
        _leave(road, s, d, rows, (x, y, heading), tracks.speed_mps, times_s)
    _follow_lanes(tracks, (x, y, heading), times_s)
    across_sigma = _sigma(tracks, 1, times_s)
    keeps = on_road & (vehicle_sized(tracks.length_m, tracks.width_m) | (tracks.speed_mps > MOVING_MPS))
    most = np.where(keeps, KEEPS_LANE_M, np.inf)
    across_sigma = np.minimum(across_sigma, most[:, None])
    return Prediction(tracks, x, y, heading, _sigma(tracks, 0, times_s), across_sigma, on_road, along)


def _follows(left_m: Floats, right_m: Floats, relative: Floats, tracks: Tracks) -> Bools:
    """(K,) whether a track drives along the road."""
    on = (tracks.d_m > left_m - BESIDE_M) & (tracks.d_m < right_m + BESIDE_M)  # False at nan
    follows: Bools = on & (np.minimum(np.abs(relative), np.pi - np.abs(relative)) < ALONG_RAD)
    return follows


def _aside(road: Road, d_m: Floats, across: Floats, times_s: Reals) -> Floats:
    """(K, T) m to the right of now: a vehicle that changes lanes stops in the middle of the next one."""
    aside = across[:, None] * times_s
    lane = (d_m - road.route_m) / road.lane_width_m
    ahead = np.where(across > 0.0, np.ceil(lane - NEXT_LANE_SHARE), np.floor(lane + NEXT_LANE_SHARE))
    reach = ahead * road.lane_width_m + road.route_m - d_m
    limit = np.where(np.abs(across) > LANE_CHANGE_MPS, np.maximum(np.where(across > 0.0, reach, -reach), 0.0), np.inf)
    return np.clip(aside, -limit[:, None], limit[:, None])


def _leave(
    road: Road,
    s: Floats,
    d: Floats,
    rows: Integers,
    poses: tuple[Floats, Floats, Floats],
    speed: Floats,
    times_s: Reals,
) -> None:
    """Let tracks go straight on from where the road does not lead on at their d, as before a junction."""
    here = road.at(s)
    outside = (d < here.left_m - BESIDE_M) | (d > here.right_m + BESIDE_M)
    x, y, heading = poses
    for index in np.flatnonzero(outside.any(axis=1)).tolist():
        row, last = int(rows[index]), max(int(outside[index].argmax()) - 1, 0)
        driven = speed[row] * (times_s[last:] - times_s[last])
        heading[row, last:] = heading[row, last]
        x[row, last:] = x[row, last] + driven * np.cos(heading[row, last])
        y[row, last:] = y[row, last] + driven * np.sin(heading[row, last])


def _follow_lanes(tracks: Tracks, poses: tuple[Floats, Floats, Floats], times_s: Reals) -> None:
    """Put tracks that drive forward in a lane that is known at their places along it."""
    x, y, heading = poses
    to_middle = np.exp(-times_s / TO_MIDDLE_S)
    for row, place in enumerate(tracks.lanes):
        if place is not None and tracks.speed_mps[row] > MOVING_MPS:
            lane_x, lane_y, heading[row] = place.line.at(place.along_m + tracks.speed_mps[row] * times_s)
            right = place.right_m * to_middle
            x[row], y[row] = lane_x - right * np.sin(heading[row]), lane_y + right * np.cos(heading[row])


def _turning(tracks: Tracks, times_s: Reals) -> tuple[Floats, Floats, Floats]:
    """(K, T) each: x, y and heading at constant speed and turn rate."""
    turn = tracks.yaw_rate_radps[:, None] * times_s
    course = tracks.heading_rad[:, None] + 0.5 * turn
    chord = tracks.speed_mps[:, None] * times_s * np.sinc(turn / (2.0 * np.pi))
    x, y = tracks.x_m[:, None] + chord * np.cos(course), tracks.y_m[:, None] + chord * np.sin(course)
    return x, y, tracks.heading_rad[:, None] + turn


def _sigma(tracks: Tracks, axis: int, times_s: Reals) -> Floats:
    """(K, T) m, standard deviation along (0) or across (1) a track, from its place's and its velocity's."""
    place, both, speed = (
        tracks.covariance[:, row, column] for row, column in ((axis, axis), (axis, axis + 2), (axis + 2, axis + 2))
    )
    variance = place[:, None] + 2.0 * both[:, None] * times_s + speed[:, None] * times_s**2
    return np.sqrt(np.maximum(variance, 0.0))
