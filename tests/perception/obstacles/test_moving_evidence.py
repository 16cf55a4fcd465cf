"""The evidence of one look, from points whose likelihoods are known."""

import numpy as np
import pytest

from vpf_sim.perception.obstacles.moving.evidence import EvidenceConfig, Mirror, evidence
from vpf_sim.types import Bools, Floats

CONFIG = EvidenceConfig()
WET = CONFIG.faint(1.0, 12.0)


def points(
    moving: int, standing: int = 0, stray: int = 0, contrast: float = 0.0
) -> tuple[Bools, Floats, Floats, Floats]:
    """So many points that only a moving, only a standing and no reading explains."""
    own = np.repeat([1.0, 100.0, 100.0], [moving, standing, stray])
    other = np.repeat([100.0, 1.0, 100.0], [moving, standing, stray])
    return np.ones(len(own), np.bool_), own, other, np.full(len(own), contrast)


def test_points_speak_by_their_count() -> None:
    values = [evidence(*points(count, standing=4), WET, CONFIG) for count in (0, 1, 3, 8)]
    assert values[0] == CONFIG.least
    assert values == sorted(values)
    assert values[-1] > 0.0


@pytest.mark.parametrize("against", [{"standing": 10}, {"stray": 50}, {"contrast": -1.2}])
def test_what_stands_what_is_stray_and_what_is_faint_speak_against(against: dict[str, float]) -> None:
    alone = {"contrast": -0.6}
    assert evidence(*points(5, **alone), WET, CONFIG) > 0.0
    assert evidence(*points(5, **alone | against), WET, CONFIG) < 0.0  # type: ignore[arg-type]


def test_points_that_both_readings_explain_weigh_little_and_those_outside_nothing() -> None:
    inside, moving, standing, contrast = points(6)
    alone = evidence(inside, moving, standing, contrast, WET, CONFIG)
    both = np.concatenate([np.ones(3), np.full(6, 1.0)])
    more = (
        np.concatenate([np.ones(3, np.bool_), inside]),
        both,
        np.concatenate([np.ones(3), standing]),
        np.concatenate([np.full(3, -3.0), contrast]),
    )
    assert alone - 1.0 <= evidence(*more, WET, CONFIG) <= alone
    outside = (more[0] & (np.arange(9) > 2), *more[1:])
    assert evidence(*outside, WET, CONFIG) == pytest.approx(alone)


def test_a_look_is_bounded() -> None:
    assert evidence(*points(500, contrast=3.0), WET, CONFIG) == CONFIG.most
    assert evidence(*points(2, standing=500, contrast=-5.0), WET, CONFIG) == CONFIG.least


def test_what_is_faint_speaks_against_a_body_where_the_road_mirrors_and_where_it_may_be_far_asphalt() -> None:
    dark = points(5, contrast=-1.8)
    values = [evidence(*dark, CONFIG.faint(mirror, 12.0), CONFIG) for mirror in (0.0, 0.5, 1.0)]
    assert values == sorted(values, reverse=True)
    assert values[0] > 0.0 > values[-1]
    far = [evidence(*dark, CONFIG.faint(0.0, depth_m), CONFIG) for depth_m in (12.0, 17.0, 25.0)]
    assert far == sorted(far, reverse=True)
    assert far[0] > 0.0 > far[-1]


@pytest.mark.parametrize(("below", "degree"), [(3, 0.0), (40, 1.0)])
def test_how_far_the_road_mirrors_is_told_by_the_points_below_it(below: int, degree: float) -> None:
    mirror = Mirror(CONFIG, 0.05)
    assert mirror.degree == 1.0
    for _ in range(40):
        mirror.update(below, 100)
    assert mirror.degree == pytest.approx(degree, abs=0.05)
    for _ in range(200):
        mirror.update(0, 0)
    assert mirror.degree == pytest.approx(degree, abs=0.05), "standing, nothing is learned and nothing forgotten"


@pytest.mark.parametrize(
    ("own", "wet"),
    [(0.3, -1.2), (-0.05, -1.2), (-0.9, -2.0), (-1.05, -1.675), (-1.5, -1.2)],
    ids=["bright", "plain", "dark", "in doubt", "an image"],
)
def test_a_body_s_image_is_fainter_than_what_is_above_it(own: float, wet: float) -> None:
    upper = own + np.array([-0.3, 0.0, 0.3])
    assert CONFIG.image(1.0, upper) == pytest.approx(wet)
    assert CONFIG.image(0.0, upper) == CONFIG.dry_image
    assert CONFIG.image(0.5, upper) == pytest.approx(0.5 * (wet + CONFIG.dry_image))


def test_where_nothing_is_above_an_image_is_told_by_its_contrast_alone() -> None:
    assert CONFIG.image(1.0, np.empty(0)) == pytest.approx(CONFIG.wet_image)
