"""Each example runs in a fresh folder and prints what its docstring claims; notebooks are those of their scripts."""

import ast
import json
import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
TRAINING = {"train_bc", "train_ppo"}  # take minutes and the extra `learn`: tests/test_behaviour_cloning.py
SCRIPTS = sorted(path for path in EXAMPLES.glob("*.py") if path.stem not in TRAINING)
NOTEBOOKS = sorted(EXAMPLES.glob("*.ipynb"))
QUICK = {"gym_loop_with_wrappers"}  # the others run with the slow tests
SUBJECTS = {"first_drive", "own_driver", "train_a_policy", "own_map", "compare_two_drivers", "camera_on_highway_env"}
MOST_LINES, MOST_BYTES = 75, 300_000
INSTALL = "%pip install "


def claimed(script: Path) -> str:
    """What the docstring says that the script prints: its first indented block."""
    docstring = ast.get_docstring(ast.parse(script.read_text("utf-8"))) or ""
    block = re.search(r"^(?: {4}.*\n)+", docstring + "\n", re.MULTILINE)
    return textwrap.dedent(block.group()) if block else ""


def printed(notebook: Path) -> str:
    """The text that the cells of a notebook printed."""
    outputs = [
        output for cell in json.loads(notebook.read_text("utf-8"))["cells"] for output in cell.get("outputs", ())
    ]
    return "".join("".join(output["text"]) for output in outputs if output.get("name") == "stdout")


def code(notebook: Path) -> list[str]:
    """The code of a notebook, line by line, without empty ones."""
    cells = json.loads(notebook.read_text("utf-8"))["cells"]
    text = "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
    return [line for line in text.splitlines() if line]


def test_there_is_a_notebook_for_each_subject() -> None:
    assert {notebook.stem for notebook in NOTEBOOKS} == SUBJECTS


@pytest.mark.parametrize(
    "script", [pytest.param(one, id=one.stem, marks=() if one.stem in QUICK else pytest.mark.slow) for one in SCRIPTS]
)
def test_an_example_prints_what_it_claims_and_leaves_nothing_behind(script: Path, tmp_path: Path) -> None:
    environment = {**os.environ, "MPLBACKEND": "agg"}
    command = [sys.executable, "-W", "ignore", script]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout == claimed(script) != ""
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_an_example_is_short(script: Path) -> None:
    assert len(script.read_text("utf-8").splitlines()) < MOST_LINES


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_its_script_and_shows_small_pictures(notebook: Path) -> None:
    """`make notebooks` makes them again."""
    script = notebook.with_suffix(".py")
    lines = script.read_text("utf-8").partition("# %%")[2].splitlines()[1:]
    install, *rest = code(notebook)
    assert install.startswith(INSTALL)
    assert rest == [line for line in lines if line and not line.startswith("# %%")]
    assert printed(notebook) == claimed(script)
    text = notebook.read_text("utf-8")
    assert '"image/jpeg"' in text or '"text/html"' in text
    assert notebook.stat().st_size < MOST_BYTES
