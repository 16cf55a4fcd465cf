"""Worker processes that die, hang, fail, or are abandoned."""

import importlib
import os
import signal
import time
from collections.abc import Callable
from functools import partial
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

import pytest
from systems import POSIX_ONLY

from vpf_sim.evaluation import pool


def minute(_: object) -> float:
    return 60.0


def short_for_three(number: int) -> float:
    """Only the task that hangs has little time: no other is given up on a busy machine."""
    return 1.0 if number == 3 else 60.0


def half_a_second(_: object) -> float:
    return 0.5


def square(number: int) -> int:
    return number * number


def die_once(folder: Path, number: int) -> int:
    """Killed at the first attempt at 3, as by the system when memory runs out."""
    mark = folder / "died"
    if number == 3 and not mark.exists():
        mark.write_text("")
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def die(number: int) -> int:
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def fail(number: int) -> int:
    raise OSError(28, f"no space for {number}")


def hang_once(folder: Path, number: int) -> int:
    mark = folder / "hung"
    if number == 3 and not mark.exists():
        mark.write_text("")
        time.sleep(600.0)
    return number


def hang(number: int) -> int:
    if number == 3:
        time.sleep(600.0)
    return number


def stand_still(number: int) -> int:
    """Stopped as a whole, its own watchdog too."""
    if number == 3:
        os.kill(os.getpid(), signal.SIGSTOP)
    return number


def threads(_: int) -> tuple[str | None, int]:
    import cv2

    return os.environ.get("OMP_NUM_THREADS"), cv2.getNumThreads()


def test_every_task_is_done_once() -> None:
    done = list(pool.run(square, range(20), workers=2, limit_s=minute))
    assert sorted((one.task, one.result) for one in done) == [(n, n * n) for n in range(20)]
    assert {one.attempts for one in done} == {1}


@POSIX_ONLY
def test_a_task_whose_worker_died_is_retried(tmp_path: Path) -> None:
    done = {one.task: one for one in pool.run(partial(die_once, tmp_path), range(6), workers=2, limit_s=minute)}
    assert {task: one.result for task, one in done.items()} == {n: n for n in range(6)}
    assert {task for task, one in done.items() if one.attempts == 2} == {3}


@POSIX_ONLY
def test_a_task_that_kills_its_worker_twice_is_given_up_and_no_other() -> None:
    done = {one.task: one for one in pool.run(die, range(6), workers=1, limit_s=minute)}
    assert {task: one.result for task, one in done.items()} == {0: 0, 1: 1, 2: 2, 3: None, 4: 4, 5: 5}
    assert done[3].reason == "lost its worker process (killed by SIGKILL), 2 times of 2\n"
    assert done[3].attempts == 2


def test_a_task_that_hangs_is_ended_and_retried(tmp_path: Path) -> None:
    done = {
        one.task: one for one in pool.run(partial(hang_once, tmp_path), range(6), workers=2, limit_s=short_for_three)
    }
    assert {task: one.result for task, one in done.items()} == {n: n for n in range(6)}
    assert done[3].attempts == 2


def test_a_task_that_hangs_twice_is_given_up_with_its_stack() -> None:
    done = {one.task: one for one in pool.run(hang, range(5), workers=1, limit_s=short_for_three)}
    assert {task: one.result for task, one in done.items()} == {0: 0, 1: 1, 2: 2, 3: None, 4: 4}
    assert done[3].reason.startswith("took longer than 1 s, 2 times of 2\nTimeout")
    assert "test_pool.py" in done[3].reason
    assert "in hang\n" in done[3].reason


@POSIX_ONLY
def test_a_worker_that_cannot_end_itself_is_killed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pool, "GRACE_S", 0.3)
    done = {one.task: one.result for one in pool.run(stand_still, range(5), workers=1, limit_s=short_for_three)}
    assert done == {0: 0, 1: 1, 2: 2, 3: None, 4: 4}


SLOW_START = """
import multiprocessing, time
if multiprocessing.parent_process():
    time.sleep(1.5)
def same(number): return number
"""


def test_a_slow_start_takes_no_time_of_the_task(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "slow_start.py").write_text(SLOW_START)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(pool, "GRACE_S", 0.5)
    work = importlib.import_module("slow_start").same
    done = list(pool.run(work, range(2), workers=1, limit_s=half_a_second))
    assert [(one.result, one.attempts) for one in done] == [(0, 1), (1, 1)]


def test_a_worker_that_never_starts_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pool, "GRACE_S", 0.0)
    monkeypatch.setattr(pool, "START_S", -1.0)
    (done,) = pool.run(square, [3], workers=1, limit_s=half_a_second)
    assert done.reason.startswith("took longer than 0.5 s, 2 times of 2")


def test_an_exception_of_a_worker_ends_all() -> None:
    with pytest.raises(OSError, match="no space for 0"):
        list(pool.run(fail, range(6), workers=1, limit_s=minute))


def test_workers_have_one_thread_and_the_parents_environment_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    assert [one.result for one in pool.run(threads, [0], workers=1, limit_s=minute)] == [("1", 1)]
    assert os.environ["OMP_NUM_THREADS"] == "7"


def test_no_logs_of_workers_are_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    logs = tmp_path / "logs"
    logs.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(logs))
    list(pool.run(partial(hang_once, tmp_path), range(4, 2, -1), workers=1, limit_s=short_for_three))
    started = pool.run(square, range(6), workers=2, limit_s=minute)
    next(started)
    started.close()
    assert list(logs.iterdir()) == []


class Interrupted:
    """A context in which Python starts one process, and is interrupted at the second."""

    def __init__(self, start: Callable[..., BaseProcess]) -> None:
        self._start, self.started = start, list[BaseProcess]()

    def __call__(self, **options: Any) -> BaseProcess:
        if self.started:
            raise KeyboardInterrupt
        self.started.append(self._start(**options))
        return self.started[0]


def test_an_interrupted_start_leaves_no_worker(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    process = Interrupted(pool.SPAWN.Process)
    monkeypatch.setattr(pool.SPAWN, "Process", process)
    with pytest.raises(KeyboardInterrupt) as caught:
        next(pool.run(square, range(6), workers=2, limit_s=minute))
    assert [one.is_alive() for one in process.started] == [False]
    assert list(tmp_path.iterdir()) == [], "logs"
    assert caught.value.__traceback__ is not None, "whose frames keep the workers, as in a notebook"


def test_no_tasks_need_no_workers() -> None:
    assert list(pool.run(square, [], workers=2, limit_s=minute)) == []
