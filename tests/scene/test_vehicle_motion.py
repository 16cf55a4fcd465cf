"""The velocity of a vehicle whose place is known, from points that are projected from it and from the road behind."""

import numpy as np
import pytest
from made_flow import CAMERA, SPEED_MPS, body, flow, motions, road

from vpf_sim.scene.vehicle_motion import Seen, seen_motion
from vpf_sim.types import Floats

WIDTH_M, EXPECTED_MPS = 1.8, np.array([5.0, 0.0])
NOTHING: Floats = np.empty((0, 3))


def seen_of(
    face: Floats,
    velocity_mps: tuple[float, float],
    beyond: Floats,
    believed_m: float,
    width_m: float = WIDTH_M,
    expected_mps: Floats = EXPECTED_MPS,
) -> Seen | None:
    """Of the points of a face on a road, and of the static scene far behind it in its outline."""
    places = np.concatenate([face, road(), beyond])
    moves = np.zeros((len(places), 2))
    moves[: len(face)] = velocity_mps
    return seen_motion(believed_m, 0.4, width_m, 0.3, expected_mps, SPEED_MPS, motions(flow(places, moves)), CAMERA)


def rear(forward_m: float) -> Floats:
    return body(forward_m + 0.3, 0.4, WIDTH_M, 0.2, 1.4)


def found(forward_m: float, velocity_mps: tuple[float, float], believed_m: float | None = None) -> Seen | None:
    """Of a car's rear, with points far behind it."""
    beyond = body(3.0 * forward_m, 1.2, 3.0 * WIDTH_M, 0.0, 1.4, 10)
    return seen_of(rear(forward_m), velocity_mps, beyond, believed_m or forward_m)


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
    result = seen_of(pallet, (0.0, 0.0), beyond, forward_m, 0.8, np.zeros(2))
    assert result is None or (np.abs(result.velocity_mps) < 3.0 * result.sigma_mps).all()


def test_a_car_that_stood_has_its_speed_when_it_drives_off() -> None:
    result = seen_of(rear(8.0), (3.0, 0.0), NOTHING, 8.0, expected_mps=np.zeros(2))
    assert result is not None
    np.testing.assert_array_less(np.abs(result.velocity_mps - (3.0, 0.0)), 2.0 * result.sigma_mps)


def test_a_place_without_points_of_its_own_tells_nothing() -> None:
    assert seen_of(NOTHING, (0.0, 0.0), NOTHING, 12.0) is None
