"""The leaderboard's page: ranks, what is refused, and what a verification says."""

import json
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from subprocess import CompletedProcess
from typing import Any

import pytest
import stored
from run_script import run_script

from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.sweeps.plan import Plan

SCRIPT = Path(__file__).parents[2] / "scripts" / "leaderboard.py"
SCENARIOS, WEATHERS = ("crossing", "cut-in"), ("clear", "rain")
PLAN = 'scenario = ["crossing", "cut-in"]\nweather = ["clear", "rain"]\nseeds = "7:9"\n'
GOOD, LOST = {"driving_score_2_1": 1.0}, {"status": "collision", "driving_score_2_1": 0.25}


def enter(folder: Path, driver: str, lost: Mapping[Job, Mapping[str, Any]], left_out: tuple[Job, ...] = ()) -> Path:
    """A run of the plan whose drives arrive, but for those that are lost."""
    plan = Plan(SCENARIOS, WEATHERS, (driver,), "7:9")
    records = [stored.record(job, **GOOD | lost.get(job, {})) for job in plan.jobs() if job not in left_out]
    run = stored.store(folder / driver, plan, records)
    manifest = json.loads((run / "manifest.json").read_text())
    (run / "manifest.json").write_text(json.dumps(manifest | {**plan.hashes(), "privileged": {driver: "none"}}))
    return run


def made(folder: Path, *runs: Path) -> "CompletedProcess[str]":
    (folder / "plan.toml").write_text(PLAN)
    options = ["--plan", str(folder / "plan.toml"), "--out", str(folder / "page.md"), "--no-sizes"]
    return run_script(SCRIPT, *runs, *options)


def rows_of(folder: Path, *runs: Path) -> list[list[str]]:
    """The cells of the first table's rows."""
    done = made(folder, *runs)
    assert done.returncode == 0, done.stderr
    text = (folder / "page.md").read_text()
    table = text.partition("| rank |")[2].partition("\n\n")[0]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]


def test_drivers_are_ranked_by_their_mean_driving_score(tmp_path: Path) -> None:
    """Two of eight drives are lost at a quarter: 0.81, against 1 and 0.91."""
    lost = [Job("crossing", "rain", "idm", seed) for seed in (7, 8)]
    runs = [
        enter(tmp_path, "idm", dict.fromkeys(lost, LOST)),
        enter(tmp_path, "vpf", {}),
        enter(tmp_path, "pid", {Job("cut-in", "clear", "pid", 8): LOST}),
    ]
    rows = rows_of(tmp_path, *runs)
    assert [row[:2] for row in rows] == [["1", "`vpf`"], ["2", "`pid`"], ["3", "`idm`"]]
    assert [row[3].partition("<br>")[0] for row in rows] == ["1.00", "0.91", "0.81"]
    assert rows[2][5].startswith("6 of 8<br>")
    text = (tmp_path / "page.md").read_text()
    assert "| crossing | 4 of 4<br>(40 to 100 %) | 4 of 4<br>(40 to 100 %) | 2 of 4<br>" in text
    assert "| `idm` | 4 of 4<br>(40 to 100 %) | 2 of 4<br>(7 to 93 %) | −50<br>" in text


def test_an_error_counts_as_nothing_driven(tmp_path: Path) -> None:
    failure = {"status": "error", "driving_score_2_1": None}
    failed = dict.fromkeys(Plan(SCENARIOS, WEATHERS, ("pid",), "7:9").jobs(), failure)
    assert rows_of(tmp_path, enter(tmp_path, "pid", failed))[0][3] == "0.00"


def test_a_run_that_leaves_out_a_failure_is_refused(tmp_path: Path) -> None:
    left_out = Job("crossing", "rain", "vpf", 8)
    done = made(tmp_path, enter(tmp_path, "vpf", {}, left_out=(left_out,)))
    assert done.returncode == 1
    assert done.stderr.strip().endswith(
        f"expected a record of each of the 8 drives of the plan, got 7 of vpf, without {left_out.id}"
    )
    assert not (tmp_path / "page.md").exists()


def test_a_run_in_an_easier_scenario_of_the_same_name_is_refused(tmp_path: Path) -> None:
    run = enter(tmp_path, "vpf", {})
    manifest = json.loads((run / "manifest.json").read_text())
    manifest["scenarios"]["cut-in"] = 64 * "0"
    (run / "manifest.json").write_text(json.dumps(manifest))
    done = made(tmp_path, run)
    assert done.returncode == 1
    assert "scenarios: cut-in: expected that of this version, got another form of it" in done.stderr


def test_of_a_driver_that_is_entered_twice_the_later_run_counts(tmp_path: Path) -> None:
    failure = {"status": "stuck", "driving_score_2_1": 0.5}
    failed = dict.fromkeys(Plan(SCENARIOS, WEATHERS, ("vpf",), "7:9").jobs(), failure)
    once, again = enter(tmp_path / "once", "vpf", failed), enter(tmp_path / "again", "vpf", {})
    for runs, score in (((once, again), "1.00"), ((again, once), "0.50")):
        (row,) = rows_of(tmp_path, *runs)
        assert row[3].startswith(score), row


def test_a_run_that_was_begun_earlier_does_not_come_back(tmp_path: Path) -> None:
    """Whatever the order in which the folders are named."""
    failure = {"status": "stuck", "driving_score_2_1": 0.5}
    failed = dict.fromkeys(Plan(SCENARIOS, WEATHERS, ("vpf",), "7:9").jobs(), failure)
    old, new = enter(tmp_path / "old", "vpf", failed), enter(tmp_path / "new", "vpf", {})
    for run, begun in ((old, "2026-01-01T00:00:00+00:00"), (new, "2026-02-01T00:00:00+00:00")):
        file = run / "manifest.json"
        file.write_text(json.dumps(json.loads(file.read_text()) | {"begun": begun}))
    for runs in ((old, new), (new, old)):
        (row,) = rows_of(tmp_path, *runs)
        assert row[3].startswith("1.00"), row


@pytest.mark.parametrize(
    ("said", "shown"), [(True, "yes, 1 of 8 driven again"), (False, "**no, it differs**"), (None, "no")]
)
def test_a_verification_counts_while_the_records_are_those_that_it_is_of(
    said: bool | None, shown: str, tmp_path: Path
) -> None:
    run = enter(tmp_path, "vpf", {})
    records = run / "episodes.jsonl"
    if said is not None:
        answer = {
            "ok": said,
            "planned": 8,
            "driven": ["one"],
            "records_sha256": sha256(records.read_bytes()).hexdigest(),
        }
        (run / "verification.json").write_text(json.dumps(answer))
    assert rows_of(tmp_path, run)[0][6] == shown
    records.write_text(records.read_text().replace("0.4", "0.3"))
    assert rows_of(tmp_path, run)[0][6].startswith("no")


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        ("[", "expected what `vpf-sim verify --json` printed, got something else"),
        ("[]", "expected what `vpf-sim verify --json` printed, got something else"),
        ("{}", "key 'ok' is missing"),
        ('{"ok": "yes"}', "ok: expected"),
    ],
)
def test_a_broken_verification_is_refused_in_one_line(content: str, fault: str, tmp_path: Path) -> None:
    run = enter(tmp_path, "vpf", {})
    (run / "verification.json").write_text(content)
    done = made(tmp_path, run)
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1
    assert f"verification.json: {fault}" in done.stderr
