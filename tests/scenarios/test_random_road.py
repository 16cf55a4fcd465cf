"""Random roads keep the limits of the file for every seed."""

from functools import cache
from itertools import pairwise

import numpy as np

from vpf_sim import scenarios
from vpf_sim.envs.road import build_road
from vpf_sim.scenarios import SIZES, RandomScenario, Scenario
from vpf_sim.seeding import stream

SEEDS = range(300)
FREE_GAP_M, LANE_M, HALF_M = 3.5, 3.5, 7.0


def load() -> RandomScenario:
    scenario = scenarios.load("random")
    assert isinstance(scenario, RandomScenario)
    return scenario


@cache
def all_drawn() -> list[Scenario]:
    """One for each seed."""
    return [load().draw(seed) for seed in SEEDS]


def rows(scenario: Scenario) -> list[list[tuple[float, float, float]]]:
    """For each row, (s, left, right) m of its obstacles, from the left."""
    found: dict[float, list[tuple[float, float, float]]] = {}
    for obj in scenario.bodies:
        centre, half = scenario.road.lane_offset_m(obj.lane) + obj.lateral_m, SIZES[obj.kind].width_m / 2.0
        found.setdefault(obj.s_m, []).append((obj.s_m, centre - half, centre + half))
    return [sorted(found[s], key=lambda obj: obj[1]) for s in sorted(found)]


def gaps(row: list[tuple[float, float, float]]) -> list[tuple[float, float]]:
    """The wide enough gaps across the carriageway."""
    edges = [-HALF_M, *(edge for _, left, right in row for edge in (left, right)), HALF_M]
    return [(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a >= FREE_GAP_M - 1e-9]


def reachable(scenario: Scenario) -> bool:
    """Whether a chain of gaps with middles at most two lanes apart leads from the ego's lane through all rows."""
    places = [(scenario.road.lane_offset_m(scenario.ego.lane),) * 2]
    for row in rows(scenario):
        middles = [(a + FREE_GAP_M / 2.0, b - FREE_GAP_M / 2.0) for a, b in gaps(row)]
        reach = 2.0 * LANE_M + 1e-9
        places = [
            (max(low, a - reach), min(high, b + reach))
            for low, high in middles
            for a, b in places
            if low <= b + reach and high >= a - reach
        ]
    return bool(places)


def test_routes_bends_and_rows_are_within_the_limits() -> None:
    for drawn in all_drawn():
        assert 250.0 <= drawn.goal.s_m - drawn.ego.s_m <= 400.0
        radii = [getattr(part, "radius_m", getattr(part, "end_radius_m", None)) for part in drawn.road.segments]
        assert all(abs(radius) >= 80.0 for radius in radii if radius is not None)
        assert 0 <= len(rows(drawn)) <= 4


def test_rows_keep_their_distances_and_a_reachable_gap() -> None:
    for drawn in all_drawn():
        places = [row[0][0] for row in rows(drawn)]
        assert all(place - drawn.ego.s_m >= 50.0 for place in places)
        assert all(after - before >= 40.0 for before, after in pairwise(places))
        assert all(gaps(row) for row in rows(drawn))
        assert reachable(drawn)


def test_obstacles_of_a_row_do_not_touch() -> None:
    for drawn in all_drawn():
        assert all(b[1] > a[2] for row in rows(drawn) for a, b in pairwise(row))


def test_draws_cover_all_kinds_row_counts_and_bend_directions() -> None:
    assert {obj.kind for drawn in all_drawn() for obj in drawn.bodies} == set(SIZES) - {"cyclist", "deer", "door"}
    assert {len(rows(drawn)) for drawn in all_drawn()} == {0, 1, 2, 3, 4}
    radii = [part.radius_m for drawn in all_drawn() for part in drawn.road.segments if part.kind == "arc"]
    assert min(radii) < -80.0
    assert max(radii) > 80.0
    headings = [drawn.road.heading_deg for drawn in all_drawn()]
    assert min(headings) < -120.0
    assert max(headings) > 120.0


def test_roads_never_come_near_themselves() -> None:
    for drawn in all_drawn()[:60]:
        centre = build_road(drawn, stream(0, "road")).network.centre
        s = np.arange(0.0, drawn.road.length_m, 2.0)
        points = np.array([centre.position_at(float(station), 0.0) for station in s])
        apart = np.hypot(*(points[:, None] - points[None]).T)
        along = np.abs(s[:, None] - s[None])
        assert (apart[along > 40.0] > 2.0 * HALF_M).all()


def test_seed_determines_the_road() -> None:
    assert load().draw(5) == load().draw(5)
    assert load().draw(5).road != load().draw(6).road
