"""The velocity of a vehicle whose place is known, from points that are projected from it and from the road behind."""

import numpy as np
import pytest
from made_flow import CAMERA, SPEED_MPS, body, flow, motions, road

from vpf_sim.scene.vehicle_motion import Seen, seen_motion

WIDTH_M, EXPECTED_MPS = 1.8, np.array([5.0, 0.0])


def found(forward_m: float, velocity_mps: tuple[float, float], believed_m: float | None = None) -> Seen | None:
    """Of a car's rear on a road, with points of the static scene far behind it in its outline."""
    rear, ground = body(forward_m + 0.3, 0.4, WIDTH_M, 0.2, 1.4), road()
    beyond = body(3.0 * forward_m, 1.2, 3.0 * WIDTH_M, 0.0, 1.4, 10)
    places = np.concatenate([rear, ground, beyond])
    moves = np.zeros((len(places), 2))
    moves[: len(rear)] = velocity_mps
    expected = EXPECTED_MPS
    shown, place = motions(flow(places, moves)), (believed_m or forward_m, 0.4, WIDTH_M, 0.3)
    return seen_motion(*place, expected, SPEED_MPS, shown, CAMERA)


@pytest.mark.parametrize("forward_m", [6.0, 9.0, 12.0])
@pytest.mark.parametrize("velocity_mps", [(5.0, 0.0), (2.0, 0.0), (0.0, 0.0), (4.0, 0.8), (9.0, 0.0)])
def test_a_car_that_brakes_has_its_new_speed_at_once(forward_m: float, velocity_mps: tuple[float, float]) -> None:
    """A track that still expects 5 m/s."""
    result = found(forward_m, velocity_mps)
    assert result is not None
    np.testing.assert_array_less(np.abs(result.velocity_mps - velocity_mps), 2.0 * result.sigma_mps)
    assert (result.sigma_mps < 1.2).all()
    assert result.nearer == pytest.approx(1.0, abs=0.15)


def test_a_standing_car_that_seems_to_come_is_nearer() -> None:
    """It stands 10 m ahead and is believed to be at 14."""
    result = found(10.0, (0.0, 0.0), 14.0)
    assert result is not None
    assert result.velocity_mps[0] == 0.0
    assert 14.0 * result.nearer == pytest.approx(10.0, rel=0.1)


@pytest.mark.parametrize("forward_m", [6.0, 9.0])
def test_what_stands_far_behind_a_pallet_does_not_make_it_drive_off(forward_m: float) -> None:
    pallet, beyond = body(forward_m + 0.3, 0.4, 0.8, 0.15, 0.2, 4), body(4.0 * forward_m, 1.6, 3.2, 0.3, 1.9, 40)
    places = np.concatenate([pallet, road(), beyond])
    shown = motions(flow(places, np.zeros((len(places), 2))))
    result = seen_motion(forward_m, 0.4, 0.8, 0.3, np.zeros(2), SPEED_MPS, shown, CAMERA)
    assert result is None or (np.abs(result.velocity_mps) < 3.0 * result.sigma_mps).all()


def test_a_car_that_stood_has_its_speed_when_it_drives_off() -> None:
    rear, ground = body(8.3, 0.4, WIDTH_M, 0.2, 1.4), road()
    places, moves = np.concatenate([rear, ground]), np.zeros((len(rear) + len(ground), 2))
    moves[: len(rear)] = (3.0, 0.0)
    shown = motions(flow(places, moves))
    result = seen_motion(8.0, 0.4, WIDTH_M, 0.3, np.zeros(2), SPEED_MPS, shown, CAMERA)
    assert result is not None
    np.testing.assert_array_less(np.abs(result.velocity_mps - (3.0, 0.0)), 2.0 * result.sigma_mps)


def test_a_place_without_points_of_its_own_tells_nothing() -> None:
    ground = road()
    empty = motions(flow(ground, np.zeros((len(ground), 2))))
    assert seen_motion(12.0, 0.0, WIDTH_M, 0.3, EXPECTED_MPS, SPEED_MPS, empty, CAMERA) is None
