"""Pitching taken out of flow and frames: points projected through a camera that pitches by a known angle."""

from dataclasses import replace
from math import pi, radians, sin

import numpy as np
import pytest
from driver_settings import ROBUST
from flow_between import flow_between

from vpf_sim.geometry import project, vehicle_from_world
from vpf_sim.perception.egomotion.camera_pitch import PitchEstimator
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Expansion, Floats, Flow

CAMERA = Camera()
assert ROBUST.camera_pitch is not None
PITCH, DYNAMIC = ROBUST.camera_pitch, ROBUST.camera_pitch.dynamic
RATE_HZ, SPEED_MPS, WINDOW, FRAMES = 60.0, 5.55, 6, 150


def pitch(frame: int, size_deg: float) -> float:
    """rad, the body at 1.5 Hz."""
    return radians(size_deg) * sin(2.0 * pi * 1.5 * frame / RATE_HZ)


class Scene:
    """Points of the road and of things beside it; a car drives along X past them and turns a little."""

    def __init__(self, size_deg: float, noise_px: float = 0.05) -> None:
        random = stream(3, "scene")
        count = 400
        self._points_m = np.column_stack(
            [
                random.uniform(5.0, 60.0, count),
                random.uniform(-12.0, 12.0, count),
                np.where(np.arange(count) < 250, 0.0, random.uniform(0.0, 4.0, count)),
            ]
        )
        self._noise_px = noise_px * random.standard_normal((FRAMES, count, 2))
        self.size_deg = size_deg

    def pose(self, frame: int) -> Floats:
        return np.array([SPEED_MPS * frame / RATE_HZ, 0.0, 0.01 * sin(0.02 * frame)])

    def pixels(self, frame: int, size_deg: float) -> Floats:
        flat = vehicle_from_world(self._points_m[:, :2], self.pose(frame))
        camera = replace(CAMERA, pitch_rad=pitch(frame, size_deg))
        with np.errstate(invalid="ignore"):
            return project(camera, np.column_stack([flat, self._points_m[:, 2]])) + self._noise_px[frame]

    def flow(self, frame: int, size_deg: float | None = None) -> Flow:
        size_deg = self.size_deg if size_deg is None else size_deg
        past, first = max(0, frame - WINDOW), max(0, frame - 27)
        pixels = [self.pixels(k, size_deg) for k in (frame, past, first)]
        inside = [np.all((p >= 0.0) & (p <= [639.0, 479.0]), axis=1) for p in (self.pixels(frame, 0.0), *pixels)]
        chosen = np.flatnonzero(np.all(inside, axis=0))
        now, before, sighting = (p[chosen] for p in pixels)
        flow = flow_between(now, before, self.pose(past), self.pose(frame), (frame - past) / RATE_HZ, frame - first)
        first_pose = np.tile(self.pose(first), (len(chosen), 1))
        return replace(flow, identity=chosen.astype(np.int64), first_px=sighting, first_pose=first_pose)

    def foe(self, frame: int) -> Expansion:
        """The direction of motion in the picture, as it pitches."""
        x = CAMERA.cx_px - CAMERA.fx_px * float(np.tan(self.pose(frame)[2]))
        y = CAMERA.cy_px - CAMERA.fy_px * pitch(frame, self.size_deg)
        return Expansion(x, y, np.eye(2), np.empty(0, np.bool_), 1.0)


def run(scene: Scene, estimator: PitchEstimator) -> list[Flow]:
    return [estimator.update(scene.flow(frame), scene.foe(frame)) for frame in range(FRAMES)]


def estimator(settle_s: float = 1.0) -> PitchEstimator:
    return PitchEstimator(CAMERA, replace(PITCH, dynamic=replace(DYNAMIC, settle_s=settle_s)), RATE_HZ)


