"""Worker processes that die, fail, or are left."""

import os
import signal
from functools import partial
from pathlib import Path

import pytest

from vpf_sim.evaluation import pool


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


def threads(_: int) -> tuple[str | None, int]:
    import cv2

    return os.environ.get("OMP_NUM_THREADS"), cv2.getNumThreads()


def test_every_task_is_done_once() -> None:
    done = list(pool.run(square, range(20), workers=2))
    assert sorted((one.task, one.result) for one in done) == [(n, n * n) for n in range(20)]
    assert {one.attempts for one in done} == {1}


def test_a_task_whose_worker_died_is_done_again(tmp_path: Path) -> None:
    done = {one.task: one for one in pool.run(partial(die_once, tmp_path), range(6), workers=2)}
    assert {task: one.result for task, one in done.items()} == {n: n for n in range(6)}
    assert {task for task, one in done.items() if one.attempts == 2} == {3}


def test_a_task_that_kills_its_worker_twice_is_given_up_and_no_other() -> None:
    done = {one.task: one.result for one in pool.run(die, range(6), workers=1)}
    assert done == {0: 0, 1: 1, 2: 2, 3: None, 4: 4, 5: 5}


def test_what_a_worker_raises_ends_all() -> None:
    with pytest.raises(OSError, match="no space for 0"):
        list(pool.run(fail, range(6), workers=1))


def test_workers_have_one_thread_and_the_parents_environment_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    assert [one.result for one in pool.run(threads, [0], workers=1)] == [("1", 1)]
    assert os.environ["OMP_NUM_THREADS"] == "7"


def test_no_tasks_need_no_workers() -> None:
    assert list(pool.run(square, [], workers=2)) == []
