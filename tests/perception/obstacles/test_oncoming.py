"""What comes towards the car on a road of two directions is not taken for something that stands in its lane."""

from dataclasses import replace

import numpy as np
import pytest
from tracked_points import SPEED_MPS, Traffic, body, road_points, tracker

from vpf_sim.types import Floats, Obstacles, RoadEdges

ROAD = RoadEdges(-1.75, 1.75, 0.0, 0.0, 0.02, 1.0, 0.0, 3.5, oncoming_m=3.5)
ONE_WAY = replace(ROAD, oncoming_m=0.0)


def reported(vehicle_m: Floats, speed_mps: float, road: RoadEdges, frames: int) -> list[Obstacles]:
    """What the tracker of static obstacles reports of a vehicle, frame by frame."""
    ground = road_points(200)
    drive = Traffic(np.concatenate([vehicle_m, ground]), np.repeat([speed_mps, 0.0], [len(vehicle_m), len(ground)]))
    drive.road = road
    return drive.run(tracker(), range(frames))


@pytest.mark.parametrize("speed_mps", [-5.0, -8.0, -14.0, -25.0])
def test_a_car_that_comes_towards_us_is_in_its_own_lane(speed_mps: float) -> None:
    meets = int(100.0 / (SPEED_MPS - speed_mps) * 60.0)
    vehicle = body(100.0, -3.5, 1.8, 1.4, 16)
    assert not any(len(found) for found in reported(vehicle, speed_mps, ROAD, meets))
    mistaken = [found for found in reported(vehicle, speed_mps, ONE_WAY, meets) if len(found)]
    assert mistaken, "as if nobody came towards us, it seems to stand in our lane"
    assert all((found.right_m > -1.75).all() for found in mistaken)


@pytest.mark.parametrize("speed_mps", [-5.0, -8.0, -14.0])
def test_a_car_that_comes_is_an_oncoming_vehicle_with_its_place_and_speed(speed_mps: float) -> None:
    ground, vehicle, static = road_points(200), body(100.0, -3.5, 1.8, 1.4, 16), tracker()
    vehicle[0, 2] = 0.2  # the lowest point
    drive = Traffic(np.concatenate([vehicle, ground]), np.repeat([speed_mps, 0.0], [len(vehicle), len(ground)]))
    drive.road = ROAD
    closing_mps, errors = SPEED_MPS - speed_mps, []
    for frame in range(int(92.0 / closing_mps * 60.0)):
        flow = drive.flow(frame)
        points = static.triangulate(flow)
        static.update(flow, ROAD, SPEED_MPS, frame / 60.0, points)
        found, away_m = static.oncoming(points, ROAD, SPEED_MPS), 100.0 - closing_mps * frame / 60.0
        if len(found) and away_m < 25.0:
            assert len(found) == 1
            errors.append([found.depth_m[0] + 0.8 - away_m, found.middle_m[0] + 3.5, found.along_mps[0] - speed_mps])
            assert found.depth_sigma_m[0] > 0.3 * abs(errors[-1][0])
    assert len(errors) > 10
    distance, aside, speed = np.median(np.abs(errors), axis=0)
    assert distance < 4.0
    assert aside < 0.6
    assert speed < 0.3 * abs(speed_mps) + 1.0


@pytest.mark.parametrize(
    ("right_m", "width_m", "points"), [(-1.3, 0.6, 8), (-1.3, 1.8, 16), (-0.4, 0.5, 4), (0.7, 0.5, 4), (0.7, 1.8, 16)]
)
def test_what_stands_beside_the_solid_line_is_reported_as_soon(right_m: float, width_m: float, points: int) -> None:
    """As on a road of one direction."""
    standing = body(40.0, right_m, width_m, 1.7, points)
    found, expected = (reported(standing, 0.0, road, 280) for road in (ROAD, ONE_WAY))
    first, first_expected = (next(k for k, one in enumerate(many) if len(one)) for many in (found, expected))
    assert (first - first_expected) * SPEED_MPS / 60.0 < 1.5
    assert found[-1].left_m == pytest.approx(expected[-1].left_m, abs=0.2)
    assert found[-1].right_m == pytest.approx(expected[-1].right_m, abs=0.2)