@pytest.mark.parametrize("left_too", [True, False])
def test_the_pitch_is_found(left_too: bool) -> None:
    scene, found = Scene(0.4), estimator(settle_s=5.0)
    pitches = []
    for frame in range(FRAMES):
        flow = scene.flow(frame)
        shown = np.flatnonzero(left_too | (flow.points_px[:, 0] > CAMERA.cx_px + 20.0))
        found.update(flow.select(shown), scene.foe(frame))
        pitches.append(found.pitch_rad)
    true = [pitch(frame, 0.4) for frame in range(FRAMES)]
    assert pitches[60:] == pytest.approx(true[60:], abs=radians(0.06))
    assert found.is_needed


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_car_that_overtakes_is_no_pitch(side: float) -> None:
    """Most points on one side of the picture move as if the camera came to look down by 0.9 deg a second."""
    scene, found = Scene(0.0), estimator()
    for frame in range(FRAMES):
        flow, foe = scene.flow(frame), scene.foe(frame)
        x, y = (flow.points_px - (CAMERA.cx_px, CAMERA.cy_px)).T / CAMERA.fx_px
        pitching = -CAMERA.fx_px * 0.0015 * np.column_stack([x * y, 1.0 + y * y])
        on_car = (side * x > 0.0) & (flow.identity % 5 > 0)
        displacement = flow.displacement_px + pitching * on_car[:, None]
        found.update(replace(flow, displacement_px=displacement), foe)
        assert not found.is_needed


def differences(flow: Flow, ideal: Flow) -> Floats:
    """rms px by which the way since the first sighting and the displacement of the same points differ."""
    here, there = np.isin(flow.identity, ideal.identity), np.isin(ideal.identity, flow.identity)
    way = (flow.points_px - flow.first_px)[here] - (ideal.points_px - ideal.first_px)[there]
    window = flow.displacement_px[here] - ideal.displacement_px[there]
    return np.array([np.sqrt(np.mean(way**2)), np.sqrt(np.mean(window**2))])


@pytest.mark.parametrize("size_deg", [0.2, 0.5])
def test_the_flow_becomes_that_of_a_steady_camera(size_deg: float) -> None:
    scene = Scene(size_deg)
    rows = [
        (differences(steady, scene.flow(frame, 0.0)), differences(scene.flow(frame), scene.flow(frame, 0.0)))
        for frame, steady in enumerate(run(scene, estimator()))
        if frame >= 90
    ]
    left, raw = np.mean(rows, axis=0)
    assert np.all(left < 0.05 * raw)
    assert np.all(raw > 0.4)


def test_a_car_that_does_not_pitch_is_left_alone() -> None:
    scene, found = Scene(0.0), estimator()
    for frame in range(FRAMES):
        flow = scene.flow(frame)
        assert found.update(flow, scene.foe(frame)) is flow
    picture = np.zeros((480, 640, 3), np.uint8)
    assert found.frame(picture) is picture


def test_things_that_move_do_not_pitch_the_car() -> None:
    """A fifth of the points flow up by 3 px: they do not agree."""
    scene, found = Scene(0.0), estimator()
    for frame in range(FRAMES):
        flow = scene.flow(frame)
        lifted = np.where((flow.identity % 5 == 0)[:, None], [0.0, -3.0 * min(frame, WINDOW) / WINDOW], 0.0)
        found.update(replace(flow, displacement_px=flow.displacement_px + lifted), scene.foe(frame))
        assert abs(found.pitch_rad) < radians(0.05)


def test_the_frame_is_turned_back() -> None:
    scene, found = Scene(0.5), estimator()
    run(scene, found)
    point = np.array([[20.0, 3.0, 0.5]])
    pitched = replace(CAMERA, pitch_rad=found.pitch_rad)
    column, row = np.rint(project(pitched, point)[0]).astype(int)
    picture = np.zeros((480, 640), np.uint8)
    picture[row - 1 : row + 2, column - 1 : column + 2] = 255
    steady = found.frame(picture).astype(float)
    rows, columns = np.mgrid[:480, :640]
    seen = np.array([(steady * columns).sum(), (steady * rows).sum()]) / steady.sum()
    shift = project(CAMERA, point)[0] - project(pitched, point)[0]
    assert seen - [column, row] == pytest.approx(shift, abs=0.1)
    assert np.abs(shift).max() > 0.2
