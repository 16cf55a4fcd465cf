"""Errors of flow and time to contact for a camera that drives at a wall, in closed form."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vpf_sim.driver_interface import Observation
from vpf_sim.evaluation.metrics import perception
from vpf_sim.evaluation.truth.perception_errors import PerceptionErrors
from vpf_sim.types import Camera, Floats

RATE_HZ, STEP_M, DISTANCE_M = 20.0, 0.5, 10.0
CAMERA = Camera()
POINTS = np.array([[400.0, 300.0], [100.0, 50.0], [20.0, 460.0]])


class Wall:
    """It fills the frame, DISTANCE_M before the camera whenever it is read."""

    objects: tuple[Any, ...] = ()
    read = 0

    def truth(self, names: tuple[str, ...]) -> dict[str, Any]:
        self.read += 1
        shape = (CAMERA.height_px, CAMERA.width_px)
        truth = {"depth": np.full(shape, DISTANCE_M, np.float32), "instance": np.full(shape, -1, np.int32)}
        return {name: truth[name] for name in names}


def perceived(displacement_px: Floats, ttc_s: float, frames: int = 2) -> Any:
    """What a driver perceives in a frame."""
    gap = np.full(len(POINTS), frames / RATE_HZ)
    flow = SimpleNamespace(points_px=POINTS, displacement_px=displacement_px, gap_s=gap)
    times = np.full(len(POINTS), ttc_s)
    return SimpleNamespace(flow=flow, features=SimpleNamespace(ttc_s=times), obstacles=np.empty(0))


def scored(displacement_px: Floats, ttc_s: float, frames: int = 2, late: int = 0) -> dict[str, float]:
    """The columns of the first scored frame at 2 s, or of one `late` frames later that the driver uses."""
    network = SimpleNamespace()
    ego = SimpleNamespace(road=SimpleNamespace(vehicles=[], objects=[]), place=(0.0, 0.0), position=np.zeros(2))
    ego.heading = 0.0
    wall = Wall()
    env = SimpleNamespace(renderer=wall, camera=CAMERA, rate_hz=RATE_HZ, ego=ego, road=SimpleNamespace(network=network))
    env.nearest = (np.inf, None)
    sight, made = PerceptionErrors(), perceived(displacement_px, ttc_s, frames)
    for k in range(40 + late):
        observation = Observation(np.zeros((1, 1, 3), np.uint8), k / RATE_HZ, k * STEP_M, 0.0, 0.0, 10.0, 0.0, (0, 0))
        sight.observe(observation, env)
        if not 39 <= k < 39 + late:  # in between the driver goes by the frame before
            made = perceived(displacement_px, ttc_s, frames)
        found = sight.columns(made)
        assert ("flow_error_px" in found) == (k == 39 + late)
    assert wall.read == 1
    return found


def expansion(frames: int) -> Floats:
    """The true flow: points move away from the principal point as the wall comes nearer."""
    way_m = frames * STEP_M
    away: Floats = (POINTS - (CAMERA.cx_px, CAMERA.cy_px)) * way_m / (DISTANCE_M + way_m)
    return away


@pytest.mark.parametrize("late", [0, 2])
def test_true_flow_and_true_times_have_no_error(late: int) -> None:
    found = scored(expansion(2), ttc_s=DISTANCE_M / (STEP_M * RATE_HZ), late=late)
    assert found["flow_error_px"] == pytest.approx(0.0, abs=1e-9)
    assert found["ttc_error"] == pytest.approx(0.0, abs=1e-6)


def test_known_errors_are_measured() -> None:
    found = scored(expansion(1) + np.array([30.0, 40.0]), ttc_s=1.25, frames=1)
    assert found["flow_error_px"] == pytest.approx(50.0, abs=0.2), "the best of nine pixels counts"
    assert found["ttc_error"] == pytest.approx(0.25)


def test_tracks_longer_than_the_known_poses_are_left_out() -> None:
    found = scored(expansion(3), ttc_s=np.inf, frames=3)
    assert np.isnan(found["flow_error_px"])
    assert found["ttc_error"] == 1.0, "no estimate"


def test_medians_over_the_scored_frames() -> None:
    nan = np.nan
    assert perception.points(np.array([nan, 0.2, nan, 0.4, 0.3]), np.array([nan] * 5)) == {
        "flow_median_error_px": pytest.approx(0.3),
        "ttc_median_error": None,
    }
