"""Abilities and classes of failures on the pages of a run."""

import re
from pathlib import Path

import pytest
import stored

from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.reporting import page, results_page
from vpf_sim.reporting.run_data import open_run

PLAN = Plan(("crossing", "cut-in", "blocked"), ("clear", "rain"), ("vpf", "expert"), "35:38")
LOST = {
    ("crossing", "rain", "vpf", 35): "missed",
    ("crossing", "rain", "vpf", 36): "late",
    ("cut-in", "clear", "vpf", 37): None,
}


@pytest.fixture
def run(tmp_path: Path) -> Path:
    records = [
        stored.record(job, status="collision", collided_with="deer", failure=LOST[tuple(job)])  # type: ignore[index]
        if tuple(job) in LOST
        else stored.record(job)
        for job in PLAN.jobs()
    ]
    return stored.store(tmp_path / "run", PLAN, records)


def lines_of(text: str, *names: str) -> list[str]:
    """The cells behind the names of a Markdown row."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()]
    return next(row for row in rows if row[: len(names)] == [*names])[len(names) :]


def test_results_have_a_row_for_each_ability(run: Path) -> None:
    text = results_page.make([run])
    clear, rain, together, change = lines_of(text, "vpf", "crossing")
    assert [cell.partition("<br>")[0] for cell in (clear, rain, together, change)] == [
        "3 of 3",
        "1 of 3",
        "4 of 6",
        "−67",
    ]
    assert change.endswith("n 3")
    assert lines_of(text, "vpf", "all drives")[2].startswith("15 of 18<br>")
    assert lines_of(text, "expert", "cut-in")[2].startswith("6 of 6<br>")
    assert "worn paint" not in text


def test_results_count_failures_by_class(run: Path) -> None:
    text = results_page.make([run])
    header = lines_of(text, "driver", "failures")
    counts = dict(zip(header, lines_of(text, "vpf", "3"), strict=True))
    assert {name for name, count in counts.items() if count == "1"} == {
        "perception: missed",
        "perception: late",
        "not known",
    }
    assert sum(count == "1" for count in counts.values()) == 3


def test_the_page_says_why_each_episode_failed(run: Path) -> None:
    html = page.make(open_run(run), 0, lambda _: None)
    assert "Abilities" in html
    failures = html[html.index('id="failures"') :]
    for seed, why in ((35, "perception: missed"), (36, "perception: late"), (37, "–")):
        row = next(line for line in failures.splitlines() if re.search(rf"<td>{seed}</td>", line))
        assert f"<td>{why}</td>" in row


def test_a_run_without_abilities_and_failures_has_neither_table(tmp_path: Path) -> None:
    plan = Plan(("blocked",), ("clear",), ("vpf",), "35:37")
    text = results_page.make([stored.store(tmp_path / "run", plan, map(stored.record, plan.jobs()))])
    assert "Abilities" not in text
    assert "Why episodes failed" not in text
