"""The tracking scorer on synthetic flows and maps."""

import numpy as np
import pytest

from vpf_sim.evaluation.weather import scorer
from vpf_sim.types import Camera, Expansion, Floats, Flow, ObstacleMap


def flow_at(points_px: Floats) -> Flow:
    """Points that stand still."""
    count = len(points_px)
    none = np.zeros((count, 2))
    return Flow(
        points_px=points_px,
        displacement_px=none,
        gap_s=np.full(count, 0.1),
        past_pose=np.zeros((count, 3)),
        pose=np.zeros(3),
        identity=np.arange(count),
        first_px=points_px,
        first_pose=np.zeros((count, 3)),
        age_frames=np.full(count, 6),
        structure=np.zeros((count, 2, 2)),
    )


def test_the_share_off_counts_errors_above_a_pixel() -> None:
    errors = [np.array([0.2, 1.5, 0.9]), np.array([3.0])]
    assert scorer.share_off(errors) == 0.5
    seen = [np.array([True, False, True]), np.array([True])]
    assert scorer.share_off(errors, seen) == pytest.approx(1.0 / 3.0)
    assert np.isnan(scorer.share_off([]))


def test_an_unknown_focus_is_not_scored() -> None:
    def found(confidence: float) -> Expansion:
        return Expansion(303.0, 204.0, np.eye(2), np.ones(3, np.bool_), confidence)

    assert scorer.foe_error_px(found(1.0), np.array([300.0, 200.0])) == [5.0]
    assert scorer.foe_error_px(found(0.0), np.array([300.0, 200.0])) == []
    assert scorer.foe_error_px(found(1.0), np.array([np.nan, np.nan])) == []


def test_a_cluster_without_a_near_object_is_false() -> None:
    points = np.array([[100.0, 100.0], [108.0, 100.0], [300.0, 300.0], [308.0, 300.0], [500.0, 400.0], [20.0, 20.0]])
    marked = np.array([True, True, True, True, True, False])
    plane = np.zeros((60, 80))
    plane[12, 12:14] = plane[37, 37:39] = plane[50, 62] = 1.0
    seen = ObstacleMap(marked, plane, np.zeros((2, 60, 80)), 8)
    stands = np.zeros((480, 640), np.bool_)
    assert scorer.false_clusters(seen, flow_at(points), stands) == 3
    stands[100, 120] = True  # 12 px right of one point of the first
    assert scorer.false_clusters(seen, flow_at(points), stands) == 2
    stands[300, 340] = True  # too far from the second
    assert scorer.false_clusters(seen, flow_at(points), stands) == 2
    stands[:] = True
    assert scorer.false_clusters(seen, flow_at(points), stands) == 0


def test_a_score_without_samples_is_nan() -> None:
    score = scorer.TrackingScorer(Camera(), 60.0, 0).score()
    assert np.isnan([score.off, score.foe_px, score.ttc_error, score.hidden, score.survive_6]).all()


def test_the_rim_of_a_hidden_region_is_not_visible() -> None:
    hidden = np.zeros((40, 60), np.bool_)
    hidden[20, 30] = True
    sight = scorer.in_sight(hidden)
    assert np.count_nonzero(~sight) == (2 * scorer.RIM_PX + 1) ** 2
    assert not sight[20 - scorer.RIM_PX, 30 + scorer.RIM_PX]
    assert sight[20, 31 + scorer.RIM_PX]
