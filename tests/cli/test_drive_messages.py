"""What `drive` says when a driver is none or fails, on Ctrl-C, and about a collision."""

import subprocess
import sys
from pathlib import Path

import pytest
from short_scenario import SHORT, write_short

from vpf_sim import cli
from vpf_sim.errors import cause

DRIVERS = """import numpy as np
import vpf_sim


class Blind(vpf_sim.Driver):
    uses_images = False


class Forgot(Blind):
    def reset(self, setup): raise AssertionError("begun")


class TwoArguments(Blind):
    def act(self, observation, speed): return vpf_sim.Command(0.0, 0.0)


class NoMethod(Blind):
    act = "forward"


class WrongReset(Blind):
    def reset(self): pass
    def act(self, observation): return vpf_sim.Command(0.0, 0.0)


class OfNumpy(Blind):
    def act(self, observation): return self.reshaped()
    def reshaped(self):
        return np.zeros(4).reshape(3)  # of numpy


class TwoLines(Blind):
    def act(self, observation):
        raise ValueError("first\\nsecond")  # of two lines


class Chained(Blind):
    def act(self, observation):
        try:
            {}["a"]
        except KeyError as error:
            raise RuntimeError("no a") from error  # chained


class Begins(Blind):
    def reset(self, setup): raise OSError("no weights")  # at reset
    def act(self, observation): pass


class Returns(Blind):
    def act(self, observation): return (0.0, 0.0)  # a tuple


class Nan(Blind):
    def act(self, observation): return vpf_sim.Command(0.0, float("nan"))  # nan
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "message_drivers", raising=False)
    (tmp_path / "message_drivers.py").write_text(DRIVERS)
    write_short(tmp_path)
    return tmp_path


def drive(name: str) -> int:
    return cli.run(["drive", "short.toml", "--driver", f"message_drivers:{name}"])


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("Forgot", "expected privileged, reset and act; missing: act"),
        ("TwoArguments", "expected a method act(observation), got act(observation, speed)"),
        ("NoMethod", "expected a method act(observation), got act = 'forward'"),
        ("WrongReset", "expected a method reset(setup), got reset()"),
    ],
)
def test_a_class_that_is_no_driver_is_refused_before_the_drive(
    name: str, message: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert drive(name) == 2
    assert capsys.readouterr().err == f"vpf-sim: driver 'message_drivers:{name}': {message}\n"
    assert not (folder / "runs").exists()


@pytest.mark.parametrize(
    ("name", "message", "mark"),
    [
        ("OfNumpy", "ValueError: cannot reshape array of size 4 into shape (3,)", "of numpy"),
        ("TwoLines", "ValueError: first second", "of two lines"),
        ("Chained", "RuntimeError: no a", "chained"),
        ("Begins", "OSError: no weights", "at reset"),
        ("Returns", "TypeError: driver: act: expected a vpf_sim.Command, got (0.0, 0.0)", "a tuple"),
        ("Nan", "ValueError: driver: Command: steering: expected a finite number, got nan", "nan"),
    ],
)
def test_an_exception_of_a_driver_names_file_and_line(
    name: str, message: str, mark: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = DRIVERS.splitlines()
    line = next(number for number, text in enumerate(lines, 1) if text.endswith(f"  # {mark}"))
    assert drive(name) == 1
    said = capsys.readouterr().err.splitlines()
    assert said[0] == f"vpf-sim: {message} ({folder / 'message_drivers.py'}, line {line})"
    assert said[1].startswith("vpf-sim: the traceback is in ")


def test_the_cause_is_where_an_installed_package_was_called() -> None:
    """Of a driver in site-packages, the innermost file may be a library's."""
    library = Path(pytest.__file__).parents[1]
    traceback = (
        "Traceback (most recent call last):\n"
        f'  File "{Path(cli.__file__).parents[1]}/drivers/protocol.py", line 5, in command_of\n    driver.act()\n'
        f'  File "{library}/their_driver/main.py", line 7, in act\n    f()\n'
        f'  File "{library}/numpy/core.py", line 9, in f\n    raise IndexError\n'
        "IndexError: out of range\n"
    )
    assert cause(traceback) == f"IndexError: out of range ({library}/their_driver/main.py, line 7)"
    assert cause("ValueError: without a traceback") == "ValueError: without a traceback"


@pytest.mark.parametrize("command", [["drive", "straight", "--driver", "pid"], ["doctor", "--profile"], ["doctor"]])
def test_ctrl_c_is_one_line(
    command: list[str], folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("vpf_sim.evaluation.episode.episode.run", stop)
    monkeypatch.setattr("vpf_sim.envs.four_lane.FourLane.reset", stop)
    monkeypatch.setattr("vpf_sim.evaluation.pool.run", stop)
    assert cli.run(command) == 130
    (line,) = capsys.readouterr().err.splitlines()
    assert line == "vpf-sim: stopped by Ctrl-C" + ("; the drive is not stored" if command[0] == "drive" else "")
    assert not [*(folder / "runs").glob("*")]


CAR = '[[bodies]]\nkind = "{kind}"\ns_m = {s_m}\nlane = 2\n{more}'
ROAD = SHORT.replace("s_m = 11.0", "s_m = 60.0").partition("[vary]")[0]


@pytest.mark.parametrize(
    ("kind", "s_m", "more", "said"),
    [
        ("car", 30.0, "", "car, the fault is the ego's: it stood (stopped_track)"),
        ("pedestrian", 25.0, "", "pedestrian, the fault is the ego's: it stood (stopped_track)"),
        ("car", 30.0, "speed_mps = 2.0\n", "car, the fault is the ego's: the ego's front hit it (active_front)"),
    ],
)
def test_a_collision_names_the_other_party_and_whose_fault_it_was(
    kind: str, s_m: float, more: str, said: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "hit.toml").write_text(ROAD + CAR.format(kind=kind, s_m=s_m, more=more))
    assert cli.run(["drive", "hit.toml", "--driver", "pid"]) == 1
    first, second, *_ = capsys.readouterr().out.splitlines()
    assert first.endswith(": collision")
    assert second == f"  collided with    {said}"


def test_gymnasiums_checker_prints_no_complaint_of_sdl() -> None:
    """It opens the window, too, also where there is no display."""
    code = (
        "import os, warnings\n"
        "for key in ('DISPLAY', 'WAYLAND_DISPLAY', 'SDL_VIDEODRIVER'): os.environ.pop(key, None)\n"
        "warnings.simplefilter('ignore'); import gymnasium, vpf_sim\n"
        "from gymnasium.utils.env_checker import check_env\n"
        "for name in ('FourLane', 'FourLanePixels'):\n"
        "    check_env(gymnasium.make(f'vpf_sim/{name}-v0').unwrapped); assert 'SDL_VIDEODRIVER' not in os.environ"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
