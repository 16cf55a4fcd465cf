"""Worker processes that may die or hang: what such a one was doing is tried once more, and then given up."""

import multiprocessing
import os
import signal
import sys
from collections import deque
from collections.abc import Callable, Generator, Iterable
from contextlib import suppress
from dataclasses import dataclass
from math import inf
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from threading import Thread
from time import monotonic
from typing import Any, Generic, TypeVar

from vpf_sim.evaluation.processes import watchdog
from vpf_sim.evaluation.processes.threads import limit_opencv, limited_environment

Task = TypeVar("Task")
Result = TypeVar("Result")
Limit = Callable[[Task], float]  # s that a task may take
ATTEMPTS = 2
LOOK_S = 600.0  # at the longest between two looks at the clock
GRACE_S = 30.0  # beyond its limit until a worker that did not end itself is killed
START_S = 600.0  # for a worker to take up its first task: starting is slow on a busy machine, and no fault of the task
SPAWN = multiprocessing.get_context("spawn")  # a fork would copy the parent's threads' locks and OpenCV's state


@dataclass(frozen=True, slots=True)
class Done(Generic[Task, Result]):
    """A task that ended: its result, or None and the reason where the worker died or hung at each attempt."""

    task: Task
    result: Result | None
    attempts: int
    worker: int | str
    reason: str = ""


class _Begun:
    """What a worker says when it takes up a task: its time runs from then on."""


@dataclass(slots=True)
class _Worker(Generic[Task]):
    number: int
    process: BaseProcess
    connection: Connection
    last_words: Connection  # what its watchdog writes before it ends the process
    task: Task | None = None
    attempt: int = 0
    limit_s: float = 0.0
    begun_s: float = 0.0

    @property
    def hurry_s(self) -> float:
        """Until it is to be killed."""
        return self.begun_s + self.limit_s + GRACE_S - monotonic()


def unlimited(_: object) -> float:
    """Takes what it takes."""
    return inf


def run(
    work: Callable[[Task], Result], tasks: Iterable[Task], workers: int, limit_s: "Limit[Task]" = unlimited
) -> Generator[Done[Task, Result], None, None]:
    """Results in the order in which they are ready. Leaving early, or any exception, ends the workers.

    `work` must be importable by name. What it raises is raised here and ends all.
    """
    waiting = deque((task, 1) for task in tasks)
    team: list[_Worker[Task]] = [_start(number, work) for number in range(min(workers, len(waiting)))]
    try:
        while waiting or any(worker.task is not None for worker in team):
            for worker in team:
                if worker.task is None and waiting:
                    _send(worker, *waiting.popleft(), limit_s)
            for worker in _ready(team):
                done = _receive(worker, waiting)
                if worker.task is None and not worker.process.is_alive():
                    team[team.index(worker)] = _start(worker.number, work)
                if done is not None:
                    yield done
    finally:
        for worker in team:
            worker.process.kill()
            worker.process.join()


def _start(number: int, work: Callable[[Task], Any]) -> "_Worker[Task]":
    ours, theirs = SPAWN.Pipe()
    last_words, log = SPAWN.Pipe(duplex=False)
    process = SPAWN.Process(target=_serve, args=(theirs, log, work), name=f"worker {number}", daemon=True)
    with limited_environment():
        process.start()
    theirs.close()  # so that the death of the worker is the end of the pipe
    log.close()
    return _Worker(number, process, ours, last_words)


def _send(worker: "_Worker[Task]", task: Task, attempt: int, limit_s: "Limit[Task]") -> None:
    """Hand out the task; a worker that died meanwhile is noticed when its answer is read."""
    worker.task, worker.attempt, worker.limit_s, worker.begun_s = task, attempt, limit_s(task), monotonic() + START_S
    with suppress(BrokenPipeError, ConnectionResetError):
        worker.connection.send((task, worker.limit_s))


def _ready(team: "list[_Worker[Task]]") -> "list[_Worker[Task]]":
    """Those who answer or have died, as soon as there is one; who is far beyond the limit is killed."""
    busy = [worker for worker in team if worker.task is not None]
    heard = wait(
        [worker.connection for worker in busy], timeout=max(0.0, min(LOOK_S, *(worker.hurry_s for worker in busy)))
    )
    for worker in busy:
        if worker.hurry_s <= 0.0:
            worker.process.kill()
    return [worker for worker in busy if worker.connection in heard]


def _receive(worker: "_Worker[Task]", waiting: "deque[tuple[Task, int]]") -> "Done[Task, Any] | None":
    """What the worker answers; None if it has just begun, or died and its task waits for another attempt."""
    task, attempt = worker.task, worker.attempt
    assert task is not None
    try:
        answer = worker.connection.recv()
        if isinstance(answer, _Begun):
            worker.begun_s = monotonic()
            return None
        worker.task = None
    except (EOFError, ConnectionResetError):
        worker.task = None
        worker.process.join()
        if attempt < ATTEMPTS:
            waiting.appendleft((task, attempt + 1))
            return None
        return Done(task, None, attempt, worker.number, _reason(worker))
    if isinstance(answer, BaseException):
        raise answer
    return Done(task, answer, attempt, worker.number)


def _reason(worker: "_Worker[Task]") -> str:
    """Why a worker is dead, and where in the code it was, if it could say so."""
    code = worker.process.exitcode or 0
    death = f"killed by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
    late = monotonic() - worker.begun_s >= worker.limit_s
    what = f"took longer than {worker.limit_s:g} s" if late else f"lost its worker process ({death})"
    os.set_blocking(worker.last_words.fileno(), False)  # a child of the worker may hold the other end
    stack = ""
    with suppress(OSError):
        stack = os.read(worker.last_words.fileno(), 1 << 16).decode(errors="replace")
    return f"{what}, {worker.attempt} times of {ATTEMPTS}\n{stack}"


def _serve(connection: Connection, log: Connection, work: Callable[[Any], Any]) -> None:
    """The life of a worker: Ctrl-C is the parent's business, and the worker ends with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.stdout = sys.stderr  # what a driver prints must not get into the parent's answer
    Thread(target=_end_with_parent, daemon=True).start()
    limit_opencv()
    while True:
        try:
            task, limit_s = connection.recv()
        except EOFError:
            return
        connection.send(_Begun())
        try:
            with watchdog.at_most(limit_s, log.fileno()):
                answer = work(task)
        except Exception as error:
            answer = error
        connection.send(answer)


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
    os._exit(1)
