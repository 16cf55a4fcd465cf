"""What the flow says about the camera's own motion when nothing about its rotation is recorded."""

from dataclasses import dataclass, replace
from math import nan

import numpy as np

from vpf_sim.geometry import ground_from_pixels, rotation_flow
from vpf_sim.perception import expansion
from vpf_sim.perception.flow import FlowTracker
from vpf_sim.perception.ground import ground_flow
from vpf_sim.planning.variant import Variant
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Expansion, Floats, Flow, Image

PASSES = 3
PROBE_RAD = 1e-3  # a small turn, for the derivative of the flow by it
ROAD_NEAR_M, ROAD_FAR_M, ROAD_HALF_M = 3.0, 20.0, 2.5  # of the road ahead that tells the speed, from the camera
LEAST_FLOW_PX, LEAST_POINTS = 1.0, 5


@dataclass(frozen=True, slots=True)
class OwnMotion:
    """By the flow of one frame."""

    expansion: Expansion
    yaw_rate_radps: float  # + turns right; nan without flow
    speed_scale: float  # of the speed that was told; nan where no road is tracked


class OwnDerotation:
    """Flow and focus of expansion of a variant, told of no turn at all.

    A turn and a motion to the side look much the same in the flow, but a car hardly moves to its side. So the turn is
    first taken to be the one that lets most of the flow leave the image of straight ahead; then the focus of expansion
    is fitted with what is left of the turn, which has the same room as the pitch.
    """

    def __init__(self, camera: Camera, variant: Variant, rate_hz: float) -> None:
        pitch, _, roll = variant.expansion.rotation_sd_radps
        self._camera = camera
        self._config = replace(variant.expansion, rotation_sd_radps=(pitch, pitch, roll))
        self._tracker = FlowTracker(camera, variant.flow, rate_hz)
        self._random = stream(0, "focus of expansion without rotation")
        self._along_m = 0.0

    def update(self, grey: Image, moved_m: float) -> OwnMotion:
        """At a grey (H, W) frame, `moved_m` on from the last, as the odometer has it."""
        self._along_m += moved_m
        flow = self._tracker.update(grey, np.array([self._along_m, 0.0, 0.0]))
        rate = yaw_rate(flow, self._camera) if len(flow) else nan
        straightened = turning(flow, rate if len(flow) else 0.0)
        seen = expansion.estimate(straightened, self._camera, self._config, self._random)
        return OwnMotion(seen, rate, speed_scale(straightened, self._camera))


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


def speed_scale(flow: Flow, camera: Camera) -> float:
    """How far the road ahead came nearer, of how far it would have at the poses told: the median ratio.

    A point of the road Z ahead was at Z + d before and moved by (p - p_FOE) d / (Z + d) (METHOD C2), which gives d.
    The scale is that of the camera's height: a camera 10 % higher than told sees the road come nearer by 10 % less.
    """
    there = flow.gap_s > 0.0
    points = flow.points_px[there]
    place = ground_from_pixels(camera, points)
    ahead = place[:, 0] - camera.forward_m
    with np.errstate(invalid="ignore"):
        road = (ahead > ROAD_NEAR_M) & (ahead < ROAD_FAR_M) & (np.abs(place[:, 1]) < ROAD_HALF_M)
    if np.count_nonzero(road) < LEAST_POINTS:
        return nan
    past = flow.past_pose[there][road]
    told = ground_flow(camera, points[road], past, flow.pose)
    length = np.hypot(*told.T)
    if np.median(length) < LEAST_FLOW_PX:
        return nan
    moved = np.hypot(*(flow.pose[:2] - past[:, :2]).T)
    share = moved / (ahead[road] + moved)  # d / (Z + d), as told
    seen = share * np.sum(flow.displacement_px[there][road] * told, axis=1) / length**2
    return float(np.median(ahead[road] * seen / (1.0 - np.minimum(seen, 0.9)) / moved))


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
