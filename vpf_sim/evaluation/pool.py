"""Worker processes with timeouts; a task whose worker died or hung is retried once."""

import faulthandler
import multiprocessing
import os
import signal
import sys
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from math import inf, isfinite
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from tempfile import mkstemp
from threading import Lock, Thread
from time import monotonic
from types import ModuleType
from typing import Any, Generic, TypeVar

from vpf_sim.errors import InputError, option
from vpf_sim.system import limit_opencv, limited_environment


@contextmanager
def at_most(limit_s: float, log: int) -> Iterator[None]:
    """A context that ends the process after `limit_s`; the stack at that time or at a crash is written to `log`.

    A process has one watchdog, so contexts must not nest or overlap.
    """
    faulthandler.enable(log)
    if isfinite(limit_s):
        faulthandler.dump_traceback_later(limit_s, exit=True, file=log)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()


Task = TypeVar("Task")
Result = TypeVar("Result")
Limit = Callable[[Task], float]  # s that a task may take
ATTEMPTS = 2
POLL_S = 600.0  # longest wait between two checks of the clock
GRACE_S = 30.0  # beyond the limit, until a worker that did not end itself is killed
START_S = 600.0  # for a worker to start: slow on a busy machine, and not the task's fault
LONGEST_LOG = 1 << 16  # bytes
SPAWN = multiprocessing.get_context("spawn")  # a fork would copy locks and OpenCV's state
DAEMONIC = "a process that may start no others, such as a worker of multiprocessing.Pool"
STARTING = Lock()  # while a process starts, the environment and the main module are exchanged


@dataclass(frozen=True, slots=True)
class Done(Generic[Task, Result]):
    """A finished task: its result, or None and the reason if the worker died or hung at each attempt."""

    task: Task
    result: Result | None
    attempts: int
    worker: int | str
    reason: str = ""


class _Started:
    """A worker's message that it started a task; the time limit counts from then."""


@dataclass(slots=True)
class _Worker(Generic[Task]):
    number: int
    process: BaseProcess
    connection: Connection
    crash_log: Path  # written by the watchdog before it ends the process
    task: Task | None = None
    attempt: int = 0
    limit_s: float = 0.0
    started_s: float = 0.0

    @property
    def remaining_s(self) -> float:
        """Time until the worker is killed."""
        return self.started_s + self.limit_s + GRACE_S - monotonic()


def may_start() -> bool:
    """Whether this process may start others: Python refuses it to daemonic ones."""
    return not multiprocessing.current_process().daemon


def check_workers(workers: int) -> None:
    """InputError for more workers than this process may have."""
    if workers > 1 and not may_start():
        raise InputError(f"{option('workers')}: expected 1 in {DAEMONIC}, got {workers}")


def here(work: Callable[[Task], Result], tasks: Iterable[Task]) -> Generator[Done[Task, Result], None, None]:
    """Yield the results of tasks that are done in this process, one after another, without a time limit."""
    for task in tasks:
        yield Done(task, work(task), attempts=1, worker=0)


def unlimited(_: object) -> float:
    """No time limit."""
    return inf


def run(
    work: Callable[[Task], Result], tasks: Iterable[Task], workers: int, limit_s: "Limit[Task]" = unlimited
) -> Generator[Done[Task, Result], None, None]:
    """Yield results as they are ready; closing the generator, or any exception, ends the workers.

    `work` must be importable by name. Its exceptions are raised here. In a process that may start no others, such as a
    worker of multiprocessing.Pool, the tasks are done in it, without a time limit.
    """
    check_workers(workers)
    if not may_start():
        yield from here(work, tasks)
        return
    waiting = deque((task, 1) for task in tasks)
    pool: list[_Worker[Task]] = []
    try:
        for number in range(min(workers, len(waiting))):
            pool.append(_start(number, work))  # noqa: PERF401 (if a later one fails, these are ended)
        while waiting or any(worker.task is not None for worker in pool):
            for worker in pool:
                if worker.task is None and waiting:
                    _send(worker, *waiting.popleft(), limit_s)
            for worker in _ready(pool):
                done = _receive(worker, waiting)
                if worker.task is None and not worker.process.is_alive():
                    worker.crash_log.unlink(missing_ok=True)
                    pool[pool.index(worker)] = _start(worker.number, work)
                if done is not None:
                    yield done
    finally:
        for worker in pool:
            worker.process.kill()
            worker.process.join()
            worker.crash_log.unlink(missing_ok=True)


