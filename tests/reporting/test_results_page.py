"""The results page: the cells of several runs, their commands and sources."""

import json
import shlex
import subprocess
from pathlib import Path

import pytest
import stored

from vpf_sim import cli
from vpf_sim.evaluation.analysis.statistics import share_interval
from vpf_sim.evaluation.sweeps.fingerprint import source
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.reporting.results_page import make

EVALUATED = Plan(("town04",), ("clear", "rain"), ("vpf", "pid"), "20000:20003")
DEVELOPED = Plan(("random",), ("clear",), ("vpf",), "7:9")


@pytest.fixture
def runs(tmp_path: Path) -> list[Path]:
    """Two runs; the PID of the first collides in each episode."""
    records = [
        stored.record(job, status="collision", collisions=1, at_fault_collisions=1)
        if job.driver == "pid"
        else stored.record(job)
        for job in EVALUATED.jobs()
    ]
    first = stored.store(tmp_path / "first", EVALUATED, records)
    second = stored.store(tmp_path / "second", DEVELOPED, [stored.record(DEVELOPED.jobs()[0])])
    return [first, second]


def cells(page: str, *names: str) -> list[str]:
    """The cells of the first row that begins with the names."""
    return next(row for row in map(_split, page.splitlines()) if row[: len(names)] == list(names))[len(names) :]


def _split(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_success_has_its_interval_and_collisions_are_counted(runs: list[Path]) -> None:
    page = make(runs)
    low, high = (100.0 * end for end in share_interval(3, 3))
    assert cells(page, "town04", "rain", "vpf", "20000:20003")[:2] == [
        f"100 (3 of 3)<br>{low:.0f} to {high:.0f}",
        "0 (0)",
    ]
    success, collisions, path_mse, *_ = cells(page, "town04", "clear", "pid, knows the route", "20000:20003")
    assert success.startswith("0 (0 of 3)<br>")
    assert success.endswith("3 collision")
    assert collisions == "3 (3)"
    assert path_mse == "–", "a drive that did not arrive has no figure of its path"
    assert "0.400" in cells(page, "town04", "clear", "vpf", "20000:20003")[2]


def test_an_unfinished_run_says_what_is_missing(runs: list[Path]) -> None:
    page = make(runs)
    assert "1 not driven" in cells(page, "random", "clear", "vpf", "7:9")[0]
    assert cells(page, "7:9")[:2] == ["development", "1 of 2"]
    assert cells(page, "20000:20003")[:2] == ["evaluation", "12 of 12"]


def test_the_commands_drive_the_plans(runs: list[Path]) -> None:
    lines = [line for line in make(runs).splitlines() if line.startswith("vpf-sim ")]
    assert [shlex.split(line) for line in lines] == [
        shlex.split(
            "vpf-sim sweep --scenario town04 --weather clear --weather rain --driver vpf --driver pid "
            "--seeds 20000:20003"
        ),
        shlex.split("vpf-sim sweep --scenario random --weather clear --driver vpf --seeds 7:9"),
    ]


def test_no_path_of_a_run_is_on_the_page(runs: list[Path]) -> None:
    assert str(runs[0].parent) not in make(runs)


def test_the_command_writes_the_page(runs: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "results.md"
    assert cli.run(["results", *map(str, runs), "--out", str(out)]) == 0
    assert out.read_text() == make(runs)
    assert cli.run(["results", str(tmp_path / "none")]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_the_commit_is_given_only_for_a_run_of_these_sources(runs: list[Path]) -> None:
    requested = ["git", "-C", str(Path(__file__).parent), "rev-parse", "--short", "HEAD"]
    done = subprocess.run(requested, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip("no git checkout")
    for path, sources in zip(runs, (source(), "0" * 64), strict=True):
        manifest = json.loads((path / "manifest.json").read_text())
        manifest["fingerprint"] = {"source": sources, "vpf_sim": "0.1.0"}
        (path / "manifest.json").write_text(json.dumps(manifest))
    page = make(runs)
    assert cells(page, "20000:20003")[-1] == done.stdout.strip()
    assert cells(page, "7:9")[-1] == "–"
