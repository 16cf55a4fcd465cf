"""Two commits compared by what they drive, in a repository of the test's own: a copy of this one's packages."""

import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from short_scenario import write_short

ROOT = Path(__file__).parents[2]
SCRIPT = Path("scripts") / "compare_commits.py"
AUTHOR = ("-c", "user.name=test", "-c", "user.email=test@example.org")
NEUTRAL, PUSHED = "Command(0.0, 0.0)", "Command(0.1, 0.0)"


@pytest.fixture(scope="module")
def repository(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One commit: the packages, pyproject.toml and the script."""
    folder = tmp_path_factory.mktemp("repository")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    for name in project["tool"]["setuptools"]["package-dir"].values():
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "scripts").mkdir()
    for name in ("pyproject.toml", SCRIPT):
        shutil.copy(ROOT / name, folder / name)
    for command in (["init", "-q"], ["add", "."], [*AUTHOR, "commit", "-q", "-m", "Begin"]):
        subprocess.run(["git", *command], cwd=folder, check=True)
    return folder


def compare(repository: Path, folder: Path, revision: str) -> subprocess.CompletedProcess[str]:
    """A revision with the working tree, by two drivers on the shortest drive."""
    grid = ["--scenario", str(write_short(folder)), "--weather", "clear", "--seeds", "0:1"]
    grid += ["--driver", "pid", "--driver", "neutral", "--workers", "1"]
    command = [sys.executable, str(repository / SCRIPT), revision, *grid]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True)


@pytest.mark.slow
def test_only_the_driver_whose_code_was_edited_differs(repository: Path, tmp_path: Path) -> None:
    file = repository / "vpf_sim" / "drivers" / "baselines.py"
    code = file.read_text()
    assert NEUTRAL in code
    file.write_text(code.replace(NEUTRAL, PUSHED))
    done = compare(repository, tmp_path, "HEAD")
    assert done.returncode == 1, done.stderr
    told, summary = done.stdout.splitlines()
    assert ".neutral.0: " in told
    assert "states_sha256" in told
    assert summary == "1 of 2 equal: HEAD and the working tree"


def test_a_revision_that_does_not_exist_is_told_in_the_words_of_git(repository: Path, tmp_path: Path) -> None:
    done = compare(repository, tmp_path, "no-such-commit")
    assert done.returncode == 1
    assert "no-such-commit" in done.stderr
    assert "Traceback" not in done.stderr
