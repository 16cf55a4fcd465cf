"""Image points that move with the camera (water, bonnet, text), and whether the car moves."""

from typing import Literal

import numpy as np

from vpf_sim.geometry import straight_ahead_px
from vpf_sim.perception.egomotion import focus_of_expansion as expansion
from vpf_sim.replay import flow_derotation
from vpf_sim.types import Bools, Camera, Floats, Flow

STILL_PXPS = 3.0  # below this a point stands
CLEARLY_PXPS = 10.0  # above this a point clearly moves
MOVING_SHARE = 0.5  # of moving points, above which the car moves
LEAST_POINTS, LEAST_ON_A_SIDE = 12, 3  # least expanding points, where fewer points move
OUTWARD, OUTWARD_SHARE = 0.7, 0.7  # least cosine of flow and outward direction; least share of such points

CELLS = (12, 16)  # rows and columns of the counting grid
PERSISTENT = 0.5  # least share of frames in which a cell has a fixed point
FEWEST_FRAMES = 25  # with motion
BONNET_ROWS, BONNET_SHARE = 4, 0.3  # bottom rows of a bonnet, least share of columns
CENTRE = (slice(2, 9), slice(3, 13))  # cells where a lead vehicle can also stay in place
WATER_SHARE = 0.15  # share of fixed points in the median frame

Artefact = Literal["bonnet", "overlay", "glass"]


def without(flow: Flow, chosen: Bools) -> Flow:
    """The flow without the chosen points."""
    return flow.select(np.flatnonzero(~chosen))


def moves(flow: Flow, camera: Camera) -> bool:
    """Whether the car moves: most points do, or some expand on both sides of the direction of travel.

    The second rule serves where most points are camera-fixed. Traffic past a standing car moves one way only.
    """
    if not len(flow):
        return False
    length = np.hypot(*flow.displacement_px.T)
    gap = np.maximum(flow.gap_s, 1e-9)
    if np.mean(length > STILL_PXPS * gap) > MOVING_SHARE:
        return True
    return _expands(without(flow, length < CLEARLY_PXPS * gap), camera)


def _expands(flow: Flow, camera: Camera) -> bool:
    """Whether the points expand from straight ahead, with the rotation removed."""
    if len(flow) < LEAST_POINTS:
        return False
    left = expansion.derotate(flow_derotation.turning(flow, flow_derotation.yaw_rate(flow, camera)), camera)
    away = flow.points_px - straight_ahead_px(camera)
    outward = np.sum(left * away, axis=1) > OUTWARD * np.hypot(*left.T) * np.hypot(*away.T)
    sides = [int(np.count_nonzero(outward & side)) for side in (away[:, 0] < 0.0, away[:, 0] > 0.0)]
    return bool(np.mean(outward) > OUTWARD_SHARE and min(sides) >= LEAST_ON_A_SIDE)


class CameraFixedPoints:
    """Counts camera-fixed points over a drive to find artefacts in the image."""

    def __init__(self, camera: Camera) -> None:
        self._size = np.array([camera.width_px, camera.height_px])
        self._frames = 0
        self._cells = np.zeros(CELLS)
        self._shares: list[float] = []

    def add(self, flow: Flow) -> None:
        """Count a frame in which the car moves."""
        rides = flow.on_glass
        self._frames += 1
        self._shares.append(float(np.mean(rides)) if len(flow) else 0.0)
        place: Floats = flow.points_px[rides] / self._size * [CELLS[1], CELLS[0]]
        columns, rows = np.clip(place.astype(np.intp), 0, [CELLS[1] - 1, CELLS[0] - 1]).T
        hit = np.zeros(CELLS)
        hit[rows, columns] = 1.0
        self._cells += hit

    @property
    def share(self) -> float:
        """Share of camera-fixed points in the median frame."""
        return float(np.median(self._shares)) if self._shares else 0.0

    def found(self) -> tuple[Artefact, ...]:
        """The artefacts in the image over the whole drive."""
        if self._frames < FEWEST_FRAMES:
            return ()
        stays = self._cells > PERSISTENT * self._frames
        bonnet = stays[-BONNET_ROWS:].any(axis=0).mean() >= BONNET_SHARE and self.share < WATER_SHARE
        if bonnet:
            stays[-BONNET_ROWS:] = False
        stays[CENTRE] = False
        on_windscreen = self.share >= WATER_SHARE
        found: list[tuple[Artefact, bool]] = [
            ("bonnet", bool(bonnet)),
            ("overlay", bool(stays.any()) and not on_windscreen),
            ("glass", on_windscreen),
        ]
        return tuple(name for name, there in found if there)
