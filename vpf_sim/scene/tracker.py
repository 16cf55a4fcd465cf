"""One tracker for all that is on the road: predict, associate, update, spawn, prune.

A track is a Kalman filter of the place and velocity of a face in road coordinates, with white noise of acceleration,
and the log-odds of its existence (Bar-Shalom, Willett, Tian, Tracking and Data Fusion, 2011, ch. 3 and 7). Detections
carry their own covariance, velocity included: how it was found decides how well its motion is known. Assignment is
global and gated. What is expected to be visible and is not detected exists less; what cannot be seen now does not.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.special import chdtri

from vpf_sim.scene.road import Road
from vpf_sim.scene.scene_settings import TrackerConfig
from vpf_sim.scene.tracks import vehicle_sized
from vpf_sim.types import Bools, Floats, Integers, Rows

STANDS_MPS = 0.3
GATE = float(chdtri(2, 0.001))  # of the squared Mahalanobis distance in place
VELOCITY_SLACK_MPS = 1.5  # added to the velocities' standard deviations: a track may begin to move or stop
SPAWN, REPORT, PRUNE, SURE = -1.0, 0.0, -3.0, 2.0  # log-odds; SURE is less than a confirmed obstacle adds
BEHIND_M, AHEAD_M = 40.0, 120.0  # tracks that are farther away are pruned
LEAST_MPS, SURE_SIGMAS, SURE_FRAMES = np.array([1.0, 0.5]), 3.0, 3.0  # of points by which a standing track moves away
DISTANCE_SHARE = 0.5  # of the own speed, along
CROSSES_MPS = 0.6  # across, and more than along
DRIVES_MPS, ALONG_SHARE = 1.5, 0.3  # of traffic: speed, share of it across
LEFT_M, MOVED_LOSS_PER_S = 3.0, 2.0  # what stands so near to where it is now is what it was
AS_FAR_M, MUCH_WIDER = 1.0, 1.5  # neighbours that are seen as one: distance along, and width by a neighbour's
VAGUE_M = 5.0  # or whose place is known no better
IN_VIEW_M = 3.0  # ahead, from which a face's size is seen; what is passed keeps the size that it had


@dataclass(slots=True)
class Faces(Rows):
    """N faces of one frame in road coordinates: place of the middle, velocity, width across the road, depth beyond."""

    state: Floats  # (N, 4) s m, d m, along m/s, across m/s
    covariance: Floats  # (N, 4, 4)
    length_m: Floats  # (N,)
    width_m: Floats  # (N,)
    gain: Floats  # (N,) log-odds of existence: those that a detection adds, those of a track
    loss_per_s: Floats  # (N,) log-odds that a second without detection in sight takes

    def __len__(self) -> int:
        return len(self.state)

    @property
    def stands(self) -> Bools:
        """(N,) those that were found without a velocity, as static obstacles are."""
        return np.asarray(np.all(self.state[:, 2:] == 0.0, axis=1))


Detections = Faces


def no_detections() -> Detections:
    """None at all."""
    return Detections(np.empty((0, 4)), np.empty((0, 4, 4)), *np.empty((4, 0)))


@dataclass(slots=True)
class TrackTable(Faces):
    """K tracks."""

    identity: Integers  # (K,)
    unseen_s: Floats  # (K,) since the last detection
    moved: Floats  # (K,) frames in which its points moved, less those in which they stood

    @property
    def slow(self) -> Bools:
        """(K,) those that stand, as far as is known."""
        return np.asarray(np.hypot(*self.state[:, 2:].T) < STANDS_MPS)


class SceneTracker:
    """Tracks of one episode."""

    def __init__(self, config: TrackerConfig) -> None:
        self._config = config
        self.table = _begun(no_detections(), np.empty(0, np.int64))
        self._next = 0

    def predict(self, dt_s: float) -> None:
        """Constant velocity for `dt_s`."""
        step = np.eye(4)
        step[0, 2] = step[1, 3] = dt_s
        table = self.table
        table.state = table.state @ step.T
        share = np.where(table.slow, self._config.standing_share**2, 1.0)
        noise = process_noise(dt_s, self._config)
        table.covariance = step @ table.covariance @ step.T + share[:, None, None] * noise
        table.unseen_s = table.unseen_s + dt_s

    def carry(self, before: Road, after: Road) -> None:
        """Keep the places in the world while the estimate of the road changes."""
        state = self.table.state
        if len(state):
            x, y, _ = before.world(state[:, 0], state[:, 1])
            state[:, 0], state[:, 1] = after.place_at(x, y, state[:, 0])

    def update(self, found: Detections, fresh: float | Floats, in_sight_s: Floats, ego_s_m: float) -> None:
        """Correct tracks by their detections and begin new ones.

        A detection adds its gain times `fresh`, one or (N,), the share by which it is independent of the last.
        `in_sight_s` (K,) is the time since the last frame, of tracks that should be detected, or a small part of it.
        """
        current = ~self._outdated(found)
        found, fresh = found.select(current), np.broadcast_to(fresh, len(found))[current]
        track, detection = self._associate(found)
        table = self.table
        undetected = ~self._covered(found)
        undetected[track] = False
        table.gain[undetected] -= (in_sight_s * table.loss_per_s)[undetected]
        if len(track):
            self._correct(track, found.select(detection), fresh[detection], ego_s_m)
        new = np.ones(len(found), np.bool_)
        new[detection] = False
        if new.any():
            self._spawn(found.select(new))
        self._prune(ego_s_m)

    @property
    def reported(self) -> Integers:
        """Rows of the tracks that are likelier than not."""
        return np.flatnonzero(self.table.gain > REPORT)

    @property
    def traffic_mps(self) -> dict[int, float]:
        """Speeds, by identity, of reported tracks that drive along the road our way and are as large as a vehicle."""
        table = self.table
        along, across = table.state[:, 2], np.abs(table.state[:, 3])
        drives = (along > DRIVES_MPS) & (across < ALONG_SHARE * along) & (table.gain > REPORT)
        drives &= vehicle_sized(table.length_m, table.width_m)
        return dict(zip(table.identity[drives].tolist(), along[drives].tolist(), strict=True))

    @property
    def crossing_m(self) -> Floats:
        """(N, 2) s and d of the reported tracks that cross the road."""
        table = self.table
        across = np.abs(table.state[:, 3])
        crosses = (across > CROSSES_MPS) & (across > np.abs(table.state[:, 2])) & (table.gain > REPORT)
        return np.asarray(table.state[crosses, :2])

    def _associate(self, found: Detections) -> tuple[Integers, Integers]:
        """Rows of tracks and of detections that belong together: least sum of distances within the gate.

        What speaks against an obstacle, as paint does, is not a vehicle that drove elsewhere and is out of sight.
        """
        table = self.table
        if not len(table) or not len(found):
            return np.empty(0, np.intp), np.empty(0, np.intp)
        apart = table.state[:, None] - found.state
        variance = table.covariance[:, None] + found.covariance
        place = _mahalanobis(apart[..., :2], variance[..., :2, :2])
        spread = np.sqrt(np.diagonal(variance, axis1=-2, axis2=-1)[..., 2:]) + VELOCITY_SLACK_MPS
        velocity = ((apart[..., 2:] / spread) ** 2).sum(axis=-1)
        possible = (place < GATE) & (velocity < GATE) & ((found.gain > 0.0) | table.slow[:, None])
        cost = np.where(possible, place + velocity, 10.0 * GATE)
        track, detection = linear_sum_assignment(cost)
        kept = possible[track, detection]
        return track[kept], detection[kept]

    def _covered(self, found: Detections) -> Bools:
        """(K,) tracks that stand where one of the detections that stand is: neighbours that are now seen as one."""
        table = self.table
        stands = found.select(found.stands & (found.gain > 0.0))
        apart = np.abs(table.state[:, None, :2] - stands.state[:, :2])
        covers = (apart[..., 0] < AS_FAR_M) & (apart[..., 1] < 0.5 * stands.width_m)
        covers &= stands.width_m > MUCH_WIDER * table.width_m[:, None]
        return np.asarray(table.slow & covers.any(axis=1))

    def _correct(self, rows: Integers, found: Detections, fresh: Floats, ego_s_m: float) -> None:
        """Kalman update of some tracks by a detection each."""
        table = self.table
        before = table.covariance[rows]
        gain = np.linalg.solve(before + found.covariance, before).transpose(0, 2, 1)
        change = np.einsum("nij,nj->ni", gain, found.state - table.state[rows])
        table.state[rows] += change
        table.covariance[rows] = (np.eye(4) - gain) @ before
        table.loss_per_s[rows] = found.loss_per_s
        # what stands was seen best from afar: from the side, only a part of its face is visible
        length = np.where(found.stands, np.maximum(table.length_m[rows], found.length_m), found.length_m)
        seen = found.state[:, 0] > ego_s_m + IN_VIEW_M
        table.length_m[rows[seen]], table.width_m[rows[seen]] = length[seen], found.width_m[seen]
        most = np.where(found.stands, self._config.most_standing, self._config.most)
        table.gain[rows] = np.minimum(table.gain[rows] + fresh * found.gain, most)
        table.unseen_s[rows] = 0.0

    def see_motion(self, row: int, velocity_mps: Floats, sigma_mps: Floats, own_mps: float) -> None:
        """Note the velocity (2,) of the points on a track that stands; after some frames of motion it moves.

        A wrong distance of the track looks like motion along the road, by a share of the own speed.
        """
        table = self.table
        least = np.maximum(LEAST_MPS, SURE_SIGMAS * sigma_mps) + np.array([DISTANCE_SHARE * own_mps, 0.0])
        moves = bool(np.any(np.abs(velocity_mps) > least))
        table.moved[row] = min(max(table.moved[row] + (1.0 if moves else -1.0), 0.0), 2.0 * SURE_FRAMES)
        if table.moved[row] < SURE_FRAMES or not moves:
            return
        table.state[row, 2:] = velocity_mps
        table.covariance[row, 2:] = table.covariance[row, :, 2:] = 0.0
        table.covariance[row, 2:, 2:] = np.diag(sigma_mps**2)
        table.loss_per_s[row] = MOVED_LOSS_PER_S

    def _outdated(self, found: Detections) -> Bools:
        """(N,) detections of what stands where a track was that has moved away since."""
        moved = self.table.state[self.table.moved >= SURE_FRAMES]
        near = np.abs(found.state[:, None, :2] - moved[:, :2]) < LEFT_M
        return np.asarray(found.stands & np.any(np.all(near, axis=2), axis=1))

    def correct_velocity(self, row: int, velocity_mps: Floats, sigma_mps: Floats) -> None:
        """Kalman update of a track by its velocity (2,) along and across."""
        table = self.table
        before = table.covariance[row]
        gain = np.linalg.solve(before[2:, 2:] + np.diag(sigma_mps**2), before[2:]).T
        table.state[row] += gain @ (velocity_mps - table.state[row, 2:])
        table.covariance[row] = before - gain @ before[2:]

    def correct_place(self, row: int, farther_m: float, sigma_m: float) -> None:
        """Kalman update of a track by its place along the road, `farther_m` from where it is."""
        table = self.table
        before = table.covariance[row]
        gain = before[0] / (before[0, 0] + sigma_m**2)
        table.state[row] += gain * farther_m
        table.covariance[row] = before - np.outer(gain, before[0])

    def end(self, rows: Bools) -> None:
        """Drop some tracks, (K,)."""
        if rows.any():
            self.table = self.table.select(~rows)

    def _spawn(self, found: Detections) -> None:
        count, table = len(found), self.table
        identity = np.arange(self._next, self._next + count)
        self._next += count
        begun = _begun(found, identity)
        begun.gain[found.stands & (found.gain < SURE)] = self._config.unsure
        self.table = table.concatenate(begun)

    def _prune(self, ego_s_m: float) -> None:
        table = self.table
        ahead = table.state[:, 0] - ego_s_m
        kept = (table.gain > PRUNE) & (table.unseen_s < self._config.unseen_s) & (ahead > -BEHIND_M) & (ahead < AHEAD_M)
        kept &= np.sqrt(table.covariance[:, 1, 1]) < VAGUE_M
        self.end(~kept)


def _begun(found: Detections, identity: Integers) -> TrackTable:
    """Tracks that begin with a detection each."""
    sizes, existence = (found.length_m, found.width_m), (SPAWN + found.gain, found.loss_per_s)
    return TrackTable(found.state, found.covariance, *sizes, *existence, identity, *np.zeros((2, len(found))))


def process_noise(dt_s: float, config: TrackerConfig) -> Floats:
    """(4, 4) covariance that white noise of acceleration adds in `dt_s`."""
    noise = np.zeros((4, 4))
    power = config.along_mps2**2, config.across_mps2**2
    for axis in (0, 1):
        noise[axis, axis] = power[axis] * dt_s**3 / 3.0
        noise[axis, axis + 2] = noise[axis + 2, axis] = power[axis] * dt_s**2 / 2.0
        noise[axis + 2, axis + 2] = power[axis] * dt_s
    return noise


def _mahalanobis(apart: Floats, variance: Floats) -> Floats:
    """(K, N) squared distances of vectors (K, N, 2) with covariances (K, N, 2, 2)."""
    a, b, d = variance[..., 0, 0], variance[..., 0, 1], variance[..., 1, 1]
    x, y = apart[..., 0], apart[..., 1]
    distance: Floats = (d * x**2 - 2.0 * b * x * y + a * y**2) / np.maximum(a * d - b**2, 1e-9)
    return distance
