"""Latitude and longitude as a way on a flat map in our axes."""

import numpy as np

from vpf_sim.replay import derived
from vpf_sim.types import Floats

EARTH_RADIUS_M = 6378137.0
COURSE_WINDOW_S = 1.0  # over which the direction of travel is taken
LEAST_SPEED_MPS = 1.0  # below which it is kept: a receiver that stands wanders


def north_east(latitude_deg: Floats, longitude_deg: Floats) -> Floats:
    """(N, 2) m from the first place, by Mercator's projection at its latitude."""
    scale = np.cos(np.radians(latitude_deg[0])) * EARTH_RADIUS_M
    north = scale * np.log(np.tan(np.pi / 4.0 + 0.5 * np.radians(latitude_deg)))
    east = scale * np.radians(longitude_deg)
    return np.stack([north - north[0], east - east[0]], axis=1)


def way(north_east_m: Floats, heading_rad: Floats) -> Floats:
    """(N, 3) poses from the first place and heading; headings clockwise from north."""
    heading = np.unwrap(heading_rad)
    cosine, sine = np.cos(heading[0]), np.sin(heading[0])
    north, east = (north_east_m - north_east_m[0]).T
    return np.stack([cosine * north + sine * east, cosine * east - sine * north, heading - heading[0]], axis=1)


def course(times_s: Floats, north_east_m: Floats) -> Floats:
    """(N,) rad clockwise from north, the direction of travel; while the vehicle stands that of before."""
    north, east = (derived.slope(times_s, part, COURSE_WINDOW_S) for part in north_east_m.T)
    moving = np.hypot(north, east) > LEAST_SPEED_MPS
    if not moving.any():
        return np.zeros(len(times_s))
    last = np.maximum.accumulate(np.where(moving, np.arange(len(times_s)), np.argmax(moving)))
    return np.asarray(np.unwrap(np.arctan2(east, north)[last]))
