"""The table of points: which identities are among others."""

import numpy as np

from vpf_sim.perception.obstacles.point_hypotheses import among


def test_identities_among_others_in_any_order() -> None:
    identity, others = np.array([4, 0, 9, 7, 2]), np.array([9, 3, 0, 9])
    assert among(identity, others).tolist() == [False, True, True, False, False]
    assert among(identity, others[:0]).tolist() == [False] * 5
    assert among(identity[:0], others).tolist() == []
