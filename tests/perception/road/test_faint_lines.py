"""Lines that hardly stand out, on wet roads that mirror what is beside them: worn paint, and paint on concrete."""

import numpy as np
import pytest
from driver_settings import ROBUST
from followed_road import followed

from vpf_sim.evaluation.truth.surroundings import perceived_edges, true_edges
from vpf_sim.perception.road.birds_eye import BirdsEye
from vpf_sim.perception.road.markings import RidgeMap, comb
from vpf_sim.perception.road.model import seen_places, state_of
from vpf_sim.perception.road.state_filter import LaneFilter, Sightings, initial_covariance
from vpf_sim.types import Camera, Floats, Image

CONFIG = ROBUST.road_edges
NUMBERS: Floats = np.arange(-2.0, 3.0)  # of the lines
PAVED = 'worn = true\nsurface = "concrete"\nverge = "paved"'


@pytest.mark.parametrize(
    ("look", "seed"), [('surface = "concrete"', 961), ("worn = true", 966), (PAVED, 871), ('edge_lines = "none"', 871)]
)
def test_faint_lines_are_followed_in_hard_rain(look: str, seed: int) -> None:
    """An empty road that the PID drives along; where the edges come to lie 10 m ahead is off by less than 0.5 m."""
    scenario = f"schema = 1\n[random]\nrows = [0, 0]\n[random.look]\n{look}\n[ego]\nlane = 2\nspeed_mps = 5.55\n"
    errors_m = [
        np.subtract(perceived_edges(edges), true_edges(env.ego, env.road.network))
        for edges, env in followed(scenario, "rain", seed, 300)
    ]
    assert np.mean(np.abs(errors_m).max(axis=1) > 0.5) < 0.02


def drawn_lines(road: Floats, levels: int, gaps: int) -> tuple[BirdsEye, Image]:
    """A patch, and the ridges of the road's five lines in it, seen in one of `gaps` rows."""
    view = BirdsEye(Camera(), CONFIG.patch)
    right_m, _ = seen_places(road, NUMBERS, view.forward_m, view.camera)
    on_line = (np.abs(view.right_m - right_m[..., None]) < 0.08).any(axis=0)
    on_line[np.arange(len(view.forward_m)) % gaps > 0] = False
    return view, np.where(on_line, levels, 0).astype(np.uint8)


def test_a_mirror_image_that_lies_askew_is_no_road() -> None:
    """It is brighter and longer than what is left of the five lines."""
    view, response = drawn_lines(state_of(1.5, 0.0, 0.0, 3.5), 8, gaps=5)
    askew = 1.0 + np.tan(np.radians(11.0)) * view.forward_m
    response[np.abs(view.right_m - askew[:, None]) < 0.08] = 20
    found = comb(RidgeMap(view, response, 5.0, view.visible, CONFIG.centroid_m), np.array([3.5]), 3.5, CONFIG.comb)
    assert found.score > CONFIG.least_comb
    assert np.degrees(found.heading) == pytest.approx(0.0, abs=1.0)
    assert found.y % found.width == pytest.approx(1.5, abs=0.15)


def test_a_mirror_image_that_bends_away_is_no_road() -> None:
    """It is brighter and longer than what is left of the five lines."""
    view, response = drawn_lines(state_of(1.5, 0.0, 0.0, 3.5), 18, gaps=4)
    aside = 1.0 + 0.5 * 0.02 * view.forward_m**2
    response[np.abs(view.right_m - aside[:, None]) < 0.08] = 20
    found = comb(RidgeMap(view, response, 10.0, view.visible, CONFIG.centroid_m), np.array([3.5]), 3.5, CONFIG.comb)
    assert found.curvature == pytest.approx(0.0, abs=0.002)
    assert found.y % found.width == pytest.approx(1.5, abs=0.15)


@pytest.mark.parametrize(("near", "far", "agrees"), [(5, 5, True), (5, 2, True), (5, 1, False), (1, 1, True)])
def test_one_line_far_off_where_more_are_seen_near_is_none_of_the_road(near: int, far: int, agrees: bool) -> None:
    """So many of the lines are seen where they lie, the others nowhere."""
    forward_m: Floats = np.arange(4.0, 28.0, 0.5)
    state = state_of(1.75, 0.0, 0.0, 3.5)
    right_m, _ = seen_places(state, NUMBERS, forward_m, Camera())
    counts = np.where(forward_m < 14.0, near, far)
    seen = np.arange(len(NUMBERS))[:, None] < counts
    sightings = Sightings(NUMBERS, forward_m, right_m, np.full(right_m.shape, 0.02**2), seen)
    tracked = LaneFilter(state, initial_covariance(0.05, 0.005, 0.05, 0.001, CONFIG.filter), Camera(), CONFIG.filter)
    assert tracked.agrees(sightings) is agrees
