"""The scene: what a planner plans in."""

from dataclasses import dataclass
from typing import NamedTuple

from vpf_sim.scene.road import Road
from vpf_sim.scene.tracks import Tracks


class EgoState(NamedTuple):
    """The own car: its middle, in the world and on the road."""

    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float
    yaw_rate_radps: float
    s_m: float
    d_m: float


@dataclass(frozen=True, slots=True)
class Scene:
    """The road, the ego and the tracks at one moment."""

    time_s: float
    ego: EgoState
    road: Road
    tracks: Tracks
    speed_reference_mps: float
