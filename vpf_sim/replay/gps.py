"""Latitude and longitude as poses on a flat map in our axes."""

import numpy as np

from vpf_sim.geometry import unwrapped
from vpf_sim.replay import derived, series
from vpf_sim.replay.plausible import Location, reachable, within_limits
from vpf_sim.types import Floats

EARTH_RADIUS_M = 6378137.0
COURSE_WINDOW_S = 1.0  # for the direction of travel
LEAST_SPEED_MPS = 1.0  # below this the course is held: a standing receiver drifts


def fixes(times_s: Floats, latitude_deg: Floats, longitude_deg: Floats, where: Location, notes: list[str]) -> Floats:
    """(N, 2) m from the first fix, north and east; nan without a fix and at impossible positions."""
    latitude_deg = within_limits(latitude_deg, "latitude_deg", where, notes)
    longitude_deg = within_limits(longitude_deg, "longitude_deg", where, notes)
    none = (latitude_deg == 0.0) & (longitude_deg == 0.0)
    if none.any():
        notes.append(f"{where}: {np.count_nonzero(none)} of {len(none)} positions removed: 0, 0 is no fix")
    latitude, longitude = (np.where(none, np.nan, degrees) for degrees in (latitude_deg, longitude_deg))
    return reachable(times_s, north_east(latitude, longitude), where, notes)


def north_east(latitude_deg: Floats, longitude_deg: Floats) -> Floats:
    """(N, 2) m from the first known position, by Mercator's projection; nan where unknown."""
    longitude = unwrapped(longitude_deg, 360.0)
    known = np.isfinite(latitude_deg) & np.isfinite(longitude)
    first = int(np.argmax(known))
    scale = np.cos(np.radians(latitude_deg[first])) * EARTH_RADIUS_M
    north = scale * np.log(np.tan(np.pi / 4.0 + 0.5 * np.radians(latitude_deg)))
    east = scale * np.radians(longitude)
    return np.where(known[:, None], np.stack([north - north[first], east - east[first]], axis=1), np.nan)


def poses(north_east_m: Floats, heading_rad: Floats) -> Floats:
    """(N, 3) poses from the first known position and heading; headings clockwise from north."""
    heading = unwrapped(heading_rad)
    first = int(np.argmax(np.isfinite(north_east_m).all(axis=1) & np.isfinite(heading)))
    cosine, sine = np.cos(heading[first]), np.sin(heading[first])
    north, east = (north_east_m - north_east_m[first]).T
    return np.stack([cosine * north + sine * east, cosine * east - sine * north, heading - heading[first]], axis=1)


def course(times_s: Floats, north_east_m: Floats) -> Floats:
    """(N,) rad clockwise from north, direction of travel; held while the vehicle stands."""
    flat = [series.filled(times_s, part)[0] for part in north_east_m.T]
    if len(times_s) < 2 or not np.isfinite(flat).all():
        return np.zeros(len(times_s))
    north, east = (derived.slope(times_s, part, COURSE_WINDOW_S) for part in flat)
    moving = np.hypot(north, east) > LEAST_SPEED_MPS
    if not moving.any():
        return np.zeros(len(times_s))
    last = np.maximum.accumulate(np.where(moving, np.arange(len(times_s)), np.argmax(moving)))
    return unwrapped(np.arctan2(east, north)[last])
