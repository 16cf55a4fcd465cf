"""The evidence of one observation, from points whose likelihoods are known."""

import numpy as np
import pytest
from driver_settings import moving_obstacles

from vpf_sim.perception.obstacles.moving.evidence import evidence
from vpf_sim.perception.obstacles.moving.mirror import Reflectivity, faint_contrast, image_contrast
from vpf_sim.types import Bools, Floats

CONFIG = moving_obstacles().evidence
CONTRAST, IMAGE = CONFIG.contrast, moving_obstacles().mirror_image
WET = faint_contrast(1.0, 12.0, CONTRAST)


def points(
    moving: int, standing: int = 0, stray: int = 0, contrast: float = 0.0
) -> tuple[Bools, Floats, Floats, Floats]:
    """Points that only a moving, only a standing and no hypothesis explains."""
    own = np.repeat([1.0, 100.0, 100.0], [moving, standing, stray])
    other = np.repeat([100.0, 1.0, 100.0], [moving, standing, stray])
    return np.ones(len(own), np.bool_), own, other, np.full(len(own), contrast)


def test_points_speak_by_their_count() -> None:
    values = [evidence(*points(count, standing=4), WET, CONFIG) for count in (0, 1, 3, 8)]
    assert values[0] == CONFIG.least
    assert values == sorted(values)
    assert values[-1] > 0.0


@pytest.mark.parametrize("against", [{"standing": 10}, {"stray": 50}, {"contrast": -1.2}])
def test_standing_stray_and_faint_points_speak_against_a_track(against: dict[str, float]) -> None:
    alone = {"contrast": -0.6}
    assert evidence(*points(5, **alone), WET, CONFIG) > 0.0
    assert evidence(*points(5, **alone | against), WET, CONFIG) < 0.0  # type: ignore[arg-type]


def test_undecided_points_weigh_little_and_points_outside_nothing() -> None:
    inside, moving, standing, contrast = points(6)
    alone = evidence(inside, moving, standing, contrast, WET, CONFIG)
    undecided = (np.ones(3, np.bool_), np.ones(3), np.ones(3), np.full(3, -3.0))
    more = [np.concatenate(parts) for parts in zip(undecided, (inside, moving, standing, contrast), strict=True)]
    assert alone - 1.0 <= evidence(*more, WET, CONFIG) <= alone
    more[0] = np.arange(9) > 2
    assert evidence(*more, WET, CONFIG) == pytest.approx(alone)


def test_evidence_of_one_observation_is_bounded() -> None:
    """What is seen through or faint rejects a track."""
    assert evidence(*points(500, contrast=3.0), WET, CONFIG) == CONFIG.most
    for seen in (points(8, standing=20, contrast=0.5), points(8, contrast=-3.0)):
        assert evidence(*seen, WET, CONFIG) == CONFIG.least


def test_faint_points_speak_against_a_track_on_a_wet_road_and_far_away() -> None:
    dark = points(5, contrast=-1.8)
    values = [evidence(*dark, faint_contrast(mirror, 12.0, CONTRAST), CONFIG) for mirror in (0.0, 0.5, 1.0)]
    assert values == sorted(values, reverse=True)
    assert values[0] > 0.0 > values[-1]
    far = [evidence(*dark, faint_contrast(0.0, depth_m, CONTRAST), CONFIG) for depth_m in (12.0, 17.0, 25.0)]
    assert far == sorted(far, reverse=True)
    assert far[0] > 0.0 > far[-1]


@pytest.mark.parametrize(("below", "degree"), [(3, 0.0), (40, 1.0)])
def test_reflectivity_follows_the_share_of_points_below_the_road(below: int, degree: float) -> None:
    mirror = Reflectivity(moving_obstacles().reflectivity, 0.05)
    assert mirror.degree == 1.0
    for _ in range(40):
        mirror.update(below, 100)
    assert mirror.degree == pytest.approx(degree, abs=0.05)
    for _ in range(200):
        mirror.update(0, 0)
    assert mirror.degree == pytest.approx(degree, abs=0.05), "the estimate stays at standstill"


@pytest.mark.parametrize(
    ("own", "wet"),
    [(0.3, -1.2), (-0.05, -1.2), (-0.9, -2.0), (-1.05, -1.675), (-1.5, -1.2)],
    ids=["bright", "plain", "dark", "in doubt", "an image"],
)
def test_a_mirror_image_is_fainter_than_the_upper_part_of_its_vehicle(own: float, wet: float) -> None:
    upper = own + np.array([-0.3, 0.0, 0.3])
    assert image_contrast(1.0, upper, IMAGE) == pytest.approx(wet)
    assert image_contrast(0.0, upper, IMAGE) == IMAGE.dry
    assert image_contrast(0.5, upper, IMAGE) == pytest.approx(0.5 * (wet + IMAGE.dry))


def test_without_upper_points_an_image_is_known_by_its_contrast_alone() -> None:
    assert image_contrast(1.0, np.empty(0), IMAGE) == pytest.approx(IMAGE.wet)
