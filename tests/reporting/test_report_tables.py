"""The report's tables, from hand-written summaries and records."""

from typing import Any

import pytest

from vpf_sim.evaluation.analysis.rows import Cell, Comparison, Row, read_summary
from vpf_sim.evaluation.analysis.statistics import Difference, Interval
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.reporting import endings, tables
from vpf_sim.reporting.main_table import Order

ORDER = Order(("town04",), ("clear", "rain"), ("vpf", "pid"))


def shares(first: float) -> dict[str, float]:
    return {"range": first, "span": first - 0.1, "tolerance": first - 0.2, "mae": 0.1}


def row(driver: str = "vpf", weather: str = "clear", successes: int = 2, **more: Any) -> Row:
    """A summary's row of an episode pair; where none succeeded its scores are those of the others."""
    signals = {"throttle": shares(0.9), "steering": shares(0.8)}
    parts = {"clear_of_obstacles": signals, "passing": {"throttle": shares(0.7), "steering": shares(0.6)}}
    scores = {
        "accuracy": {"shadow": {**signals, **parts}, "paired": {"throttle": shares(0.5), "steering": shares(0.4)}},
        "path_mse_parts_m2": {"clear_of_obstacles": 0.01, "passing": 1.5},
        "perception": {"foe_median_error_px": {"distance": 1.5}, "foe_share": 1.0, "objects": {"recall": 0.75}},
    }
    cell = {"scenario": "town04", "weather": weather, "driver": driver, "successes": successes, "episodes": 2}
    stored = {**cell, "statuses": {}, **(scores if successes else {"unsuccessful": scores}), **more}
    return read_summary({"rows": [stored]}, "a summary").rows[0]


def words(table: tables.Table | None) -> list[list[str]]:
    assert table is not None
    assert all(len(line) == len(table.header) for line in table.rows)
    return [[cell if isinstance(cell, str) else cell.text for cell in line] for line in table.rows]


def test_accuracy_is_shown_by_definition_and_protocol() -> None:
    found = tables.by_definition([row(), row("pid"), row(weather="rain", successes=0)], ORDER, "steering")
    assert words(found) == [["town04", "clear", "vpf", "80.0", "70.0", "60.0", "40.0", "30.0", "20.0"]]
    assert tables.by_definition([row("pid")], ORDER, "steering") is None


def test_the_papers_accuracy_is_shown_beside_ours() -> None:
    paper = {"throttle": 0.8234, "steering": 0.7214, "path_mse_m2": 0.42}
    found = tables.by_definition([row(paper=paper)], ORDER, "throttle")
    assert found is not None
    assert found.header[3] == "the paper, undefined"
    assert words(found)[0][3:5] == ["82.34", "90.0"]


def test_scores_are_shown_by_part_of_the_route_with_obstacles() -> None:
    empty = row(weather="rain", path_mse_parts_m2={"clear_of_obstacles": 0.01, "passing": None})
    found = tables.by_part([empty, row()], ORDER)
    assert words(found) == [["town04", "clear", "vpf", "0.010", "1.500", "90.0", "70.0", "80.0", "60.0"]]
    assert tables.by_part([empty], ORDER) is None


def test_perception_has_a_table_of_the_frame_and_one_of_objects() -> None:
    blind = row("pid", perception={"foe_median_error_px": None, "foe_share": 0.0, "objects": None})
    seen = tables.perception([row(), blind], ORDER, tables.PERCEPTION)
    assert words(seen) == [["town04", "clear", "vpf", "1.50", "100"]]
    assert words(tables.perception([row(), blind], ORDER, tables.OBJECTS)) == [["town04", "clear", "vpf", "75"]]
    assert tables.perception([blind], ORDER, tables.OBJECTS) is None


def test_of_drives_that_did_not_arrive_tables_show_perception_alone_in_brackets() -> None:
    lost = row(successes=0)
    assert words(tables.perception([lost], ORDER, tables.PERCEPTION)) == [["town04", "clear", "vpf", "(1.50)", "(100)"]]
    assert tables.by_definition([lost], ORDER, "throttle") is None
    assert tables.by_part([lost], ORDER) is None


def test_the_needed_seeds_are_listed() -> None:
    found = tables.seeds_needed([row(seeds_needed={"success_rate": 381, "path_mse_m2": None}), row("pid")], ORDER)
    assert words(found) == [["town04", "clear", "vpf", "2", "381", "–"]]
    assert found is not None
    assert found.header[-2:] == ("for success within 10 points", "for path MSE within 0.1 m² (successful seeds)")


@pytest.mark.parametrize(
    ("difference", "shown"),
    [(0.0, "0.000"), (-0.53, "−0.530"), (0.00012, "+0.0001"), (-4e-6, "−0.000004"), (1e-12, "0.000")],
)
def test_a_small_difference_is_not_rounded_to_zero(difference: float, shown: str) -> None:
    score = Difference(difference, Interval(difference, difference), 0.5, 3)
    one = Comparison("weather", Cell("town04", "rain", "vpf"), "clear", {"path_mse_m2": score})
    (line,) = words(tables.comparisons([one], "weather", ORDER))
    assert line[4] == shown


def failed(
    seed: int, status: str = "collision", driver: str = "vpf", completion: float = 0.5, hit: str | None = None
) -> Record:
    job = Job("town04", "clear", driver, seed)
    scores = {"route_completion": completion}
    return Record(id=job.id, **job._asdict(), status=status, steps=9, collided_with=hit, scores=scores)


def test_equal_failures_are_grouped() -> None:
    records = [
        failed(1, hit="car", completion=0.25),
        failed(2, hit="cone"),
        failed(3, hit="car"),
        failed(4, "error"),
        failed(5, "error"),
        failed(1, driver="pid"),
    ]
    found = endings.endings(records, {"town04.clear.vpf.4": "ValueError: a", "town04.clear.vpf.5": "ValueError: b"}.get)
    assert [(one.driver, one.status, one.collided_with, one.reason, one.seeds) for one in found] == [
        ("vpf", "collision", "car", "", (1, 3)),
        ("vpf", "collision", "cone", "", (2,)),
        ("vpf", "error", None, "ValueError: a", (4,)),
        ("vpf", "error", None, "ValueError: b", (5,)),
        ("pid", "collision", None, "", (1,)),
    ]
    assert [one.completion for one in found[:2]] == ["25.0 to 50.0", "50.0"]
    assert sum(len(one.seeds) for one in found) == len(records)


def test_consecutive_seeds_are_ranges() -> None:
    assert endings.ranges([3, 5, 6, 8, 9, 10, 12]) == "3, 5, 6, 8–10, 12"
    assert endings.ranges(list(range(1000, 1030))) == "1000–1029"


def test_the_success_map_has_each_planned_seed_in_blocks_of_ten() -> None:
    jobs = [Job("town04", "clear", "vpf", seed) for seed in range(995, 1018)]
    records = {job.id: failed(job.seed, "success") for job in jobs[:20]}
    (shown,) = endings.rows(jobs, records, ORDER)
    assert [(block[0][0], len(block)) for block in shown.blocks] == [(995, 10), (1005, 10), (1015, 3)]
    assert [status for _, status, _ in shown.marks] == 20 * ["success"] + 3 * ["missing"]
    assert endings.signs(jobs, records) == [("success", "✓", 20), ("missing", "·", 3)]
