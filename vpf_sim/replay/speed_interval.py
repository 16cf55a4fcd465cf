"""The interval of a speed by the road's flow, from all that is assumed or estimated about it.

The speed is proportional to the camera's height and to its focal length, and is as uncertain as the horizon's place in
the image. The parts multiply: each is a factor that the truth may be of the stated speed.
"""

from dataclasses import dataclass
from math import prod, radians, tan

import numpy as np

from vpf_sim.replay.assemble import FIELD_OF_VIEW_RAD
from vpf_sim.replay.recording import IMAGES, Recording
from vpf_sim.replay.road_speed import MOST_GAIN_MPS2, MOST_LOSS_MPS2, MOST_SPEED_MPS
from vpf_sim.types import Bools, Floats

VIEWS_DEG = (130.0, 40.0)  # of cameras in cars, along the longer side: the widest, the narrowest
LANE_WIDTHS_M, ASSUMED_LANE_M = (2.7, 4.0), 3.5
HEIGHTS_M = (0.9, 2.5)  # of cameras in cars, vans and motor homes
MEASURED = 0.08  # of the flow on flat, even road, all else known
ROAD_M = 8.0  # ahead, where most of the votes for the speed are
LEAST_MEAN_MPS = 0.5  # below this a factor means nothing


@dataclass(frozen=True, slots=True)
class Part:
    """One uncertainty: the truth is `low` to `high` times the stated speed, all else being right."""

    what: str
    remedy: str  # what removes it
    low: float
    high: float

    @property
    def ratio(self) -> float:
        return self.high / max(self.low, 1e-3)


@dataclass(frozen=True, slots=True)
class SpeedInterval:
    """The interval of the mean speed, and its parts, the widest first."""

    mean_mps: float
    parts: tuple[Part, ...]

    @property
    def low(self) -> float:
        """The least factor of the stated speed."""
        return prod(part.low for part in self.parts)

    @property
    def high(self) -> float:
        """The greatest factor of the stated speed."""
        return prod(part.high for part in self.parts)

    @property
    def range_mps(self) -> tuple[float, float]:
        """m/s, the least and the greatest mean speed."""
        return self.low * self.mean_mps, self.high * self.mean_mps


def of(recording: Recording) -> SpeedInterval | None:
    """The interval where the speed comes from the images; None where it was recorded or given."""
    if IMAGES not in recording.origins["speed_mps"].inputs:
        return None
    found = [_lens(recording), _height(recording), _horizon(recording), _gaps(recording)]
    parts = [part for part in found if part is not None]
    parts.append(Part("the flow itself", "a table with the speed", 1.0 - MEASURED, 1.0 + MEASURED))
    ordered = sorted(parts, key=lambda part: part.ratio, reverse=True)
    return SpeedInterval(float(np.mean(np.abs(recording.speed_mps))), tuple(ordered))


def _lens(recording: Recording) -> Part | None:
    if "lens" not in recording.assumed:
        return None
    widest, narrowest = (tan(0.5 * FIELD_OF_VIEW_RAD) / tan(0.5 * radians(view)) for view in VIEWS_DEG)
    what = f"a field of view of {VIEWS_DEG[1]:g} to {VIEWS_DEG[0]:g} deg"
    return Part(what, "field_of_view_deg", widest, narrowest)


def _height(recording: Recording) -> Part | None:
    if "height by lanes" in recording.assumed:
        low, high = (width / ASSUMED_LANE_M for width in LANE_WIDTHS_M)
        return Part(f"lanes {LANE_WIDTHS_M[0]:g} to {LANE_WIDTHS_M[1]:g} m wide", "height_m", low, high)
    if "height" in recording.assumed:
        low, high = (height / recording.camera.height_m for height in HEIGHTS_M)
        return Part(f"a camera {HEIGHTS_M[0]:g} to {HEIGHTS_M[1]:g} m high", "height_m", low, high)
    return None


def _horizon(recording: Recording) -> Part | None:
    """By the pitch's error: a distance on the road changes by the error times distance over height."""
    pitch = recording.mounting_found.get("pitch")
    if pitch is None:
        return None
    off_rad = pitch.half_width_rad + abs(pitch.rad - pitch.used_rad)
    error = 2.0 * ROAD_M / recording.camera.height_m * off_rad
    return Part(
        f"a pitch within {np.degrees(off_rad):.1f} deg", "pitch_deg and yaw_deg", 1.0 / (1.0 + error), 1.0 + error
    )


def _gaps(recording: Recording) -> Part | None:
    """Frames without flow: the speed is within what engine and brakes allow from the frames around."""
    known = recording.known("speed_mps")
    if known.all() or not known.any():
        return None
    stated = np.abs(recording.speed_mps)
    mean = max(float(stated.mean()), LEAST_MEAN_MPS)
    low, high = (float(speed.mean()) / mean for speed in _reachable(recording.times_s, stated, known))
    what = f"{100.0 * (1.0 - known.mean()):.0f} % of the frames without flow of the road"
    return Part(what, "a table with the speed", min(low, 1.0), max(high, 1.0))


def _reachable(times_s: Floats, speed_mps: Floats, known: Bools) -> tuple[Floats, Floats]:
    """(N,) m/s each, least and greatest speed that a car can have between the known frames."""
    there = np.flatnonzero(known)
    after = np.minimum(np.searchsorted(there, np.arange(len(known))), len(there) - 1)
    last, following = there[np.maximum(after - 1, 0)], there[after]
    low, high = np.zeros(len(known)), np.full(len(known), MOST_SPEED_MPS)
    for near, lost, gained in ((last, MOST_LOSS_MPS2, MOST_GAIN_MPS2), (following, MOST_GAIN_MPS2, MOST_LOSS_MPS2)):
        apart_s = np.abs(times_s - times_s[near])
        low = np.maximum(low, speed_mps[near] - lost * apart_s)
        high = np.minimum(high, speed_mps[near] + gained * apart_s)
    inside_low, inside_high = np.clip(low, 0.0, speed_mps), np.clip(high, speed_mps, MOST_SPEED_MPS)
    return np.where(known, speed_mps, inside_low), np.where(known, speed_mps, inside_high)


def text(found: SpeedInterval) -> str:
    """The interval in words, with what it contains and what would narrow it most."""
    least, most = found.range_mps
    contained = ", ".join(part.what for part in found.parts)
    first = found.parts[0]
    return (
        f"from the road's flow: {found.mean_mps:.1f} m/s in the mean, the truth may be {least:.1f} to {most:.1f} "
        f"({found.low:.2f} to {found.high:.2f} times the stated value) with {contained}; "
        f"{first.remedy} would narrow it most"
    )
