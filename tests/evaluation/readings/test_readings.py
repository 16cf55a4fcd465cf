"""The space of readings gives variants with the requested gains; the search stops early and is reproducible."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vpf_sim import cli, configuration
from vpf_sim.evaluation.readings import outcome, search, space
from vpf_sim.evaluation.readings.search import SearchSettings, Trial
from vpf_sim.evaluation.readings.space import Reading
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.perception.paper.obstacle_map import rasterise, smoothed_gradient
from vpf_sim.planning import variant
from vpf_sim.planning.paper import obstacle_field, road_field
from vpf_sim.planning.paper.planner import PaperPlannerConfig
from vpf_sim.planning.variant import Variant
from vpf_sim.types import Camera, ObstacleMap

SPACE = space.quantities()
FIRST: Reading = {one.name: next(iter(one.choices), 0.05) for one in SPACE}


def built(reading: Reading, folder: Path) -> Variant:
    return variant.load(search.write(folder, 0, reading).removeprefix("vpf@"))


def line_of(reading: Reading, folder: Path) -> PaperPlannerConfig:
    line = built(reading, folder).paper_planner
    assert line is not None
    return line


def test_every_reading_of_every_quantity_is_a_variant_and_no_two_are_the_same(tmp_path: Path) -> None:
    for quantity in SPACE:
        made = [built({**FIRST, quantity.name: choice}, tmp_path) for choice in quantity.choices]
        assert all(one != other for i, one in enumerate(made) for other in made[:i]), quantity.name
        assert all(source.startswith(("print", "reference", "reading", "ours")) for source in quantity.sources.values())


@pytest.mark.parametrize("sigma", ["half-width", "eighth-width"])
@pytest.mark.parametrize("area", ["frame", "obstacles"])
def test_push_is_the_turn_that_an_obstacle_causes(sigma: str, area: str, tmp_path: Path) -> None:
    """An obstacle of 60 x 60 px, 100 px right of the middle, against a target straight ahead."""
    reading = {**FIRST, "sigma": sigma, "area": area, "goal": "two-horizons", "push": 0.1}
    made, line = built(reading, tmp_path), line_of(reading, tmp_path)
    grid = np.meshgrid(np.arange(390.0, 450.0, 2.0), np.arange(210.0, 270.0, 2.0))
    plane = rasterise(np.stack([axis.ravel() for axis in grid], axis=1), Camera(), made.obstacle_map)
    seen = ObstacleMap(np.ones(1, np.bool_), plane, smoothed_gradient(plane, made.obstacle_map), 8)
    force = obstacle_field.force(seen, np.ones(1), Camera(), line.obstacle_field)
    coarse = 0.3  # the plane's cells of 8 px make the obstacle a little larger or smaller
    assert force[0] / (line.target_field.alpha * 60.0) == pytest.approx(0.1, rel=coarse)


@pytest.mark.parametrize(
    ("minimum", "edges_m"), [("carriageway", (5.25, -8.75)), ("lane", (1.75, -1.75)), ("preferred", (5.25, -5.25))]
)
@pytest.mark.parametrize("steepness", ["printed", "half"])
def test_stiffness_is_the_turn_that_the_road_causes_beside_its_minimum(
    minimum: str, edges_m: tuple[float, float], steepness: str, tmp_path: Path
) -> None:
    reading = {**FIRST, "minimum": minimum, "steepness": steepness, "goal": "two-horizons", "stiffness": 0.02}
    line = line_of(reading, tmp_path)
    assert line.road_field.edges == minimum
    beside_m = 0.01
    force = road_field.force(0.5 * sum(edges_m) + beside_m, *edges_m, 0, line.road_field)[1] * line.total_field.lambda_y
    assert force / (line.target_field.alpha * 60.0) == pytest.approx(0.02 * beside_m, rel=0.02)


def test_a_written_variant_is_the_table_it_was_written_from(tmp_path: Path) -> None:
    table = space.variant_table({**FIRST, "flow": "checked", "goal": "lane-ahead"})
    path = tmp_path / "one.toml"
    path.write_text(space.toml(table))
    assert configuration.read_file(path, "variant") == table


class Scripted:
    """Proposes the same readings again and again, with `push` counted up."""

    def __init__(self) -> None:
        self.asked, self.told = 0, list[float]()

    def ask(self, count: int) -> list[Reading]:
        self.asked += count
        return [{**FIRST, "push": 0.01 + 0.01 * (self.asked - count + i)} for i in range(count)]

    def tell(self, scores: Sequence[float]) -> None:
        self.told += scores


class World:
    """Cells that the readings with an even number pass, with an error that falls with the number."""

    def __init__(self, error_m2: float = 0.4) -> None:
        self.error_m2 = error_m2
        self.driven: list[tuple[str, str, str]] = []

    def drive(self, plan: Plan, folder: Path) -> list[dict[str, Any]]:
        assert folder.parts
        records = []
        for job in plan.jobs():
            number = int(job.driver.removesuffix(".toml")[-3:])
            good = number % 2 == 0
            self.driven.append((job.scenario, job.weather, job.driver))
            records.append(
                {
                    **job._asdict(),
                    "status": "success" if good else "collision",
                    "route_completion": 1.0 if good else 0.3,
                    "path_mse_m2": self.error_m2 / (1 + number) if good else None,
                    "min_clearance_m": 0.4,
                    "accuracy": {"shadow": {"steering": {"span": 0.8}}},
                }
            )
        return records


def test_a_reading_that_fails_a_cell_does_not_drive_the_next(tmp_path: Path) -> None:
    world, optimiser = World(), Scripted()
    tried = search.search(SearchSettings(readings=6, generation=4), tmp_path, world.drive, optimiser)
    assert [one.number for one in tried] == [0, 1, 2, 3, 4, 5]
    assert [outcome.passed(one) for one in tried] == [4, 0, 4, 0, 4, 0]
    driven = [driver for *_, driver in world.driven]
    assert [driven.count(one.driver) for one in tried] == [4, 1, 4, 1, 4, 1]
    assert optimiser.told == [one.score for one in tried]
    assert sorted(tried, key=lambda one: -one.score)[0].number == 4, "the smallest error of those that pass"


def test_a_reading_with_a_large_path_error_does_not_drive_the_next(tmp_path: Path) -> None:
    world = World(error_m2=2.0)  # 2, 0.67 and 0.4 m2 of numbers 0, 2 and 4; the paper's first two cells: 0.74, 0.42
    tried = search.search(SearchSettings(readings=6, generation=6), tmp_path, world.drive, Scripted())
    assert [len(one.cells) for one in tried] == [1, 1, 2, 1, 4, 1]


def test_the_best_drive_again_on_other_seeds(tmp_path: Path) -> None:
    world, asked = World(), SearchSettings(readings=5, generation=5, finalists=2, final_seeds="10:13")
    tried = search.search(asked, tmp_path, world.drive, Scripted())
    world.driven.clear()
    best = search.finals(asked, tried, tmp_path, world.drive)
    assert [one.number for one in best] == [4, 2]
    assert len(world.driven) == 2 * 4 * 3
    assert all(cell["episodes"] == 3 for one in best for cell in one.cells.values())


def cell(successes: int, mse: float | None, route: float = 1.0) -> dict[str, Any]:
    return {"successes": successes, "episodes": 2, "route": route, "path_mse_m2": mse}


def test_a_score_counts_cells_then_the_route_then_the_error() -> None:
    name = "town04.clear"  # the paper's error there is 0.74 m2
    assert search.score({name: cell(2, 0.74)}) == pytest.approx(1.25)
    assert search.score({name: cell(2, 0.0)}) == 1.5
    assert search.score({name: cell(2, 9.0)}) == 1.0
    assert search.score({name: cell(0, None, 0.4)}) == pytest.approx(0.2)
    assert (
        search.score({name: cell(2, 0.74), "town04.rain": cell(0, None, 0.1)})
        > search.score({name: cell(2, 0.0)}) - 0.3
    )
    assert search.score({}) == 0.0


def test_results_are_counted_by_choice_and_part_of_a_range() -> None:
    passes = {f"{scenario}.{weather}": cell(2, 0.5) for scenario, weather in search.CELLS}
    tried = [
        Trial(0, {**FIRST, "push": 0.011}, "a", passes, 5.0),
        Trial(1, {**FIRST, "push": 0.4, "region": "horizon-corridor"}, "b", {"town04.clear": cell(1, None)}, 0.5),
    ]
    rows = outcome.by_choice(SPACE, tried)
    region = {row["choice"]: row for row in rows if row["quantity"] == "region"}
    assert (region["full-frame"]["tried"], region["full-frame"]["passed"]) == (1, [1, 1, 1, 1])
    assert (region["horizon-corridor"]["tried"], region["horizon-corridor"]["passed"]) == (1, [0, 0, 0, 0])
    assert region["below-horizon"]["best_score"] is None
    push = [row for row in rows if row["quantity"] == "push"]
    assert [row["tried"] for row in push] == [1, 0, 0, 1]


def test_the_optimiser_proposes_the_same_again() -> None:
    pytest.importorskip("optuna")
    proposals = []
    for _ in range(2):
        optimiser = search.Tpe(SPACE, 7)
        first = optimiser.ask(3)
        optimiser.tell([1.0, 0.0, 2.0])
        proposals.append([*first, *optimiser.ask(2)])
    assert proposals[0] == proposals[1]
    assert proposals[0] != search.Tpe(SPACE, 8).ask(3)
    for reading in proposals[0]:
        assert reading.keys() == FIRST.keys()


def test_known_readings_are_tried_first() -> None:
    pytest.importorskip("optuna")
    known = space.known()
    assert known
    assert search.Tpe(SPACE, 0, known).ask(len(known) + 1)[: len(known)] == [*known]


def test_the_command_lists_the_space(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["readings", "--list"]) == 0
    told = capsys.readouterr().out
    assert all(one.name in told for one in SPACE)


def test_an_existing_folder_is_not_used_for_a_new_search(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["readings", "--out", str(tmp_path)]) == 2
    assert "expected a new folder, or --resume" in capsys.readouterr().err
