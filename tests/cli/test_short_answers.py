"""What commands print answers their question: no figure that misleads, no empty row, no folder in a column."""

from pathlib import Path

import pytest
from recorded_layouts import general
from short_scenario import SHORT

import vpf_sim
from vpf_sim import cli
from vpf_sim.cli.sweep_tables import print_rows
from vpf_sim.evaluation.analysis.rows import Cell
from vpf_sim.evaluation.gate.checks import Check, listed
from vpf_sim.reporting.run_data import open_run

MOST_LINES = 20


def drive(capsys: pytest.CaptureFixture[str], scenario: Path, driver: str) -> str:
    cli.run(["drive", str(scenario), "--driver", driver])
    said = capsys.readouterr().out
    assert len(said.splitlines()) <= MOST_LINES
    return said


def test_a_drive_of_the_pid_is_not_compared_with_the_pid(short: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "PID" not in drive(capsys, short, "pid").partition("\n")[2]
    assert "like the PID" in drive(capsys, short, "stanley")


def test_a_drive_that_did_not_arrive_has_no_figures_of_its_path(
    short: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short.write_text(SHORT + '[[bodies]]\nkind = "barrier"\ns_m = 9.0\nlane = 2\n')
    said = drive(capsys, short, "pure-pursuit")
    assert "collision" in said
    assert "path MSE" not in said
    assert "like the PID" not in said
    assert "it did not arrive" in said


@pytest.mark.usefixtures("in_one_process")
def test_a_table_names_files_without_their_folders_and_shows_no_figures_of_lost_drives(
    short: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short.write_text(SHORT + '[[bodies]]\nkind = "barrier"\ns_m = 9.0\nlane = 2\n')
    (tmp_path / "damp.toml").write_text('base = "ClearNoon"\nwetness = 40.0\n')
    run = vpf_sim.sweep(short, driver=["pure-pursuit"], weather=tmp_path / "damp.toml", seeds="0:1", progress=False)
    (row,) = run.summary()["rows"]
    assert row["successes"] == 0
    assert row["unsuccessful"]["path_mse_m2"] is not None
    print_rows(open_run(run.path).summary().rows)
    said = capsys.readouterr().out
    assert str(tmp_path) not in said
    cells = said.splitlines()[2].split()
    assert cells[:6] == ["short", "damp", "pure-pursuit", "[route]", "0/1", "-"]
    assert "Driving score:" in said


def test_a_replay_prints_a_screen_and_names_the_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    general(tmp_path / "cam")
    given = ["replay", str(tmp_path / "cam"), "--driver", "neutral", "--no-video", "--out", str(tmp_path / "run")]
    assert cli.run(given) == 0
    said = capsys.readouterr().out
    assert "no recording" not in said
    assert len(said.splitlines()) <= MOST_LINES
    assert "all tables, plots and videos: " in said


def test_lost_drives_come_first_and_what_follows_from_them_is_not_listed() -> None:
    lost, good = Cell("gate-course", "clear", "mine"), Cell("gate-course", "rain", "mine")
    checks = [
        Check(good, "path_mse_m2_at_most 3", "1 m2", "passed"),
        Check(lost, "path_mse_m2_at_most 3", "none arrived", "failed", (1,), is_of_loss=True),
        Check(lost, "recall_at_least 0.5", "no perception shown", "skipped"),
        Check(lost, "clearance_m_at_least 0.2", "0.1 m", "failed", (1,)),
        Check(lost, "success_rate_at_least 1", "0", "failed", (1, 2)),
    ]
    assert listed(checks) == [checks[4], checks[3], checks[0]]


@pytest.mark.parametrize("expected", ["path_mse_m2_at_most 3", "steering_rate_radps_at_most 1"])
def test_without_a_rule_on_endings_a_cell_without_success_is_listed(expected: str) -> None:
    checks = [Check(Cell("town04", "clear", "mine"), expected, "none arrived", "failed", (1,), is_of_loss=True)]
    assert listed(checks) == checks
