"""The command of the gate: what it prints, its JSON and its JUnit file."""

import json
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import pytest
from gated_runs import Change, lost, run, spread

from vpf_sim import cli
from vpf_sim.evaluation.gate.checks import Check
from vpf_sim.evaluation.gate.run_cells import Cell
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.sweeps.plan import Plan


def test_the_command_prints_failures_and_how_to_repeat_them(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder, rules = run(tmp_path / "run", lost), tmp_path / "rules.toml"
    rules.write_text('[[rules]]\nscenario = "town04"\nsuccess_rate_at_least = 0.9\ncollisions_at_most = 3')
    assert cli.run(["check", str(folder), "--rules", str(rules)]) == 1
    said = capsys.readouterr().out
    assert re.search(r"FAIL +town04 +clear +vpf +success_rate_at_least 0.9 +0.7 \(10 episodes\), 1 without a", said)
    again = "for seed in 3 5 8; do vpf-sim drive town04 --weather clear --driver vpf --seed $seed; done"
    assert f"again, the worst seeds first:\n  {again}\n" in said
    assert said.endswith("\n1 passed, 1 failed, 0 skipped\n")
    rules.write_text('[[rules]]\nscenario = "town04"\nsuccess_rate_at_least = 0.9\n' * 2)
    assert cli.run(["check", str(folder), "--rules", str(rules)]) == 1
    assert capsys.readouterr().out.count("vpf-sim drive town04") == 1, "once for all rules that fail"


def test_json_has_every_check_and_no_other_output(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder, rules = run(tmp_path / "run", lambda _: {}), tmp_path / "rules.toml"
    rules.write_text("[[rules]]\nsuccess_rate_at_least = 1\ncollisions_at_most = 0")
    assert cli.run(["check", str(folder), "--rules", str(rules), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["ok"] is True
    assert [(row["scenario"], row["outcome"], row["seeds"], row["rerun"]) for row in answer["checks"]] == [
        (scenario, "passed", [], None) for scenario in ("straight", "straight", "town04", "town04")
    ]


def test_names_are_quoted_for_the_shell() -> None:
    cell = Cell("my road.toml", "clear", "my:Driver; rm -rf /")
    command = Check(cell, "", "", "failed", (3,)).rerun
    assert command == "vpf-sim drive 'my road.toml' --weather clear --driver 'my:Driver; rm -rf /' --seed 3"


# Of Jenkins' junit-10.xsd: elements, what may stand in them, which attributes must and which may be there.
SCHEMA: dict[str, tuple[set[str], set[str], set[str]]] = {
    "testsuites": ({"testsuite"}, set(), {"name", "tests", "failures", "errors", "time"}),
    "testsuite": ({"testcase"}, {"name", "tests", "failures", "errors"}, {"skipped", "time", "timestamp", "file"}),
    "testcase": ({"failure", "skipped"}, {"name"}, {"classname", "time", "group"}),
    "failure": (set(), set(), {"message", "type"}),
    "skipped": (set(), set(), {"message", "type"}),
}


def valid(element: Xml.Element) -> bool:
    inside, needed, allowed = SCHEMA[element.tag]
    fits = needed <= set(element.keys()) <= needed | allowed and all(child.tag in inside for child in element)
    return fits and all(valid(child) for child in element)


def test_junit(tmp_path: Path) -> None:
    odd = '\x00\x1b[31m<&>" ]]> é \ufffe'

    def change(job: Job) -> dict[str, Any] | None:
        return {"min_clearance_m": None} if job.scenario == "straight" else spread(job)

    folder, rules, out = run(tmp_path / "run", change), tmp_path / "rules.toml", tmp_path / "out.xml"
    rules.write_text("[[rules]]\nsuccess_rate_at_least = 0.9\nclearance_m_at_least = 0.1")
    assert cli.run(["check", str(folder), "--rules", str(rules), "--junit", str(out)]) == 1
    root = Xml.fromstring(out.read_bytes())
    assert valid(root)
    cases = root.findall("testsuite/testcase")
    assert {(case.get("classname"), case.get("name"), case[0].tag if len(case) else "") for case in cases} == {
        ("straight.clear.vpf", "success_rate_at_least 0.9", ""),
        ("straight.clear.vpf", "clearance_m_at_least 0.1", "skipped"),
        ("town04.clear.vpf", "success_rate_at_least 0.9", "failure"),
        ("town04.clear.vpf", "clearance_m_at_least 0.1", ""),
    }
    for element in (root, root[0]):
        assert [element.get(key) for key in ("tests", "failures", "errors")] == ["4", "1", "0"]
    assert root[0].get("skipped") == "1"
    (failure,) = root.iter("failure")
    assert "for seed in 3 5 8; do vpf-sim drive town04" in str(failure.text)

    from vpf_sim.reporting.check_files import write_junit

    write_junit([Check(Cell(odd, odd, odd), odd, odd, "failed", (1,))], out)
    (failure,) = Xml.fromstring(out.read_bytes()).iter("failure")
    assert '?[31m<&>" ]]> é ?' in str(failure.text)


def test_markdown_has_the_verdict_the_failures_and_their_commands(tmp_path: Path) -> None:
    folder, rules, out = run(tmp_path / "run", lost), tmp_path / "rules.toml", tmp_path / "out.md"
    rules.write_text('[[rules]]\nscenario = "town04"\nsuccess_rate_at_least = 0.9\ncollisions_at_most = 3')
    assert cli.run(["check", str(folder), "--rules", str(rules), "--markdown", str(out)]) == 1
    lines = out.read_text("utf-8").splitlines()
    assert lines[0] == "## ❌ Gate: 1 of 2 checks failed"
    failed, everything = (lines.index(line) for line in ("```sh", "</details>"))
    assert lines[failed + 1].startswith("for seed in 3 5 8; do vpf-sim drive town04 --weather clear --driver vpf")
    table = [line for line in lines[failed:everything] if line.startswith("| ")]
    assert [line.split(" | ")[0] for line in table[2:]] == ["| ❌ fail", "| ✅ ok"]

    rules.write_text("[[rules]]\ncollisions_at_most = 9")
    assert cli.run(["check", str(folder), "--rules", str(rules), "--markdown", str(out)]) == 0
    assert out.read_text("utf-8").startswith("## ✅ Gate: all checks passed\n")


def one_not_driven(job: Job) -> dict[str, Any] | None:
    return None if job.seed == 3 else {}


@pytest.mark.parametrize(
    ("change", "shown", "hidden"),
    [
        (
            lambda _: {"status": "collision", "collisions": 1},
            ["success_rate", "collisions"],
            ["clearance", "path_mse", "recall"],
        ),
        (one_not_driven, ["success_rate", "collisions"], ["clearance", "path_mse", "recall"]),
        (lambda _: {"path_mse_m2": 9.0}, ["path_mse", "success_rate", "clearance"], ["recall"]),
    ],
)
def test_terminal_and_markdown_list_the_same_lost_drives_first(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, change: Change, shown: list[str], hidden: list[str]
) -> None:
    folder, rules, out = run(tmp_path / "run", change), tmp_path / "rules.toml", tmp_path / "out.md"
    bounds = "recall_at_least = 0.5\nclearance_m_at_least = 0.1\npath_mse_m2_at_most = 1\nsuccess_rate_at_least = 1\n"
    rules.write_text(f'[[rules]]\nscenario = "town04"\n{bounds}collisions_at_most = 0')
    assert cli.run(["check", str(folder), "--rules", str(rules), "--markdown", str(out)]) == 1
    printed = capsys.readouterr().out.partition("\nnot listed: ")
    written = out.read_text("utf-8").partition("All checks")[2].replace("\\_", "_").partition("Not listed: ")
    assert printed[2].startswith(f"{len(hidden)} that do not apply")
    assert written[2].startswith(f"{len(hidden)} that do not apply")
    for table in (printed[0], written[0]):
        places = [table.index(f"{name}_") if name != "collisions" else table.index(name) for name in shown]
        assert places == sorted(places), "what fails first"
        assert not any(name in table for name in hidden)


def test_a_name_has_no_meaning_in_markdown(tmp_path: Path) -> None:
    from vpf_sim.reporting.check_files import write_markdown

    name = "a|b\n*c* <img>"
    write_markdown([Check(Cell(name, "clear", "vpf"), "x", "y", "passed")], tmp_path / "out.md")
    assert "| ✅ ok | a\\|b?\\*c\\* &lt;img> | clear | vpf | x | y |" in (tmp_path / "out.md").read_text("utf-8")


def test_the_default_rules_are_for_the_scenarios_of_the_gate(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    gates = Plan(("gate-course", "gate-traffic"), ("clear", "rain"), ("pid",), "0:2")
    good = run(tmp_path / "good", lambda _: {"path_mse_m2": 0.1, "min_clearance_m": 1.0}, gates)
    assert cli.run(["check", str(good), "--json"]) == 0
    assert {row["outcome"] for row in json.loads(capsys.readouterr().out)["checks"]} <= {"passed", "skipped"}
    assert cli.run(["check", str(run(tmp_path / "other", lambda _: {}))]) == 2
    assert "without --rules, expected the scenarios gate-course and gate-traffic, got" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("scenario", "weather", "change", "rule"),
    [
        ("gate-course", "rain", {"min_clearance_m": 0.3}, None),
        ("gate-course", "clear", {"min_clearance_m": 0.3}, "clearance_m_at_least 0.4"),
        ("gate-traffic", "rain", {"min_clearance_m": 0.1}, "clearance_m_at_least 0.2"),
        ("gate-traffic", "clear", {"perception": {"objects": {"precision": 0.2}}}, "precision_at_least 0.25"),
        ("gate-course", "rain", {"perception": {"objects": {"precision": 0.5}}}, "precision_at_least 0.6"),
        ("gate-course", "clear", {"status": "collision", "collisions": 1}, "success_rate_at_least 1"),
    ],
)
def test_the_default_rules_find_a_regression_in_one_cell(
    scenario: str,
    weather: str,
    change: dict[str, Any],
    rule: str | None,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    """Each limit is checked once in a cell, also where a tighter one is for its weather."""
    gates = Plan(("gate-course", "gate-traffic"), ("clear", "rain"), ("vpf",), "0:1")
    good = {"perception": {"objects": {"precision": 1.0}}, "min_clearance_m": 1.0}

    def driven(job: Job) -> dict[str, Any]:
        return {**good, **(change if job[:2] == (scenario, weather) else {})}

    assert cli.run(["check", str(run(tmp_path / "run", driven, gates)), "--json"]) == int(rule is not None)
    checks = json.loads(capsys.readouterr().out)["checks"]
    failed = [one for one in checks if one["outcome"] == "failed"]
    assert {(one["scenario"], one["weather"]) for one in failed} <= {(scenario, weather)}
    assert [one["expected"] for one in failed][:1] == ([] if rule is None else [rule])
    names = [(one["scenario"], one["weather"], one["expected"].split()[0]) for one in checks]
    assert len(names) == len(set(names))


def test_the_default_rules_need_no_clear_weather(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    gates = Plan(("gate-course", "gate-traffic"), ("rain",), ("pid",), "0:1")
    assert cli.run(["check", str(run(tmp_path / "run", lambda _: {}, gates)), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["ok"]
