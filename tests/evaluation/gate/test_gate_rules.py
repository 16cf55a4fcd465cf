"""The rules of the gate: faults reported by key, and the guide with all keys."""

import re
from pathlib import Path

import pytest
from gated_runs import run

from vpf_sim import cli
from vpf_sim.evaluation.gate.rules import BOUNDS, Rule, read_rules

RULES = [
    ("", "rules: expected a value, got none"),
    ("[[rules]]", "rules[0]: expected a bound, such as success_rate_at_least, or no_worse_than, got none"),
    ("[[rule]]", "rule: unknown key, did you mean 'rules'?"),
    ("rules = 3", "rules: expected a list, got 3"),
    ("rules = [1]", "rules[0]: expected a table, got 1"),
    (
        "[[rules]]\nsucess_rate_at_least = 1",
        "rules[0].sucess_rate_at_least: unknown key, did you mean 'success_rate_at_least'?",
    ),
    (
        "[[rules]]\nsuccess_rate_at_least = 95",
        "rules[0].success_rate_at_least: expected <= 1, got 95",
    ),
    ("[[rules]]\ncollisions_at_most = 0.5", "rules[0].collisions_at_most: expected an integer, got 0.5"),
    ("[[rules]]\npath_mse_m2_at_most = nan", "rules[0].path_mse_m2_at_most: expected a number up to 1e+15, got nan"),
    (
        "[[rules]]\nclearance_m_at_least = -1",
        "rules[0].clearance_m_at_least: expected >= 0, got -1",
    ),
    (
        '[[rules]]\ncollisions_at_most = 0\nscores = ["collisions"]',
        "rules[0].scores: expected no_worse_than beside them, got none",
    ),
    ("[[rules]", "expected TOML, got: "),
    (
        "[[rules]]\nperception.recal_at_least = 1",
        "rules[0].perception.recal_at_least: unknown key, did you mean 'recall_at_least'?",
    ),
    (
        "[[rules]]\nperception.recall_at_least = 95",
        "rules[0].perception.recall_at_least: expected <= 1, got 95",
    ),
    ("[[rules]]\nperception = 1", "rules[0].perception: expected a table, got 1"),
    ("[[rules]]\n[rules.perception]", "rules[0].perception: expected a bound, such as recall_at_least, got none"),
    (
        "[[rules]]\nperception.recall_at_least = 0.9",
        "FOLDER/perception.json: expected a table of perception, got: No such file or directory; vpf-sim perception",
    ),
]


@pytest.mark.parametrize(("text", "sentence"), RULES)
def test_a_wrong_rules_file_is_reported_by_file_and_key(
    text: str, sentence: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    folder, rules = run(tmp_path / "run", lambda _: {}), tmp_path / "rules.toml"
    rules.write_text(text)
    assert cli.run(["check", str(folder), "--rules", str(rules)]) == 2
    said = capsys.readouterr()
    file = "" if sentence.startswith("FOLDER") else f"{rules}: "
    assert said.err.startswith(f"vpf-sim: {file}{sentence.replace('FOLDER', str(folder))}")
    assert said.err.count("\n") == 1
    assert said.out == ""


def test_a_wrong_rules_file_has_a_line_for_each_fault(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder, rules = run(tmp_path / "run", lambda _: {}), tmp_path / "rules.toml"
    rules.write_text('[[rules]]\ndriver = 3\n[[rules]]\nno_worse_than = "b"\nscores = ["sucess_rate"]')
    assert cli.run(["check", str(folder), "--rules", str(rules)]) == 2
    first, second = capsys.readouterr().err.splitlines()
    assert first.endswith("rules[0].driver: expected a string, got 3")
    assert second.endswith("got 'sucess_rate': did you mean 'success_rate'?")


DOCS = Path(__file__).parents[3] / "docs"


def test_the_example_rules_show_every_key() -> None:
    rules = read_rules(DOCS / "rules.toml")
    assert {key for rule in rules for key in rule.bounds()} == set(BOUNDS)
    assert [rule.no_worse_than for rule in rules] == [None, None, None, None, "baseline"]
    shown = re.findall(r"^(?:\[rules\.)?(\w+)(?: =|\])", (DOCS / "rules.toml").read_text(), re.M)
    assert set(Rule.__dataclass_fields__) - set(shown) == {"driver"}


def test_the_commands_of_the_guide_exist(capsys: pytest.CaptureFixture[str]) -> None:
    commands = re.findall(r"vpf-sim (\w+ [^|\n]*)", (DOCS / "gate.md").read_text())
    assert {command.split()[0] for command in commands} == {"sweep", "check", "perception"}
    for command in commands:
        assert cli.run([*command.split(), "--help"]) == 0, command
        assert "Usage: vpf-sim" in capsys.readouterr().out


def test_every_key_of_the_rules_is_in_the_guide() -> None:
    assert set(Rule.__dataclass_fields__) - {"scenario", "weather", "driver"} <= set(
        re.findall(r"`(\w+)`", (DOCS / "gate.md").read_text())
    )
