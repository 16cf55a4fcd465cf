"""The GitHub Action: the test plays the runner on the steps of action.yml, but for those that install and upload."""

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml
from systems import POSIX_ONLY

ROOT = Path(__file__).parents[1]
ACTION = yaml.safe_load((ROOT / "action.yml").read_text("utf-8"))
STEPS: list[dict[str, Any]] = ACTION["runs"]["steps"]
COMMANDS = [step for step in STEPS if "run" in step and "pip install" not in step["run"]]
EXPRESSION = re.compile(r"\$\{\{\s*(.*?)\s*\}\}")
BEND = """
schema = 1
[road]
segments = [{kind = "arc", length_m = 80, radius_m = 60}]
[ego]
s_m = 5.0
[goal]
s_m = 25.0
"""
RULES = "[[rules]]\nsuccess_rate_at_least = 1\nclear_path_mse_m2_at_most = 0.1\n"


def run_action(folder: Path, **inputs: str) -> list[int]:
    """Exit codes of the steps that ran, with the inputs given and the defaults of the others."""
    values = {name: given.get("default", "") for name, given in ACTION["inputs"].items()} | inputs
    (folder / "bend.toml").write_text(BEND)
    (folder / "rules.toml").write_text(RULES)
    codes: list[int] = []
    for step in COMMANDS:
        runs_after_failure = "cancelled()" in step.get("if", "") and codes[0] == 0
        if any(codes) and not runs_after_failure:
            continue
        (folder / "script.sh").write_text(step["run"])
        environment = {
            **os.environ,
            "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
            "GITHUB_STEP_SUMMARY": str(folder / "summary.md"),
            **{
                key: EXPRESSION.sub(lambda found: values_of(found[1], values), text)
                for key, text in step["env"].items()
            },
        }
        shell = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "script.sh"]
        codes.append(subprocess.run(shell, cwd=folder, env=environment, check=False).returncode)
    return codes


def values_of(expression: str, inputs: dict[str, str]) -> str:
    context, _, name = expression.partition(".")
    assert context == "inputs"
    return inputs[name]


def test_the_action_is_a_composite_one_whose_inputs_exist() -> None:
    assert ACTION["runs"]["using"] == "composite"
    assert {"name", "description"} <= ACTION.keys()
    assert all(given["description"] for given in ACTION["inputs"].values())
    for step in STEPS:
        assert ("uses" in step) != ("run" in step)
        assert "uses" in step or step["shell"] == "bash"
        assert "${{" not in step.get("run", ""), "an expression in a script lets an input run commands"
    used = set(re.findall(r"inputs\.([\w-]+)", (ROOT / "action.yml").read_text("utf-8")))
    assert used == set(ACTION["inputs"])


def test_the_workflow_of_the_project_uses_inputs_that_exist() -> None:
    workflow = yaml.safe_load((ROOT / ".github" / "workflows" / "gate.yml").read_text("utf-8"))
    (step,) = [step for step in workflow["jobs"]["gate"]["steps"] if step["uses"] == "./"]
    assert set(step["with"]) <= set(ACTION["inputs"])
    needed = {name for name, given in ACTION["inputs"].items() if given.get("required")}
    assert needed <= set(step["with"])


@POSIX_ONLY
@pytest.mark.parametrize(("driver", "check"), [pytest.param("pid", 0, marks=pytest.mark.slow), ("neutral", 1)])
def test_the_steps_run_and_fail_for_a_driver_that_leaves_its_lane(driver: str, check: int, tmp_path: Path) -> None:
    inputs = {"driver": driver, "scenarios": "bend.toml", "weathers": "clear", "rules": "rules.toml"}
    assert run_action(tmp_path, **inputs) == [0, check, 0]
    summary = (tmp_path / "summary.md").read_text("utf-8")
    assert ("❌ Gate" in summary) == (check == 1)
    assert f"| bend.toml | clear | {driver} |" in summary
    folder = tmp_path / ACTION["inputs"]["out"]["default"]
    assert {"report.html", "check.md", "junit.xml", "episodes.jsonl"} <= {path.name for path in folder.iterdir()}


@POSIX_ONLY
def test_a_wrong_input_fails_the_first_step(tmp_path: Path) -> None:
    assert run_action(tmp_path, driver="no_such_driver", scenarios="bend.toml", weathers="clear") == [1]
    assert not (tmp_path / "summary.md").exists()
