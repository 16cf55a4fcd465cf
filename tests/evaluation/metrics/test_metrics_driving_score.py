"""CARLA's scores at the factors that its leaderboard publishes."""

import numpy as np
import pytest

from vpf_sim.evaluation.metrics.collision import driving_score_2_0, driving_score_2_1, off_lane_share


@pytest.mark.parametrize(
    ("kind", "score_2_0", "score_2_1"),
    [
        ("pedestrian", 0.50, 1.0 / 2.0),
        ("car", 0.60, 1.0 / 1.7),
        ("van", 0.60, 1.0 / 1.7),
        ("truck", 0.60, 1.0 / 1.7),
        ("cone", 0.65, 1.0 / 1.6),
        ("pallet", 0.65, 1.0 / 1.6),
        ("barrier", 0.65, 1.0 / 1.6),
    ],
)
def test_one_collision(kind: str, score_2_0: float, score_2_1: float) -> None:
    assert driving_score_2_0(1.0, [kind], 0.0) == pytest.approx(score_2_0)
    assert driving_score_2_1(1.0, [kind], 0.0) == pytest.approx(score_2_1)


def test_collisions_multiply_in_2_0_and_add_in_2_1() -> None:
    assert driving_score_2_0(0.5, ["car", "cone"], 0.2) == pytest.approx(0.5 * 0.6 * 0.65 * 0.8)
    assert driving_score_2_1(0.5, ["car", "cone"], 0.2) == pytest.approx(0.5 * 0.8 / (1.0 + 0.7 + 0.6))


def test_a_clean_drive_scores_its_completion() -> None:
    assert driving_score_2_0(0.7, [], 0.0) == driving_score_2_1(0.7, [], 0.0) == 0.7


def test_the_off_lane_share_counts_metres_and_not_time() -> None:
    route_m = np.array([0.0, 1.0, 2.0, 2.0, 2.0, 4.0])  # it stands for two steps, outside
    outside = np.array([0.0, 0.0, 1.0, 1.0, 1.0, 0.0])
    assert off_lane_share(route_m, outside) == pytest.approx(2.0 / 4.0)
    assert off_lane_share(np.zeros(4), np.ones(4)) == 0.0
