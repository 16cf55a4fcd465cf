"""Drive the same episodes with two commits, and compare states and frames bit by bit.

    python scripts/compare_commits.py BEFORE [AFTER] [--small] [--scenario S] [--weather W] [--driver D] [--seeds 0:2]
                                      [--replay DRIVE] [--workers N] [--keep FOLDER]

AFTER is by default the working tree. By default `vpf` drives all scenarios of BEFORE's catalog in clear weather and
rain on seeds 0 and 1; --small is four episodes. --replay also compares the records of recorded drives. Each commit is
laid out in its own folder as if installed, and runs with this interpreter and its packages. Exit code 0 only if all is
equal.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tarfile
import tomllib
from collections.abc import Iterator, Mapping
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
HASHES = ("status", "states_sha256", "frames_sha256")
DEFAULT = {"weather": ["clear", "rain"], "driver": ["vpf"], "seeds": "0:2"}
SMALL = {"scenario": ["random", "town04"], "weather": ["rain"], "driver": ["vpf", "vpf-paper"], "seeds": "1:2"}
NO_LIMIT_S = "1000000"  # of an episode: times are not compared
MOST_LISTED = 8  # printed keys of a replay's record
Lines = dict[str, dict[str, Any]]  # of a run folder, by the name of the episode or drive


def git(*arguments: str) -> bytes:
    """The output of git; SystemExit with its message if it fails."""
    done = subprocess.run(["git", "-C", str(ROOT), *arguments], capture_output=True)
    if done.returncode:
        sys.exit(f"git {' '.join(arguments)}: {done.stderr.decode().strip()}")
    return done.stdout


def check_out(revision: str | None, folder: Path) -> None:
    """Write the files of a revision, or of the working tree without ignored files."""
    if revision is not None:
        with tarfile.open(fileobj=BytesIO(git("archive", "--format=tar", revision))) as archive:
            archive.extractall(folder, filter="data")
        return
    for name in git("ls-files", "-z", "-co", "--exclude-standard").decode().split("\0"):
        if name and (ROOT / name).is_file():  # skips the empty last name and deleted files
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)


def lay_out(revision: str | None, folder: Path) -> Path:
    """A folder for PYTHONPATH with the packages of a revision as if installed."""
    source, site = folder / "source", folder / "site"
    source.mkdir(parents=True)
    site.mkdir()
    check_out(revision, source)
    if (source / "building").exists():  # the camera's core, which older commits do not have
        subprocess.run([sys.executable, "-m", "building"], cwd=source, check=True)
    project = tomllib.loads((source / "pyproject.toml").read_text("utf-8"))
    mapped: dict[str, str] = project["tool"]["setuptools"]["package-dir"]
    for package in sorted(mapped, key=lambda name: name.count(".")):  # outer ones first
        shutil.move(source / mapped[package], site / Path(*package.split(".")))
    return site


class Commit:
    """A revision that can run commands, with this interpreter's packages."""

    def __init__(self, revision: str | None, folder: Path) -> None:
        self.name = revision or "the working tree"
        self._folder = folder
        self._runs = 0
        self._site = lay_out(revision, folder)
        paths = [str(self._site), *filter(None, [os.environ.get("PYTHONPATH")])]
        self._environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
        for module in ("vpf_sim", "vpf_sim.envs"):
            found = Path(self._python("-c", f"import {module}; print({module}.__file__)").stdout.strip())
            if not found.is_relative_to(self._site):
                sys.exit(f"{self.name}: {module} would come from {found}, not from {self._site}")

    def scenarios(self) -> list[str]:
        """The scenarios of its catalog."""
        return sorted(path.stem for path in (self._site / "vpf_sim" / "scenarios" / "catalog").glob("*.toml"))

    def sweep(self, grid: Mapping[str, list[str] | str], workers: int | None) -> Lines:
        """The records of a grid of episodes."""
        options = [word for key, values in grid.items() for value in _listed(values) for word in (f"--{key}", value)]
        options += [] if workers is None else ["--workers", str(workers)]
        options += ["--timeout", NO_LIMIT_S]
        return self._lines("sweep", "episodes.jsonl", "id", options)

    def replay(self, drives: list[Path], driver: str) -> Lines:
        """The records of recorded drives."""
        options = [*(str(drive.resolve()) for drive in drives), "--driver", driver, "--no-video"]
        return self._lines("replay", "replays.jsonl", "name", options)

    def _lines(self, command: str, file: str, key: str, options: list[str]) -> Lines:
        self._runs += 1
        out = self._folder / f"run-{self._runs}"
        done = self._python("-m", "vpf_sim.cli", command, *options, "--out", str(out))
        path = out / file
        if not path.exists():
            sys.exit(f"{self.name}: vpf-sim {command} made no {file}:\n{done.stderr.strip()}")
        rows = [json.loads(line) for line in path.read_text("utf-8").splitlines()]
        return {str(row[key]): row for row in rows}

    def _python(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, *arguments]
        return subprocess.run(command, cwd=self._folder, env=self._environment, capture_output=True, text=True)


