"""What the flow says about the camera's own motion when nothing about its rotation is recorded."""

from dataclasses import dataclass, replace
from math import nan

import numpy as np

from vpf_sim.geometry import rotation_flow
from vpf_sim.perception.egomotion import focus_of_expansion as expansion
from vpf_sim.perception.egomotion.flow import FlowTracker
from vpf_sim.planning.variant import Variant
from vpf_sim.replay import road_speed
from vpf_sim.replay.rectify import Mounting
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Expansion, Floats, Flow, Image

PASSES = 3
PROBE_RAD = 1e-3  # a small turn, for the derivative of the flow by it


@dataclass(frozen=True, slots=True)
class OwnMotion:
    """By the flow of one frame."""

    expansion: Expansion
    yaw_rate_radps: float  # + turns right; nan without flow
    flow: Flow
    speed_votes: Floats  # (M, 2) m/s and weight, of the points that may lie on the road (`road_speed`)


class OwnDerotation:
    """Flow and focus of expansion of a variant, told of no turn at all.

    A turn and a motion to the side look much the same in the flow, but a car hardly moves to its side. So the turn is
    first taken to be the one that lets most of the flow leave the image of straight ahead; then the focus of expansion
    is fitted with what is left of the turn, which has the same room as the pitch.
    """

    def __init__(self, camera: Camera, variant: Variant, rate_hz: float) -> None:
        pitch, _, roll = variant.focus_of_expansion.rotation_sd_radps
        self._camera = camera
        self._config = replace(variant.focus_of_expansion, rotation_sd_radps=(pitch, pitch, roll))
        self._tracker = FlowTracker(camera, variant.flow, rate_hz)
        self._random = stream(0, "focus of expansion without rotation")
        self._mounting = Mounting(height_m=camera.height_m, pitch_rad=camera.pitch_rad)
        self._along_m = 0.0
        self._seen: Expansion | None = None

    def update(self, grey: Image, moved_m: float) -> OwnMotion:
        """At a grey (H, W) frame, `moved_m` on from the last, as the odometer has it."""
        self._along_m += moved_m
        flow = self._tracker.update(grey, np.array([self._along_m, 0.0, 0.0]))
        scene = flow.chosen(np.flatnonzero(~flow.stuck))  # what rides along with the camera tells of no turn
        rate = yaw_rate(scene, self._camera) if len(scene) else nan
        straightened = turning(flow, rate if len(scene) else 0.0)
        seen = expansion.estimate(straightened, self._camera, self._config, self._random, self._seen)
        self._seen = seen
        return OwnMotion(seen, rate, flow, road_speed.votes(straightened, self._camera, self._mounting))


def yaw_rate(flow: Flow, camera: Camera) -> float:
    """rad/s, + right: the turn of a camera that moves straight ahead, by the weighted median over the points.

    Each point's flow across the direction away from straight ahead, by how much a turn would change it.
    """
    ahead = np.array([camera.cx_px, camera.cy_px - camera.fy_px * np.tan(camera.pitch_rad)])
    away = flow.points_px - ahead
    across = np.stack([away[:, 1], -away[:, 0]], axis=1) / (np.hypot(away[:, 0], away[:, 1])[:, None] + 1.0)
    turned = np.sum(rotation_flow(camera, flow.points_px, PROBE_RAD * flow.gap_s) * across, axis=1) / PROBE_RAD
    rate = 0.0
    for _ in range(PASSES):
        left = np.sum(expansion.derotate(turning(flow, rate), camera) * across, axis=1)
        rate += _weighted_median(left / np.where(turned == 0.0, 1.0, turned), np.abs(turned))
    return rate


def turning(flow: Flow, rate_radps: float) -> Flow:
    """The flow as seen by a vehicle that turned at this rate."""
    past = flow.past_pose.copy()
    past[:, 2] = flow.pose[2] - rate_radps * flow.gap_s
    return replace(flow, past_pose=past)


def _weighted_median(values: Floats, weights: Floats) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    if total[-1] <= 0.0:
        return 0.0
    return float(values[order[np.searchsorted(total, 0.5 * total[-1])]])
