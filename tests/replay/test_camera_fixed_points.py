"""Camera-fixed points: drops, a bonnet, a text; and whether the car moves."""

import numpy as np
import pytest
from flow_made import CAMERA, anywhere, driving, flow_of

from vpf_sim.replay.camera_fixed_points import CameraFixedPoints, moves
from vpf_sim.seeding import stream
from vpf_sim.types import Floats

NONE: Floats = np.empty((0, 2))
LOW_PX = 330.0  # rows of a bonnet


@pytest.mark.parametrize("speed_mps", [5.0, 12.0, 30.0])
def test_car_moves_although_most_points_are_on_drops(speed_mps: float) -> None:
    """87 of 100 points, as on a wet windscreen."""
    assert moves(driving(speed_mps, 40, anywhere(268)), CAMERA)


def test_car_with_constant_image_does_not_move() -> None:
    noise = stream(1, "noise").normal(0.0, 0.05, (300, 2))
    assert not moves(flow_of(anywhere(300), anywhere(300) + noise, 1.0), CAMERA)


def test_crossing_traffic_is_not_ego_motion() -> None:
    points = anywhere(300)
    before = points.copy()
    crossing = (points[:, 1] > 150.0) & (points[:, 1] < 210.0)
    before[crossing] -= [6.0, 0.0]
    assert 0.1 < crossing.mean() < 0.5
    assert not moves(flow_of(points, before, 1.0), CAMERA)


def counted(stuck_px: Floats, frames: int = 40) -> CameraFixedPoints:
    points = CameraFixedPoints(CAMERA)
    for _ in range(frames):
        points.add(driving(12.0, 200, stuck_px))
    return points


def test_clean_image_has_no_artefacts() -> None:
    assert counted(NONE).found() == ()


def test_bonnet_spans_the_lower_edge() -> None:
    edge = np.column_stack([np.linspace(60.0, 580.0, 20), np.full(20, LOW_PX)])
    assert counted(edge).found() == ("bonnet",)


def test_text_is_an_overlay() -> None:
    text = np.column_stack([np.linspace(12.0, 120.0, 10), np.full(10, LOW_PX)])
    assert counted(text).found() == ("overlay",)


def test_lead_vehicle_at_constant_distance_is_no_overlay() -> None:
    car = np.column_stack([np.linspace(290.0, 350.0, 12), np.tile([170.0, 200.0], 6)])
    assert counted(car).found() == ()


def test_drops_across_the_image_are_on_the_windscreen() -> None:
    assert counted(anywhere(400)).found() == ("glass",)


def test_few_frames_give_no_artefacts() -> None:
    assert counted(anywhere(400), frames=10).found() == ()
