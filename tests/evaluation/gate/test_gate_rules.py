"""The rules of the gate: faults reported by key, and the guide with all keys."""

import re
from pathlib import Path

import pytest
from shell_blocks import shell_lines

from vpf_sim import cli
from vpf_sim.evaluation.gate.rules import BOUNDS, Rule, read_rules

DOCS = Path(__file__).parents[3] / "docs"


def test_the_example_rules_show_every_key() -> None:
    rules = read_rules(DOCS / "rules.toml")
    assert {key for rule in rules for key in rule.bounds()} == set(BOUNDS)
    assert [rule.no_worse_than for rule in rules] == [None, None, None, None, "baseline"]
    shown = re.findall(r"^(?:\[rules\.)?(\w+)(?: =|\])", (DOCS / "rules.toml").read_text(), re.M)
    assert set(Rule.__dataclass_fields__) - set(shown) == {"driver"}


def test_the_commands_of_the_guide_exist(capsys: pytest.CaptureFixture[str]) -> None:
    lines = shell_lines((DOCS / "gate.md").read_text())
    commands = [command for line in lines for command in re.findall(r"vpf-sim (\w+ [^|`]*)", line)]
    assert {command.split()[0] for command in commands} == {"drive", "sweep", "check", "perception"}
    for command in commands:
        assert cli.run([*command.split(), "--help"]) == 0, command
        assert "Usage: vpf-sim" in capsys.readouterr().out


def test_every_key_of_the_rules_is_in_the_guide() -> None:
    assert set(Rule.__dataclass_fields__) - {"scenario", "weather", "driver"} <= set(
        re.findall(r"`(\w+)`", (DOCS / "gate.md").read_text())
    )
