"""The page of the configuration: made from the fields of the configuration classes."""

import json
import re
import runpy
from pathlib import Path
from typing import Literal

import pytest

from vpf_sim import cli
from vpf_sim.configuration import setting, settings
from vpf_sim.configuration_fields import Setting
from vpf_sim.planning import variant

SCRIPT = runpy.run_path(str(Path(__file__).parents[1] / "docs" / "configuration_page.py"))


@settings
class Inner:
    speed_mps: float = setting("at the start", ge=0.0, le=60.0)


@settings
class Outer:
    kind: Literal["a", "b"] = setting("a | b", default="a")
    reach_m: float | None = setting("none: as far as it sees", default=None, gt=0.0)
    parts: tuple[Inner, ...] = ()
    inner: Inner | None = None


def test_a_key_has_unit_meaning_bounds_and_default() -> None:
    first, listed, inner = SCRIPT["tables"](Outer, "[outer]")
    assert first.splitlines()[0] == "### [outer]"
    assert first.splitlines()[4:] == [
        "| `kind` |  | a \\| b | a, b | a |",
        "| `reach_m` | m | none: as far as it sees | > 0 | none |",
    ]
    assert listed.splitlines()[0] == "### [[outer.parts]]"
    assert inner.splitlines()[0] == "### [outer.inner]"
    assert inner.splitlines()[-1] == "| `speed_mps` | m/s | at the start | >= 0, <= 60 |  |"


def test_a_section_that_a_file_leaves_out_has_no_values() -> None:
    values = {"with": Outer(inner=Inner(1.5)), "without": Outer()}
    *_, inner = SCRIPT["tables"](Outer, "", values)
    assert inner.splitlines()[-1] == "| `speed_mps` | m/s | at the start | >= 0, <= 60 | 1.5 | - |"


def test_the_example_of_a_variant_can_be_loaded(tmp_path: Path) -> None:
    page = SCRIPT["page"]()
    (example,) = re.findall(r'```toml\n(base = "robust"\n.*?)```', page, re.DOTALL)
    (tmp_path / "mine.toml").write_text(example)
    assert variant.load(str(tmp_path / "mine.toml")) != variant.load("robust")


def test_the_commands_print_the_keys(capsys: pytest.CaptureFixture[str]) -> None:
    known = {"scenarios": "ego.sensors.pitch_deg", "weathers": "precipitation", "drivers": "flow.window_px"}
    for command, key in known.items():
        assert cli.run([command, "keys", "--json"]) == 0
        keys = {row["key"]: row for row in json.loads(capsys.readouterr().out)["keys"]}
        assert keys[key]["meaning"]


def test_every_meaning_can_be_read_alone() -> None:
    """Of all keys on the page: it begins as a sentence does, or with a name in code, and ends as one."""
    rows = [line.split(" | ") for line in SCRIPT["page"]().splitlines() if line.startswith("| `")]
    meanings = {row[0]: row[2] for row in rows if row[2].strip()}
    assert len(meanings) > 300
    assert {key: text for key, text in meanings.items() if not re.fullmatch(r"[A-Z`].*\.", text)} == {}


@pytest.mark.parametrize(
    ("key", "unit"),
    [
        ("odds_per_rad", "1/rad"),
        ("feedback_rad_per_m", "rad/m"),
        ("weight_per_m2", "1/m^2"),
        ("limit_radps2", "rad/s^2"),
    ],
)
def test_a_unit_that_is_a_quotient_is_whole(key: str, unit: str) -> None:
    assert Setting(key, float, "", "", 0.0).unit == unit
