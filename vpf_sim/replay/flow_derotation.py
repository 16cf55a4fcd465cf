"""The camera's own motion by the flow alone, without recorded rotation."""

from dataclasses import dataclass, replace
from math import nan

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.geometry import rotation_flow, straight_ahead_px
from vpf_sim.perception.egomotion import focus_of_expansion as expansion
from vpf_sim.perception.egomotion.flow import FlowTracker
from vpf_sim.planning.variant import Variant
from vpf_sim.replay import road_speed
from vpf_sim.replay.fixed_structure import FixedStructure
from vpf_sim.replay.rectify import Mounting
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Expansion, Floats, Flow, Image

PASSES = 3
PROBE_RAD = 1e-3  # small rotation for the derivative of the flow
STILL_PXPS = 3.0  # below this a point is stationary
CLEARLY_PXPS = 10.0  # above this a point clearly moves
MOVING_SHARE = 0.5  # of moving points, above which the car moves
LEAST_POINTS, LEAST_ON_A_SIDE = 12, 3  # least expanding points, where fewer points move
OUTWARD, OUTWARD_SHARE = 0.7, 0.7  # least cosine of flow and outward direction; least share of such points


@dataclass(frozen=True, slots=True)
class EgoMotion:
    """Ego motion by the flow of one frame."""

    expansion: Expansion
    yaw_rate_radps: float  # + turns right; nan without flow
    flow: Flow
    speed_votes: Floats  # (M, 2) m/s and weight of points that may lie on the road (`road_speed`)


class FlowDerotation:
    """Flow and focus of expansion of a variant, without recorded rotation.

    In the flow, a turn looks like sideways motion, but a car hardly moves sideways. So first the yaw rate is taken
    with which most of the flow leaves the image of straight ahead. Then the focus of expansion is fitted with the
    remaining rotation, as free as the pitch.
    """

    def __init__(self, camera: Camera, variant: Variant, rate_hz: float, fixed: FixedStructure | None = None) -> None:
        fit = variant.focus_of_expansion.fit
        if fit is None:
            raise InputError("flow derotation: expected a variant with [focus_of_expansion.fit], got none")
        rotation = replace(fit.rotation, yaw_sd_radps=fit.rotation.tilt_sd_radps)
        self._camera = camera
        self._config = replace(variant.focus_of_expansion, fit=replace(fit, rotation=rotation))
        flow = replace(variant.flow, from_road=False)  # the motion is not known yet
        self._tracker = FlowTracker(camera, flow, rate_hz)
        self._random = stream(0, "focus of expansion without rotation")
        self._mounting = Mounting(height_m=camera.height_m, pitch_rad=camera.pitch_rad)
        self._fixed = fixed
        self._along_m = 0.0
        self._expansion: Expansion | None = None

    def update(self, grey: Image, moved_m: float) -> EgoMotion:
        """Ego motion at a grey (H, W) frame, `moved_m` after the last one by the odometer."""
        self._along_m += moved_m
        flow = self._tracker.update(grey, np.array([self._along_m, 0.0, 0.0]))
        shows_scene = ~flow.on_glass if self._fixed is None else ~flow.on_glass & self._fixed.scene(flow.points_px)
        scene = flow.select(np.flatnonzero(shows_scene))  # camera-fixed points carry no motion
        rate = yaw_rate(scene, self._camera) if len(scene) else nan
        straightened = turning(scene, rate if len(scene) else 0.0)
        found = expansion.estimate(straightened, self._camera, self._config, self._random, self._expansion)
        self._expansion = found
        return EgoMotion(found, rate, flow, road_speed.votes(straightened, self._camera, self._mounting))


def yaw_rate(flow: Flow, camera: Camera) -> float:
    """rad/s, + right: weighted median yaw rate of a camera that moves straight ahead.

    Each point's flow perpendicular to the direction from straight ahead, over its change by a yaw rate.
    """
    away = flow.points_px - straight_ahead_px(camera)
    across = np.stack([away[:, 1], -away[:, 0]], axis=1) / (np.hypot(away[:, 0], away[:, 1])[:, None] + 1.0)
    turned = np.sum(rotation_flow(camera, flow.points_px, PROBE_RAD * flow.gap_s) * across, axis=1) / PROBE_RAD
    rate = 0.0
    for _ in range(PASSES):
        left = np.sum(expansion.derotate(turning(flow, rate), camera) * across, axis=1)
        rate += _weighted_median(left / np.where(turned == 0.0, 1.0, turned), np.abs(turned))
    return rate


def turning(flow: Flow, rate_radps: float) -> Flow:
    """The flow with the poses of a vehicle that turns at this rate."""
    past = flow.past_pose.copy()
    past[:, 2] = flow.pose[2] - rate_radps * flow.gap_s
    return replace(flow, past_pose=past)


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
    return _expands(flow.select(np.flatnonzero(length >= CLEARLY_PXPS * gap)), camera)


def _expands(flow: Flow, camera: Camera) -> bool:
    """Whether the points expand from straight ahead, with the rotation removed."""
    if len(flow) < LEAST_POINTS:
        return False
    left = expansion.derotate(turning(flow, yaw_rate(flow, camera)), camera)
    away = flow.points_px - straight_ahead_px(camera)
    outward = np.sum(left * away, axis=1) > OUTWARD * np.hypot(*left.T) * np.hypot(*away.T)
    sides = [int(np.count_nonzero(outward & side)) for side in (away[:, 0] < 0.0, away[:, 0] > 0.0)]
    return bool(np.mean(outward) > OUTWARD_SHARE and min(sides) >= LEAST_ON_A_SIDE)


def _weighted_median(values: Floats, weights: Floats) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    if total[-1] <= 0.0:
        return 0.0
    return float(values[order[np.searchsorted(total, 0.5 * total[-1])]])
