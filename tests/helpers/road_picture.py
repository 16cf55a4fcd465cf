"""A picture of a road in closed form: a straight or circular carriageway, drawn pixel by pixel from its geometry."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from driver_settings import ROBUST

from vpf_sim.geometry import ground_from_pixels, world_from_vehicle
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.perception.road.edge_tracker import RoadEdgeTracker
from vpf_sim.perception.road.road_settings import VergeConfig
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Camera, Floats, Image, RoadEdges

SPEED_MPS = 5.55
ASPHALT, PAINT, SKY = (106, 106, 107), (212, 211, 206), (150, 180, 220)
FARTHEST_M = 200.0


class Ground(NamedTuple):
    """The ground in a camera's frame."""

    shows: Bools  # (height, width), pixels that show it
    places_m: Floats  # (N, 2), vehicle axes, what these pixels show
    pixel_m: Floats  # (N,), the width of a pixel there


@cache
def ground_in_view(camera: Camera) -> Ground:
    """The ground as far as it is drawn."""
    columns, rows = np.meshgrid(np.arange(camera.width_px, dtype=float), np.arange(camera.height_px, dtype=float))
    places_m = ground_from_pixels(camera, np.stack([columns, rows], axis=-1))
    shows = np.isfinite(places_m[..., 0]) & (places_m[..., 0] < FARTHEST_M)
    return Ground(shows, places_m[shows], np.maximum(places_m[shows, 0], 1.0) / camera.fx_px)


@dataclass(frozen=True)
class RoadPicture:
    """A carriageway of four lanes whose centre line leaves the origin along X with a constant curvature."""

    camera: Camera
    curvature_per_m: float = 0.0
    verge: tuple[int, int, int] = (88, 100, 52)
    half_width_m: float = 7.0
    lane_width_m: float = 3.5
    paint_ends_m: float = np.inf  # along the centre line
    paint_aside_m: float = 0.0  # right of where the lines are otherwise

    def pose(self, along_m: float, right_m: float, heading_rad: float) -> Floats:
        """(x, y, yaw) `right_m` right of the centre line, turned by `heading_rad` from its direction."""
        if self.curvature_per_m == 0.0:
            return np.array([along_m, right_m, heading_rad])
        radius, turn = 1.0 / self.curvature_per_m, along_m * self.curvature_per_m
        reach = radius - right_m
        return np.array([reach * np.sin(turn), radius - reach * np.cos(turn), turn + heading_rad])

    def local(self, points_m: Floats) -> tuple[Floats, Floats]:
        """Metres along the centre line and right of it, of (..., 2) world points."""
        x, y = points_m[..., 0], points_m[..., 1]
        if self.curvature_per_m == 0.0:
            return x, y
        radius = 1.0 / self.curvature_per_m
        side = np.sign(radius)
        return np.arctan2(x * side, (radius - y) * side) * abs(radius), radius - side * np.hypot(x, y - radius)

    def draw(self, pose: Floats, seed: int = 0) -> Image:
        """The frame at `pose`, with grain; lines are 0.15 m wide, dashes 3 m of 9 m."""
        ground = ground_in_view(self.camera)
        along, right = self.local(world_from_vehicle(ground.places_m, pose))
        colours = np.where((np.abs(right) < self.half_width_m + 0.5)[:, None], ASPHALT, self.verge).astype(float)
        lines = np.arange(-self.half_width_m, self.half_width_m + 0.1, self.lane_width_m) + self.paint_aside_m
        nearest = np.clip(np.rint((right - lines[0]) / self.lane_width_m).astype(int), 0, len(lines) - 1)
        cover = np.clip((0.075 - np.abs(right - lines[nearest])) / ground.pixel_m + 0.5, 0.0, 1.0)
        is_dashed = np.abs(lines[nearest] - self.paint_aside_m) < self.half_width_m
        cover *= ~is_dashed | (np.mod(along, 9.0) < 3.0)
        cover *= along < self.paint_ends_m
        painted = np.flatnonzero(cover)
        colours[painted] += cover[painted, None] * (np.array(PAINT) - colours[painted])
        frame = np.full((*ground.shows.shape, 3), SKY, dtype=float)
        frame[ground.shows] = colours
        frame += stream(seed, "grain").normal(0.0, 2.0, (*ground.shows.shape, 1))
        return np.clip(frame, 0.0, 255.0, out=frame).astype(np.uint8)


def follow(
    picture: RoadPicture,
    right_m: float,
    heading_rad: float,
    frames: int,
    rate_hz: float = 20.0,
    verges: VergeConfig | None = ROBUST.verges,
) -> Iterator[tuple[RoadEdges, float]]:
    """The edges seen on a straight course over a straight road, or one parallel to a bent road, and the true place."""
    tracker = RoadEdgeTracker(picture.camera, ROBUST.road_edges, rate_hz, verges)
    for i in range(frames):
        along = i * SPEED_MPS / rate_hz
        right = right_m + (along * np.tan(heading_rad) if picture.curvature_per_m == 0.0 else 0.0)
        pose = picture.pose(along, right, heading_rad)
        frame = picture.draw(pose, i)
        yield tracker.update(frame, grey(frame), pose, SPEED_MPS, 0.0, None), right
