"""Lines that hardly stand out, on wet roads that mirror what is beside them: worn paint, and paint on concrete."""

from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from driver_settings import ROBUST

from vpf_sim import drivers
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.episode.episode import read, setup_for
from vpf_sim.evaluation.truth.surroundings import perceived_edges, true_edges
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.perception.road.birds_eye import BirdsEye
from vpf_sim.perception.road.edge_tracker import RoadEdgeTracker
from vpf_sim.perception.road.markings import RidgeMap, comb
from vpf_sim.perception.road.model import CURVATURES, seen_places, state_of
from vpf_sim.perception.road.relocalisation import Relocalisation
from vpf_sim.perception.road.state_filter import LaneFilter, Sightings, initial_covariance
from vpf_sim.types import Camera, Floats, Image

CONFIG = ROBUST.road_edges
assert CONFIG.relocalisation is not None
RELOCALISATION = CONFIG.relocalisation
NUMBERS: Floats = np.arange(-2.0, 3.0)  # of the lines
PAVED = 'worn = true\nsurface = "concrete"\nverge = "paved"'


@pytest.mark.parametrize(
    ("look", "seed"),
    [('surface = "concrete"', 961), ("worn = true", 966), (PAVED, 870), ('edge_lines = "none"', 871)],
)
def test_faint_lines_are_followed_in_hard_rain(look: str, seed: int, tmp_path: Path) -> None:
    """An empty road that the PID drives along; where the edges come to lie 10 m ahead is off by less than 0.5 m."""
    road = f"schema = 1\n[random]\nrows = [0, 0]\n[random.look]\n{look}\n[ego]\nlane = 2\nspeed_mps = 5.55\n"
    scenario = tmp_path / "road.toml"
    scenario.write_text(road)
    pilot = drivers.create("pid")
    errors_m = []
    with closing(FourLane(str(scenario), "rain")) as env:
        observed, _ = env.reset(seed=seed)
        setup = setup_for(pilot, env, seed)
        pilot.reset(setup)
        tracker = RoadEdgeTracker(setup.camera, CONFIG, setup.rate_hz)
        for _ in range(420):
            now = read(observed)
            pose = np.array([now.x_m, now.y_m, now.yaw_rad])
            edges = tracker.update(now.image, grey(now.image), pose, now.speed_mps, now.yaw_rate_radps, None)
            errors_m.append(np.subtract(perceived_edges(edges), true_edges(env.ego, env.road.network)))
            command = drivers.command_of(pilot, now)
            observed, *_ = env.step(np.array([command.throttle, command.steering]))
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
    score, (y, heading, _, width) = comb(
        RidgeMap(view, response, 5.0, view.visible, CONFIG.centroid_m), np.array([3.5]), 3.5, CONFIG.comb
    )
    assert score > CONFIG.least_comb
    assert np.degrees(heading) == pytest.approx(0.0, abs=1.0)
    assert y % width == pytest.approx(1.5, abs=0.15)


def test_a_mirror_image_that_bends_away_is_no_road() -> None:
    """It is brighter and longer than what is left of the five lines."""
    view, response = drawn_lines(state_of(1.5, 0.0, 0.0, 3.5), 18, gaps=4)
    aside = 1.0 + 0.5 * 0.02 * view.forward_m**2
    response[np.abs(view.right_m - aside[:, None]) < 0.08] = 20
    _, (y, _, curvature, width) = comb(
        RidgeMap(view, response, 10.0, view.visible, CONFIG.centroid_m), np.array([3.5]), 3.5, CONFIG.comb
    )
    assert curvature == pytest.approx(0.0, abs=0.002)
    assert y % width == pytest.approx(1.5, abs=0.15)


def rival(wrong_rad: float, wrong_per_m: float) -> tuple[Floats, Floats | None]:
    """A road that is seen in every other row, and the rival of one so far off in its direction and its curvature."""
    truth = state_of(1.75, 0.02, 0.005, 3.5)
    view, response = drawn_lines(truth, 10, gaps=2)
    followed = truth.copy()
    followed[1] += wrong_rad
    followed[CURVATURES] += wrong_per_m
    ridges = RidgeMap(view, response, 5.0, view.visible, CONFIG.centroid_m)
    return truth, Relocalisation(RELOCALISATION, CONFIG).rival_of(followed, ridges, NUMBERS)


@pytest.mark.parametrize("wrong", [(0.0, 0.02), (0.03, -0.015)])
def test_a_road_that_drifted_from_its_lines_has_a_rival_on_them(wrong: tuple[float, float]) -> None:
    truth, found = rival(*wrong)
    assert found is not None
    ahead_m = np.array([8.0, 20.0])
    found_m, true_m = (seen_places(road, NUMBERS, ahead_m, Camera())[0] for road in (found, truth))
    assert found_m == pytest.approx(true_m, abs=0.15)


def test_a_road_on_its_lines_has_no_rival() -> None:
    assert rival(0.0, 0.0)[1] is None


@pytest.mark.parametrize(
    ("agreement", "heading_rad", "found", "left"),
    [
        (0.5, 0.0, [True, True], True),
        (0.5, 0.0, [True, False, True, False], False),
        (0.9, 0.0, [True] * 4, False),
        (0.5, 0.2, [True] * 4, False),
    ],
    ids=["twice in a row", "now and then", "its lines are seen", "turned from it"],
)
def test_a_followed_road_is_left_for_a_rival_that_lasts(
    agreement: float, heading_rad: float, found: list[bool], left: bool
) -> None:
    """Searches in which the tracked road lies beside its lines or on them, as `found`."""
    truth = state_of(1.75, heading_rad, 0.005, 3.5)
    view, response = drawn_lines(truth, 10, gaps=2)
    ridges, relocalisation = (
        RidgeMap(view, response, 5.0, view.visible, CONFIG.centroid_m),
        Relocalisation(RELOCALISATION, CONFIG),
    )
    drifted = truth.copy()
    drifted[CURVATURES] += 0.02
    states = [drifted if beside else truth for beside in found]
    rivals = [relocalisation.search(state, agreement, ridges, NUMBERS) for state in states]
    assert any(rival is not None for rival in rivals) is left


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