def _start(number: int, work: Callable[[Task], Any]) -> "_Worker[Task]":
    ours, theirs = SPAWN.Pipe()
    descriptor, name = mkstemp(prefix="vpf_sim-worker-", suffix=".log")  # Windows inherits no descriptors
    os.close(descriptor)
    try:
        process = SPAWN.Process(target=_serve, args=(theirs, name, work), name=f"worker {number}", daemon=True)
        with STARTING, limited_environment(), _without_main():
            process.start()
    except BaseException:
        ours.close()  # ends a worker that has started
        Path(name).unlink(missing_ok=True)
        raise
    finally:
        theirs.close()  # so that the pipe ends when the worker dies
    return _Worker(number, process, ours, Path(name))


@contextmanager
def _without_main() -> Iterator[None]:
    """Hide the main module while a process starts, which would run a user's script again in each worker."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


def _send(worker: "_Worker[Task]", task: Task, attempt: int, limit_s: "Limit[Task]") -> None:
    """Send the task; a dead worker is noticed when its result is read."""
    worker.task, worker.attempt, worker.limit_s, worker.started_s = task, attempt, limit_s(task), monotonic() + START_S
    with suppress(BrokenPipeError, ConnectionResetError):
        worker.connection.send((task, worker.limit_s))


def _ready(pool: "list[_Worker[Task]]") -> "list[_Worker[Task]]":
    """Wait for workers that answered or died; kill those far beyond their limit."""
    busy = [worker for worker in pool if worker.task is not None]
    readable = wait(
        [worker.connection for worker in busy], timeout=max(0.0, min(POLL_S, *(worker.remaining_s for worker in busy)))
    )
    for worker in busy:
        if worker.remaining_s <= 0.0:
            worker.process.kill()
    return [worker for worker in busy if worker.connection in readable]


def _receive(worker: "_Worker[Task]", waiting: "deque[tuple[Task, int]]") -> "Done[Task, Any] | None":
    """The finished task; None if the worker just started it, or died and the task is retried."""
    task, attempt = worker.task, worker.attempt
    assert task is not None
    try:
        result = worker.connection.recv()
        if isinstance(result, _Started):
            worker.started_s = monotonic()
            return None
        worker.task = None
    except (EOFError, ConnectionResetError):
        worker.task = None
        worker.process.join()
        if attempt < ATTEMPTS:
            waiting.appendleft((task, attempt + 1))
            return None
        return Done(task, None, attempt, worker.number, _reason(worker))
    if isinstance(result, BaseException):
        raise result
    return Done(task, result, attempt, worker.number)


def _reason(worker: "_Worker[Task]") -> str:
    """Why a worker died, with its stack if the watchdog wrote one."""
    code = worker.process.exitcode or 0
    death = f"killed by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
    stack = worker.crash_log.read_bytes()[:LONGEST_LOG].decode(errors="replace")
    late = monotonic() - worker.started_s >= worker.limit_s or stack.startswith("Timeout")  # the watchdog's word
    what = f"took longer than {worker.limit_s:g} s" if late else f"lost its worker process ({death})"
    return f"{what}, {worker.attempt} times of {ATTEMPTS}\n{stack}"


def _serve(connection: Connection, log_file: str, work: Callable[[Any], Any]) -> None:
    """A worker's main loop; it ignores Ctrl-C and ends with its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.stdout = sys.stderr  # a driver's prints must not mix with the parent's output
    Thread(target=_end_with_parent, args=(log_file,), daemon=True).start()
    log = os.open(log_file, os.O_WRONLY | os.O_APPEND)
    limit_opencv()
    while True:
        try:
            task, limit_s = connection.recv()
        except EOFError:
            return
        connection.send(_Started())
        try:
            with at_most(limit_s, log):
                result = work(task)
        except Exception as error:
            result = error
        connection.send(result)


def _end_with_parent(log_file: str) -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
    with suppress(OSError):  # Windows removes no open file
        os.unlink(log_file)
    os._exit(1)
