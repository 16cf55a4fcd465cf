"""Each tutorial runs from top to bottom as printed, in a fresh folder, and every other block of code is well formed.

A block below a line with "Save this as `NAME`" is written to that file; shell lines and Python run there. Text after
"prints" is what the Python before it prints.
"""

import importlib.util
import os
import re
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

import pytest
import yaml
from shell_blocks import shell_lines

import vpf_sim
from vpf_sim import configuration, scenarios
from vpf_sim.envs.camera import weather

DOCS = Path(__file__).parents[1] / "docs"
TUTORIALS = [DOCS / "start.md", *(DOCS / "tutorials").glob("*.md")]
PAGES = [path for path in DOCS.rglob("*.md") if path.name != "commands.md"]  # which is made from the program
SKIPPED = ("pip ", "vpf-sim doctor", "vpf-sim play")  # sets up the machine; have tests of their own
OPTIONAL = "stable_baselines3"
# In its place where it is not installed, as it needs torch: it takes what the library takes, and learns nothing.
STAND_IN = """
import json
from pathlib import Path
import numpy as np


class PPO:
    def __init__(self, policy, env, **options):
        assert policy == "MultiInputPolicy"
        self.shapes = {name: list(space.shape) for name, space in env.observation_space.spaces.items()}
        self.env = env

    def learn(self, total_timesteps):
        self.env.reset(seed=0)
        info = self.env.step(self.env.action_space.sample())[-1]
        assert info["is_success"] is False

    def save(self, path):
        Path(path).write_text(json.dumps(self.shapes))

    @classmethod
    def load(cls, path, device):
        made = cls.__new__(cls)
        made.shapes = json.loads(Path(path).read_text())
        return made

    def predict(self, observation, deterministic):
        assert {name: list(value.shape) for name, value in observation.items()} == self.shapes
        return np.zeros(2, np.float32), None
"""


@dataclass(frozen=True, slots=True)
class Block:
    """Code on a page."""

    kind: str
    content: str
    before: str  # the last line of text above it

    @property
    def file(self) -> str | None:
        """The name under which the page says to save it."""
        named = re.search(r"Save this as `([^`]+)`", self.before)
        return named.group(1) if named else None


def blocks(page: Path) -> list[Block]:
    """The code of a page, from top to bottom."""
    parts = re.split(r"^```", page.read_text("utf-8"), flags=re.MULTILINE)
    found = []
    for text, fenced in zip(parts[::2], parts[1::2], strict=False):
        kind, _, content = fenced.partition("\n")
        lines = text.strip().splitlines()
        found.append(Block(kind, content, lines[-1] if lines else ""))
    return found


def run(words: list[str], folder: Path) -> str:
    """What a command prints on stdout, in an environment with the program on its path."""
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{words}\n{done.stdout}{done.stderr}"
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("page", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial_runs_from_top_to_bottom_as_printed(page: Path, tmp_path: Path) -> None:
    printed = ""
    if not importlib.util.find_spec(OPTIONAL):
        (tmp_path / f"{OPTIONAL}.py").write_text(STAND_IN, "utf-8")
    for block in blocks(page):
        if block.file:
            (tmp_path / block.file).write_text(block.content, "utf-8")
        elif block.kind == "sh":
            for line in shell_lines(block.content):
                if not line.startswith(SKIPPED):
                    run(["sh", "-c", line], tmp_path)
        elif block.kind == "python":
            printed = run([sys.executable, "-c", block.content], tmp_path)
        elif block.kind == "text" and block.before == "prints":
            assert printed == block.content


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_every_block_is_well_formed(page: Path) -> None:
    for block in blocks(page):
        if block.kind == "python":
            compile(block.content, str(page), "exec")
        elif block.kind == "toml":
            tomllib.loads(block.content)
        elif block.kind == "yaml":
            yaml.safe_load(block.content)
        else:
            assert block.kind in {"sh", "csv", "text", "{toctree}", "{eval-rst}"}, block


@pytest.mark.parametrize("page", ["reference", "weather"])
def test_scenarios_and_weathers_of_the_other_pages_are_valid(page: str, tmp_path: Path) -> None:
    found = [block.content for block in blocks(DOCS / f"{page}.md") if block.kind == "toml"]
    for number, content in enumerate(found):
        path = tmp_path / f"{number}.toml"
        path.write_text(content, "utf-8")
        load = weather.load if "droplets" in configuration.parse(content, path.name) else scenarios.load
        assert load(str(path)) == load(str(path))
    assert found


def test_every_public_name_is_on_the_page_of_the_api() -> None:
    page = (DOCS / "api.md").read_text("utf-8")
    documented = set(re.findall(r"^\.\. auto\w+:: vpf_sim\.(\w+)(?:\(\))?$", page, re.MULTILINE))
    assert documented == set(vpf_sim.__all__) - {"__version__"}


def test_every_page_is_in_the_table_of_contents() -> None:
    listed = set(re.findall(r"^(?:.*<)?([\w/-]+)>?$", (DOCS / "index.md").read_text("utf-8"), re.MULTILINE))
    assert listed >= {path.relative_to(DOCS).with_suffix("").as_posix() for path in PAGES} - {"index"}
