"""Worker processes that may die: what a dead one was doing is tried once more, and then given up."""

import multiprocessing
import os
import signal
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from threading import Thread
from typing import Any, Generic, TypeVar

from vpf_sim.evaluation.threads import limit_opencv, limited_environment

Task = TypeVar("Task")
Result = TypeVar("Result")
ATTEMPTS = 2
SPAWN = multiprocessing.get_context("spawn")  # a fork would copy the parent's threads' locks and OpenCV's state


@dataclass(frozen=True, slots=True)
class Done(Generic[Task, Result]):
    """A task that ended: its result, or None where the worker died at each attempt."""

    task: Task
    result: Result | None
    attempts: int
    worker: int


@dataclass(slots=True)
class _Worker(Generic[Task]):
    number: int
    process: BaseProcess
    connection: Connection
    task: Task | None = None
    attempt: int = 0


def run(work: Callable[[Task], Result], tasks: Iterable[Task], workers: int) -> Iterator[Done[Task, Result]]:
    """Results in the order in which they are ready. Leaving early, or any exception, ends the workers.

    `work` must be importable by name. What it raises is raised here and ends all.
    """
    waiting = deque((task, 1) for task in tasks)
    team: list[_Worker[Task]] = [_start(number, work) for number in range(min(workers, len(waiting)))]
    try:
        while waiting or any(worker.task is not None for worker in team):
            for worker in team:
                if worker.task is None and waiting:
                    worker.task, worker.attempt = waiting.popleft()
                    _send(worker)
            for connection in wait([worker.connection for worker in team if worker.task is not None]):
                worker = next(worker for worker in team if worker.connection is connection)
                done = _receive(worker, waiting)
                if not worker.process.is_alive():
                    team[team.index(worker)] = _start(worker.number, work)
                if done is not None:
                    yield done
    finally:
        for worker in team:
            worker.process.kill()
            worker.process.join()


def _start(number: int, work: Callable[[Task], Any]) -> "_Worker[Task]":
    ours, theirs = SPAWN.Pipe()
    process = SPAWN.Process(target=_serve, args=(theirs, work), name=f"worker {number}", daemon=True)
    with limited_environment():
        process.start()
    theirs.close()  # so that the death of the worker is the end of the pipe
    return _Worker(number, process, ours)


def _send(worker: "_Worker[Task]") -> None:
    """Hand out the task; a worker that died meanwhile is noticed when its answer is read."""
    try:
        worker.connection.send(worker.task)
    except (BrokenPipeError, ConnectionResetError):
        return


def _receive(worker: "_Worker[Task]", waiting: "deque[tuple[Task, int]]") -> "Done[Task, Any] | None":
    """What the worker answers; None if it died and its task waits for another attempt."""
    task, attempt = worker.task, worker.attempt
    assert task is not None
    worker.task = None
    try:
        answer = worker.connection.recv()
    except (EOFError, ConnectionResetError):
        worker.process.join()
        if attempt < ATTEMPTS:
            waiting.appendleft((task, attempt + 1))
            return None
        answer = None
    if isinstance(answer, BaseException):
        raise answer
    return Done(task, answer, attempt, worker.number)


def _serve(connection: Connection, work: Callable[[Any], Any]) -> None:
    """The life of a worker: Ctrl-C is the parent's business, and the worker ends with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.stdout = sys.stderr  # what a driver prints must not get into the parent's answer
    Thread(target=_end_with_parent, daemon=True).start()
    limit_opencv()
    while True:
        try:
            task = connection.recv()
        except EOFError:
            return
        try:
            connection.send(work(task))
        except Exception as error:
            connection.send(error)


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
    os._exit(1)
