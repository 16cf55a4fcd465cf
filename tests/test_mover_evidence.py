"""The evidence of one look, from points whose likelihoods are known."""

import numpy as np
import pytest

from vpf_sim.perception.mover_evidence import EvidenceConfig, evidence
from vpf_sim.types import Bools, Floats

CONFIG = EvidenceConfig()


def points(
    moving: int, standing: int = 0, stray: int = 0, contrast: float = 0.0
) -> tuple[Bools, Floats, Floats, Floats]:
    """So many points that only a moving, only a standing and no reading explains."""
    own = np.repeat([1.0, 100.0, 100.0], [moving, standing, stray])
    other = np.repeat([100.0, 1.0, 100.0], [moving, standing, stray])
    return np.ones(len(own), np.bool_), own, other, np.full(len(own), contrast)


def test_points_speak_by_their_count() -> None:
    values = [evidence(*points(count, standing=4), CONFIG) for count in (0, 1, 3, 8)]
    assert values[0] == CONFIG.least
    assert values == sorted(values)
    assert values[-1] > 0.0


@pytest.mark.parametrize("against", [{"standing": 10}, {"stray": 500}, {"contrast": -1.2}])
def test_what_stands_what_is_stray_and_what_is_faint_speak_against(against: dict[str, float]) -> None:
    assert evidence(*points(5), CONFIG) > 0.0
    assert evidence(*points(5, **against), CONFIG) < 0.0  # type: ignore[arg-type]


def test_points_that_both_readings_explain_weigh_little_and_those_outside_nothing() -> None:
    inside, moving, standing, contrast = points(6)
    alone = evidence(inside, moving, standing, contrast, CONFIG)
    both = np.concatenate([np.ones(3), np.full(6, 1.0)])
    more = (
        np.concatenate([np.ones(3, np.bool_), inside]),
        both,
        np.concatenate([np.ones(3), standing]),
        np.concatenate([np.full(3, -3.0), contrast]),
    )
    assert alone - 1.0 <= evidence(*more, CONFIG) <= alone
    outside = (more[0] & (np.arange(9) > 2), *more[1:])
    assert evidence(*outside, CONFIG) == pytest.approx(alone)


def test_a_look_is_bounded() -> None:
    assert evidence(*points(500, contrast=3.0), CONFIG) == CONFIG.most
    assert evidence(*points(2, standing=500, contrast=-5.0), CONFIG) == CONFIG.least
