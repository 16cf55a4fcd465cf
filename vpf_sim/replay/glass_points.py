"""Points that ride along with the camera (water, a bonnet, text in the picture), and whether the car moves at all."""

from typing import Literal

import numpy as np

from vpf_sim.perception.egomotion import focus_of_expansion as expansion
from vpf_sim.replay import own_derotation
from vpf_sim.types import Bools, Camera, Floats, Flow

STILL_PXPS = 3.0  # what moves by less stands
CLEARLY_PXPS = 10.0  # what moves by more does move
MOST_SHARE = 0.5  # of the points, that move: so does the car, whatever the others do
LEAST_POINTS, LEAST_ON_A_SIDE = 12, 3  # that must leave the direction of travel, where fewer move
OUTWARD, OUTWARD_SHARE = 0.7, 0.7  # cosine between a point's flow and its way outward; share of the moving points

CELLS = (12, 16)  # rows and columns in which the whole drive's still points are counted
PERSISTENT = 0.5  # share of the moving frames in which a cell has a still point
FEWEST_FRAMES = 25  # that moved, without which nothing persists
BONNET_ROWS, BONNET_SHARE = 4, 0.3  # rows from below in which a bonnet lies, and the share of the columns it spans
CENTRE = (slice(2, 9), slice(3, 13))  # cells where a car ahead stays, too, while it keeps its distance
WATER_SHARE = 0.15  # of the points, that ride along in the median frame

Rider = Literal["bonnet", "overlay", "glass"]


def without(flow: Flow, chosen: Bools) -> Flow:
    """The flow of the other points."""
    return flow.chosen(np.flatnonzero(~chosen))


def moves(flow: Flow, camera: Camera) -> bool:
    """Whether the car moves: most points do, or some leave the direction of travel on both sides of it.

    The second rule holds where most points ride along. Traffic that passes a standing car moves one way.
    """
    if not len(flow):
        return False
    length = np.hypot(*flow.displacement_px.T)
    gap = np.maximum(flow.gap_s, 1e-9)
    if np.mean(length > STILL_PXPS * gap) > MOST_SHARE:
        return True
    return _expands(without(flow, length < CLEARLY_PXPS * gap), camera)


def _expands(flow: Flow, camera: Camera) -> bool:
    """Whether the points leave straight ahead, the turn of the picture apart."""
    if len(flow) < LEAST_POINTS:
        return False
    left = expansion.derotate(own_derotation.turning(flow, own_derotation.yaw_rate(flow, camera)), camera)
    away = flow.points_px - [camera.cx_px, camera.cy_px - camera.fy_px * np.tan(camera.pitch_rad)]
    outward = np.sum(left * away, axis=1) > OUTWARD * np.hypot(*left.T) * np.hypot(*away.T)
    sides = [int(np.count_nonzero(outward & side)) for side in (away[:, 0] < 0.0, away[:, 0] > 0.0)]
    return bool(np.mean(outward) > OUTWARD_SHARE and min(sides) >= LEAST_ON_A_SIDE)


class RidingPoints:
    """Counts over a drive where points ride along, to tell what is in the picture that is no scene."""

    def __init__(self, camera: Camera) -> None:
        self._size = np.array([camera.width_px, camera.height_px])
        self._frames = 0
        self._cells = np.zeros(CELLS)
        self._shares: list[float] = []

    def add(self, flow: Flow) -> None:
        """A frame in which the car moves."""
        rides = flow.stuck
        self._frames += 1
        self._shares.append(float(np.mean(rides)) if len(flow) else 0.0)
        place: Floats = flow.points_px[rides] / self._size * [CELLS[1], CELLS[0]]
        columns, rows = np.clip(place.astype(np.intp), 0, [CELLS[1] - 1, CELLS[0] - 1]).T
        hit = np.zeros(CELLS)
        hit[rows, columns] = 1.0
        self._cells += hit

    @property
    def share(self) -> float:
        """Of the points, that ride along in the median frame."""
        return float(np.median(self._shares)) if self._shares else 0.0

    def found(self) -> tuple[Rider, ...]:
        """What the picture shows beside the scene, on the whole drive."""
        if self._frames < FEWEST_FRAMES:
            return ()
        stays = self._cells > PERSISTENT * self._frames
        bonnet = stays[-BONNET_ROWS:].any(axis=0).mean() >= BONNET_SHARE and self.share < WATER_SHARE
        if bonnet:
            stays[-BONNET_ROWS:] = False
        stays[CENTRE] = False
        glass = self.share >= WATER_SHARE
        found: list[tuple[Rider, bool]] = [
            ("bonnet", bool(bonnet)),
            ("overlay", bool(stays.any()) and not glass),
            ("glass", glass),
        ]
        return tuple(name for name, there in found if there)
