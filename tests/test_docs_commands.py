"""Each command in the docs parses, and those of a page run from top to bottom as printed.

The test plays the reader: it makes the video, the second drive and the driver that a page needs, and writes the files
that a page shows.
"""

import os
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from time import sleep

import pytest
import recorded_layouts as layouts
import rendered_drive as rendered
import typer
from shell_blocks import shell_lines
from systems import POSIX_ONLY

from vpf_sim import configuration
from vpf_sim.cli import app
from vpf_sim.replay.drive_file import DriveFile

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = ["own-drives", "gate", "sweeps", "reproduce", "datasets", "verification"]
# For a good part of an hour, or need recordings; the gallery's are driven by the script that makes it.
TOO_LONG = {"results", "learning", "hard", "highway-env", "twins", "gallery"}
TUTORIALS = {"start"}  # tests/test_tutorials.py
WRITTEN = {"results.md", "commands.md"}  # by the program
MOST_COLUMNS = 92
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
ELSEWHERE = ("pip ", "helm ")  # what sets up machines, and no command of ours
STAYS = "dask "  # runs until it is ended
DRIVER = """from vpf_sim.drivers import RouteDriver
class MyDriver(RouteDriver):
    def __init__(self):
        super().__init__("pid")
"""


def blocks(page: str, *kinds: str) -> list[tuple[str, str]]:
    """(kind, content) of the code on a page, from top to bottom."""
    found = BLOCK.findall((DOCS / f"{page}.md").read_text("utf-8"))
    return [(kind, content) for kind, content in found if not kinds or kind in kinds]


def commands(page: Path) -> list[str]:
    """The commands of a page's shell blocks."""
    found = BLOCK.findall(page.read_text("utf-8"))
    return [line for kind, content in found if kind == "sh" for line in shell_lines(content)]


OURS = [
    pytest.param(shlex.split(line.split("||")[0], comments=True)[1:], id=f"{page.stem}: {line[:60]}")
    for page in (ROOT / "README.md", *sorted(DOCS.rglob("*.md")))
    for line in commands(page)
    if line.startswith("vpf-sim ")
]


@pytest.mark.parametrize("words", OURS)
def test_a_printed_command_is_understood(words: list[str]) -> None:
    """Its name, arguments and options exist and have values that they can have."""
    command, context = typer.main.get_command(app), None
    while getattr(command, "commands", None):
        context = command.make_context(words[0], list(words), parent=context, resilient_parsing=False)
        name, command, words = command.resolve_command(context, words)  # type: ignore[attr-defined]
    assert command is not None
    command.make_context(name, list(words), parent=context)


def test_printed_commands_fit_the_page() -> None:
    """Longer ones are broken over lines."""
    for page in (ROOT / "README.md", *DOCS.rglob("*.md")):
        if page.name not in WRITTEN:
            found = BLOCK.findall(page.read_text("utf-8"))
            lines = [line for kind, content in found if kind == "sh" for line in content.splitlines()]
            assert not [line for line in lines if len(line) > MOST_COLUMNS], page.name


def test_every_page_with_commands_is_run() -> None:
    assert {page.stem for page in DOCS.glob("*.md") if commands(page)} == {*PAGES, *TOO_LONG, *TUTORIALS}


def test_drive_toml_as_printed_is_one() -> None:
    for page in ("recordings", "own-drives"):
        for _, content in blocks(page, "toml"):
            table = configuration.parse(content, page)
            drive = configuration.build(DriveFile, table, page)
            assert drive.schema == 1
            assert drive.signals is not None
            assert drive.signals.columns


def record_video(path: Path) -> None:
    """Write 2.5 s of straight driving."""
    images, _ = rendered.shots(float("inf"), 2, 0.0, None, rendered.FRAMES)
    path.parent.mkdir(parents=True)
    layouts.video(path, list(images), rendered.RATE_HZ)


@contextmanager
def started(line: str, folder: Path, environment: dict[str, str]) -> Iterator[None]:
    """A command that stays, until the context is left."""
    process = subprocess.Popen(["sh", "-c", line], cwd=folder, env=environment, start_new_session=True)
    try:
        yield
    finally:
        os.killpg(process.pid, signal.SIGTERM)
        process.wait()


def run(line: str, folder: Path, environment: dict[str, str]) -> None:
    words = ["sh", "-c", line]
    done = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    wanted = (0, 1) if line.startswith("vpf-sim check") else (0,)  # the driver may break a rule
    assert done.returncode in wanted, f"{line}\n{done.stderr}"
    assert "Traceback" not in done.stderr, f"{line}\n{done.stderr}"


def wait_for_scheduler() -> None:
    """Until one listens on the port that the page names."""
    for _ in range(600):
        with suppress(OSError), socket.create_connection(("127.0.0.1", 8786), timeout=1.0):
            return
        sleep(0.1)
    pytest.fail("no scheduler came up")


@POSIX_ONLY
@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES)
def test_a_page_runs_from_top_to_bottom_as_printed(page: str, tmp_path: Path) -> None:
    record_video(tmp_path / "my_drive" / "drive.mp4")
    record_video(tmp_path / "home_to_work" / "drive.mp4")
    (tmp_path / "my_package").mkdir()
    (tmp_path / "my_package" / "driver.py").write_text(DRIVER)
    shutil.copy(DOCS / "rules.toml", tmp_path)
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path, "HOST": "127.0.0.1"}
    ran = 0
    with ExitStack() as staying:
        for kind, content in blocks(page, "sh", "toml", "csv"):
            if kind != "sh":
                (tmp_path / "my_drive" / {"toml": "drive.toml", "csv": "signals.csv"}[kind]).write_text(content)
                continue
            for line in shell_lines(content):
                if line.startswith(STAYS):
                    staying.enter_context(started(line, tmp_path, environment))
                    wait_for_scheduler()
                elif not line.startswith(ELSEWHERE):
                    run(line, tmp_path, environment)
                    ran += 1
    assert ran