def _listed(values: list[str] | str) -> list[str]:
    return [values] if isinstance(values, str) else values


def _places(values: list[str] | str) -> list[str] | str:
    """The values with absolute file paths, since the commits run in their own folders."""
    if isinstance(values, str):
        return values
    return [str(Path(value).resolve()) if value.endswith(".toml") else value for value in values]


def hashes_that_differ(before: Lines, after: Lines) -> Iterator[str]:
    """A line for each episode whose status, states or frames differ."""
    for name in sorted(before.keys() | after.keys()):
        one, two = before.get(name, {}), after.get(name, {})
        keys = [key for key in HASHES if one.get(key) != two.get(key)]
        if keys:
            yield f"{name}: {', '.join(keys)}"
        elif one.get("states_sha256") is None:
            yield f"{name}: driven by neither ({one.get('status')})"


def records_that_differ(before: Lines, after: Lines) -> Iterator[str]:
    """A line for each drive whose records differ in a value."""
    for name in sorted(before.keys() | after.keys()):
        one, two = dict(_leaves(before.get(name))), dict(_leaves(after.get(name)))
        keys = sorted(key for key in one.keys() | two.keys() if one.get(key, ...) != two.get(key, ...))
        if keys:
            more = f" and {len(keys) - MOST_LISTED} more" if len(keys) > MOST_LISTED else ""
            yield f"{name}: {', '.join(keys[:MOST_LISTED])}{more}"


def _leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """("key.key", value) of all values in nested tables and lists."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _leaves(inner, f"{path}.{key}" if path else key)
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            yield from _leaves(inner, f"{path}[{index}]")
    else:
        yield path, value


def main() -> int:
    """Compare, print the differences, and return the exit code."""
    requested = _parser().parse_args()
    with TemporaryDirectory(prefix="compare-commits-") as temporary:
        folder = Path(temporary) if requested.keep is None else requested.keep.resolve()
        before = Commit(requested.before, folder / "before")
        after = Commit(requested.after, folder / "after")
        grid = {"scenario": before.scenarios(), **(SMALL if requested.small else DEFAULT)}
        grid |= {key: _places(getattr(requested, key)) for key in grid if getattr(requested, key)}
        one, two = before.sweep(grid, requested.workers), after.sweep(grid, requested.workers)
        differ, driven = list(hashes_that_differ(one, two)), len(one.keys() | two.keys())
        for driver in grid["driver"] if requested.replay else []:
            one, two = before.replay(requested.replay, driver), after.replay(requested.replay, driver)
            differ += [f"{driver} on {line}" for line in records_that_differ(one, two)]
            driven += len(one.keys() | two.keys())
    for line in differ:
        print(f"differs: {line}")
    print(f"{driven - len(differ)} of {driven} equal: {before.name} and {after.name}")
    return 1 if differ or not driven else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", help="a revision")
    parser.add_argument("after", nargs="?", help="another one; the working tree by default")
    parser.add_argument("--small", action="store_true", help="four episodes only")
    parser.add_argument("--scenario", action="append", help="name or file; may be repeated")
    parser.add_argument("--weather", action="append", help="may be repeated")
    parser.add_argument("--driver", action="append", help="may be repeated")
    parser.add_argument("--seeds", help="A:B, without B")
    parser.add_argument("--replay", action="append", type=Path, metavar="DRIVE", help="may be repeated")
    parser.add_argument("--workers", type=int, help="worker processes; by default one per core")
    parser.add_argument(
        "--keep", type=Path, metavar="FOLDER", help="keep both commits and their runs in this new folder"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
