"""Messages of commands on short, empty, failing and mistyped runs."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from systems import POSIX_ONLY

from vpf_sim.cli import run
from vpf_sim.cli.output import measure
from vpf_sim.errors import InputError
from vpf_sim.evaluation.episode import driver_check
from vpf_sim.evaluation.sweeps import cluster
from vpf_sim.geometry import mounting_in_words

README = (Path(__file__).parents[2] / "README.md").read_text("utf-8")
DRIVERS = """from vpf_sim import Command


class Good:
    privileged, uses_images = "none", False

    def reset(self, setup): pass

    def act(self, observation): return Command(0.0, 0.0)


class Divides(Good):
    def act(self, observation): return Command(1.0 / (observation.time_s != 0.5) * 0.0, 0.0)


class Tuple(Good):
    def act(self, observation): return (0.0, 0.0)


class Nan(Good):
    def act(self, observation): return Command(float("nan"), 0.0)


class Unready(Good):
    def reset(self, setup): raise RuntimeError("no weights")
"""


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "tried_drivers.py").write_text(DRIVERS)
    monkeypatch.syspath_prepend(str(tmp_path))
    return "tried_drivers"


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("Divides", "frame 30: ZeroDivisionError"),
        ("Tuple", "frame 0: TypeError: driver: act: expected a vpf_sim.Command, got \\(0.0, 0.0\\)"),
        ("Nan", "frame 0: ValueError: driver: Command: throttle: expected a finite number"),
        ("Unready", "reset: RuntimeError: no weights"),
    ],
)
def test_a_driver_that_fails_is_reported_as_invalid(name: str, said: str, module: str) -> None:
    with pytest.raises(InputError, match=f"^driver '{module}:{name}': without obstacles: {said}") as caught:
        driver_check.check(f"{module}:{name}")
    assert "\n" not in str(caught.value)


def test_a_driver_that_drives_is_valid(module: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["drivers", "validate", f"{module}:Good"]) == 0
    assert capsys.readouterr().out == f"{module}:Good: valid, privileged: none\n"


@pytest.mark.parametrize(
    "command",
    [
        ["drive", "straight", "--driver", "pid", "--video", "vidoes/a.mp4"],
        ["drive", "straight", "--driver", "pid", "--rerun", "vidoes/a.rrd"],
        ["check", "run", "--rules", "rules.toml", "--junit", "vidoes/a.xml"],
        ["report", "run", "--out", "vidoes/a.html"],
        ["video", "run", "--id", "a", "--out", "vidoes/a.mp4"],
    ],
)
def test_a_mistyped_folder_is_refused_before_any_work(
    command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(command) == 2
    assert capsys.readouterr().err == (
        f"vpf-sim: {command[-2]}: {command[-1]}: expected a folder that exists, found no vidoes\n"
    )
    assert not list(tmp_path.iterdir())


def test_a_missing_value_has_no_unit() -> None:
    assert measure(None, "m") == "-"
    assert measure(1.25, "m") == "1.25 m"


def test_a_mounting_is_described_by_direction() -> None:
    assert mounting_in_words(-2.7, 1.0) == "looks 2.70 deg up and 1.00 deg right"
    assert mounting_in_words(0.5, -3.0) == "looks 0.50 deg down and 3.00 deg left"


@pytest.mark.parametrize("address", ["nonsense", "tcp://localhost", "tcp://localhost:x", "http://localhost:1"])
def test_an_invalid_address_is_refused_without_connecting(address: str) -> None:
    pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    with (
        pytest.raises(InputError, match=f"^cluster: expected a Dask scheduler at {re.escape(address)}, got: .+$"),
        cluster.connected(address, {}, False),
    ):
        pass


def test_the_readmes_commands_use_runs_of_earlier_commands() -> None:
    """A command reads a run folder that an earlier one has written; a sweep without --out makes runs/latest."""
    (block,) = re.findall(r"```sh\n(vpf-sim drive.*?)```", README, re.DOTALL)
    made: set[str] = set()
    for line in block.splitlines():
        command = line.partition("#")[0]
        written = set(re.findall(r"--out (\S+)", command))
        read = set(re.findall(r"\bruns/\w+", command))
        assert read <= made | written, line
        made |= written or ({"runs/latest"} if command.startswith("vpf-sim sweep") else set())
    assert made


@POSIX_ONLY
@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&-"])
@pytest.mark.parametrize(("words", "code"), [("drivers list --json", 0), ("drivers show nobody", 2)])
def test_closed_streams_are_no_fault(closed: str, words: str, code: int, tmp_path: Path) -> None:
    """As of a program without a terminal."""
    command = f"{shlex.quote(sys.executable)} -m vpf_sim.cli {words} {closed}"
    done = subprocess.run(["sh", "-c", command], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == code
    assert "Traceback" not in done.stderr
