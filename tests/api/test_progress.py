"""Progress lines: failures, rate, time left, and the file of an error."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from vpf_sim.api import progress as module
from vpf_sim.api.progress import Tally, clock, progress
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record, unscored


def folder(done: int = 0) -> Any:
    return SimpleNamespace(done=set(range(done)), error_file=lambda name: Path("run/errors") / f"{name}.txt")


def record(name: str, status: str) -> Record:
    return unscored(Job("a", "clear", "pid", 0), status).model_copy(update={"id": name})


@pytest.fixture
def time(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The clock's hand, in s; to be moved by hand."""
    hand = [100.0]
    monkeypatch.setattr(module, "monotonic", lambda: hand[0])
    return hand


def test_rate_and_time_left_are_those_of_this_session(time: list[float]) -> None:
    tally = Tally(total=20, done=10, started_s=time[0])
    assert tally.text() == "no episode yet"
    time[0] += 60.0
    for status in ("success", "collision", "success", "success"):
        tally.count(record("a", status))
    assert tally.text() == "3 of 4 reached the goal, 240 an hour, 0:01:30 left"


@pytest.mark.parametrize(("seconds", "text"), [(0.4, "0:00:00"), (59.6, "0:01:00"), (3725.0, "1:02:05")])
def test_clock_has_hours_minutes_seconds(seconds: float, text: str) -> None:
    assert clock(seconds) == text


def test_without_a_terminal_each_episode_is_a_line(capsys: pytest.CaptureFixture[str], time: list[float]) -> None:
    with progress(4, folder(done=1)) as tell:
        time[0] += 36.0
        tell(record("a", "success"))
        tell(record("b", "error"))
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.splitlines() == [
        "2/4 a success (1 of 1 reached the goal, 100 an hour, 0:01:12 left)",
        "3/4 b error (1 failed, 1 of 2 reached the goal, 200 an hour, 0:00:18 left)",
        "b: error, see run/errors/b.txt",
    ]


def test_on_a_terminal_there_is_a_bar(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, time: list[float]
) -> None:
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "200")
    with progress(3, folder(done=1)) as tell:
        time[0] += 36.0
        tell(record("[a]", "error"))
    said = capsys.readouterr().err
    assert "2/3" in said
    assert "1 failed, 0 of 1 reached the goal, 100 an hour, 0:00:36 left, last [a]" in said
    assert "[a]: error, see run/errors/[a].txt" in said
