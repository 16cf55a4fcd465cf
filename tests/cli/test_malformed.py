"""Malformed inputs on the command line: exit code 2 and one clear line, or a line a fault; no traceback, no hang.

What the readers make of any change to an input is in test_properties.
"""

from pathlib import Path
from random import Random

import pytest
from malformed import MUTATIONS, RULES, SCENARIO, SWEEP, WEATHER, spoil_folder
from stored import record, store
from systems import at_most

from vpf_sim import cli
from vpf_sim.evaluation.sweeps.plan import Plan

TEXTS = {"scenario": SCENARIO, "weather": WEATHER, "sweep": SWEEP, "rules": RULES}
LONGEST_S = 30
LONGEST_LINE = 1000


def commands(kind: str, path: Path, run: Path) -> list[list[str]]:
    """What reads an input of this kind."""
    return {
        "scenario": [
            ["scenarios", "validate", str(path)],
            ["sweep", "--scenario", str(path), "--out", str(run / "new")],
        ],
        "weather": [["weathers", "validate", str(path)], ["drive", "straight", "--weather", str(path)]],
        "sweep": [["sweep", str(path), "--out", str(run / "new")]],
        "rules": [["check", str(run), "--rules", str(path)]],
        "folder": [
            ["sweep", "--out", str(path), "--resume"],
            ["sweep", "--out", str(path)],
            ["check", str(path), "--rules", str(run / "rules.toml")],
            ["score", str(path)],
            ["report", str(path)],
            ["video", str(path), "--id", "a"],
        ],
    }[kind]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A good run folder."""
    plan = Plan(("straight",), ("clear", "rain"), ("vpf",), "0:3")
    path = store(tmp_path_factory.mktemp("good") / "run", plan, [record(job) for job in plan.jobs()])
    (path / "rules.toml").write_text(RULES)
    return path


def assert_refused(arguments: list[str], path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with at_most(LONGEST_S):
        code = cli.run(arguments)
    said = capsys.readouterr()
    shown = f"{arguments}\n{path.read_bytes()[:2000] if path.is_file() else path}\n{said.err[:3000]}"
    assert code == 2, shown
    assert said.out == "", shown
    lines = said.err.splitlines()
    assert 1 <= len(lines) <= 12, shown
    assert all(line.startswith("vpf-sim: ") and len(line) < LONGEST_LINE for line in lines), shown
    assert any(str(path) in line for line in lines), shown


@pytest.mark.parametrize("kind", TEXTS)
@pytest.mark.parametrize("seed", range(len(MUTATIONS)))
def test_a_malformed_file_is_refused(
    kind: str, seed: int, run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / f"{kind}.toml"
    path.write_bytes(MUTATIONS[seed](TEXTS[kind], Random(seed)))
    for arguments in commands(kind, path, run):
        assert_refused(arguments, path, capsys)
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name], "nothing is left behind"


@pytest.mark.parametrize("seed", range(20))
def test_an_incomplete_or_foreign_run_folder_is_refused(
    seed: int, run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "run"
    spoil_folder(path, Random(seed))
    before = {entry.name: entry.read_bytes() for entry in path.iterdir() if entry.is_file()}
    for arguments in commands("folder", path, run):
        assert_refused(arguments, path, capsys)
    after = {entry.name: entry.read_bytes() for entry in path.iterdir() if entry.is_file()}
    assert {name: after[name] for name in before} == before, "nothing of the user's is touched"


@pytest.mark.parametrize("kind", TEXTS)
def test_the_mutated_inputs_are_valid_before_mutation(
    kind: str, run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"{kind}.toml"
    path.write_text(TEXTS[kind])
    if kind in ("scenario", "weather"):
        assert cli.run([f"{kind}s", "validate", str(path)]) == 0
    elif kind == "rules":
        assert cli.run(["check", str(run), "--rules", str(path)]) == 0
    else:
        from vpf_sim.evaluation.sweeps.plan import make_plan, read_plan

        make_plan(read_plan(path), str(path)).check()
    assert capsys.readouterr().err == ""
