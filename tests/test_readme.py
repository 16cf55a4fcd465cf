"""What the README shows runs, and what it and the docs link to exists."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from shell_blocks import shell_lines
from systems import POSIX_ONLY

import vpf_sim

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
PYTHON_BLOCKS = re.findall(r"```python\n(.*?)```\n+prints\n+```text\n(.*?)```", README, re.DOTALL)
MADE = {"commands.md", "configuration.md"}  # with the site, whose build checks their links
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
SHOWN = {
    *re.findall(r'`vpf_sim\.drive\("([\w-]+)", driver="(\w+)", seed=(\d+)\)`', README),
    *re.findall(
        r"^vpf-sim drive ([\w-]+) --driver (idm|expert) --seed (\d+)",
        (ROOT / "docs" / "highway-env.md").read_text(),
        re.MULTILINE,
    ),
}
LINES = [
    line for block in re.findall(r"^```sh\n(.*?)^```", README, re.MULTILINE | re.DOTALL) for line in shell_lines(block)
]
COMMANDS = sorted({line.split()[1] for line in LINES if line.startswith("vpf-sim ")})


def test_there_is_something_to_run() -> None:
    assert PYTHON_BLOCKS
    assert len(SHOWN) == 1, "the same drive on both pages"
    assert {"drive", "sweep", "report", "results", "check"} <= set(COMMANDS)


def test_it_is_short() -> None:
    assert len(README.splitlines()) <= 150


@pytest.mark.parametrize(("code", "printed"), PYTHON_BLOCKS)
def test_the_example_prints_what_it_claims(code: str, printed: str, tmp_path: Path) -> None:
    run = [sys.executable, "-c", code]
    done = subprocess.run(run, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.stderr == ""
    assert done.stdout == printed


@pytest.mark.parametrize(("scenario", "driver", "seed"), sorted(SHOWN))
def test_a_shown_drive_arrives(scenario: str, driver: str, seed: str) -> None:
    assert vpf_sim.drive(scenario, driver=driver, seed=int(seed)).status == "success"


@pytest.mark.slow
@POSIX_ONLY
def test_the_commands_do_what_they_say(tmp_path: Path) -> None:
    """Each exits with 0, but for `check`: the README says that one of the drivers breaks rules."""
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    for line in LINES:
        if not line.startswith("vpf-sim "):
            continue
        done = subprocess.run(
            ["sh", "-c", line], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == (1 if line.startswith("vpf-sim check") else 0), f"{line}\n{done.stderr}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_and_pictures_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)|src=\"([^\"]+)\"", page.read_text("utf-8")):
        path, _, anchor = "".join(target).partition("#")
        if page.is_relative_to(ROOT / "docs") and Path(path).name in MADE:
            continue
        if path.startswith(("https://", "../../actions/")):  # the latter: pages of the repository's own workflows
            continue
        linked = page.parent / path if path else page
        assert linked.exists(), path
        assert not anchor or anchor in anchors(linked.read_text("utf-8")), f"{path}#{anchor}"


def anchors(page: str) -> set[str]:
    """The names that GitHub gives to a page's headings, and those that the page sets."""
    headings = re.findall(r"^#+ (.+)$", page, re.MULTILINE)
    slugs = {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}
    return slugs | set(re.findall(r'<a id="([^"]+)">', page))
