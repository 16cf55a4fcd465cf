"""A sweep on a Dask cluster: its workers drive; records and steps come back as they are ready, and are stored here.

Workers need vpf_sim as it is here, and one thread each; of a common disk only a user's scenario and weather files.
"""

import socket
import sys
from collections.abc import Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from importlib.util import find_spec
from logging import CRITICAL, getLogger
from queue import Empty, SimpleQueue
from threading import Thread
from typing import Any
from urllib.parse import urlsplit
from uuid import uuid4

from vpf_sim.errors import InputError
from vpf_sim.evaluation import steps
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.processes import watchdog
from vpf_sim.evaluation.processes.pool import ATTEMPTS, Done
from vpf_sim.evaluation.processes.threads import limit_opencv
from vpf_sim.evaluation.sweeps import sweep
from vpf_sim.evaluation.sweeps.fingerprint import digest, fingerprint
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.evaluation.sweeps.run_folder import RunFolder, change, read_manifest

MISSING = "--cluster: expected Dask, which is not installed: pip install 'vpf_sim[cluster]'"
CONNECT_S = 4.0  # to reach a scheduler: a name or a port that is none is told soon
Asked = dict[str, Any]  # the manifest


def run(client: Any, folder: RunFolder, jobs: Iterable[Job], limit_s: sweep.Limit, mixed: bool) -> sweep.Results:
    """Results in the order in which they are ready. An episode whose workers died is submitted once more."""
    distributed = _distributed()
    asked = read_manifest(folder.path)
    ready, running = distributed.as_completed(loop=client.loop), {}
    session = uuid4().hex  # a scheduler answers a key that it has seen with what it found then

    def submit(job: Job, attempt: int) -> None:
        name = f"{job.id} attempt {attempt} {digest(asked)} {session}"
        future = client.submit(_drive, job, asked, limit_s(job), mixed, key=name, pure=False)
        running[future.key] = (job, attempt)
        ready.add(future)

    for job in jobs:
        submit(job, 1)
    for future in ready if running else ():
        job, attempt = running.pop(future.key)
        try:
            record, timing, table = _result(future)
        except distributed.scheduler.KilledWorker as error:
            if attempt == ATTEMPTS:
                yield Done(job, None, attempt, error.last_worker.address, _reason(error, limit_s(job)))
            else:
                submit(job, attempt + 1)
            continue
        if table is not None:
            steps.write(table, folder.path / "steps" / f"{job.id}.parquet")
        yield Done(job, (record, timing), attempt, timing.pop("worker"))


@contextmanager
def connected(address: str | None, asked: Asked, mixed: bool) -> Iterator[Any]:
    """A client of the scheduler at `address`, when it has a worker and none that is another; None without address."""
    if address is None:
        yield None
        return
    client = _client(address)
    with client:
        if not client.nthreads():
            print(f"waiting for the first worker of {address}", file=sys.stderr, flush=True)
            client.wait_for_workers(1)
        _refuse_others(client, asked, mixed)
        yield client


def _client(address: str) -> Any:
    """A client of the scheduler; InputError, soon and in one line, where there is none."""
    if not _is_installed():
        raise InputError(MISSING)
    fault = _unreachable(address)
    if fault is None:
        for name in ("distributed", "asyncio", "tornado.application"):
            getLogger(name).setLevel(CRITICAL)  # what goes wrong is told below, without their tracebacks
        try:
            return _distributed().Client(address, timeout=CONNECT_S, name="vpf-sim", set_as_default=False)
        except (OSError, ValueError) as error:
            fault = " ".join(str(error).split()) or type(error).__name__
    raise InputError(f"--cluster: expected a Dask scheduler at {address}, got: {fault}")


def _unreachable(address: str) -> str | None:
    """Why nothing answers at the host and port of an address; None if something does, or it names no such place.

    Dask itself would try again and again, and look up names for as long as that takes.
    """
    try:
        place = urlsplit(address if "://" in address else f"tcp://{address}")
        if place.scheme not in ("tcp", "tls"):
            return None if place.scheme in ("ws", "wss", "inproc", "ucx", "ucxx") else "an address of no known kind"
        host, port = place.hostname, place.port
    except ValueError as error:  # a port that is no number
        return str(error)
    if not host or port is None:
        return "no HOST:PORT"
    outcome: SimpleQueue[str | None] = SimpleQueue()

    def connect() -> None:
        try:
            socket.create_connection((host, port), CONNECT_S).close()
            outcome.put(None)
        except OSError as error:
            outcome.put(error.strerror or str(error))

    Thread(target=connect, daemon=True).start()  # which ends with us while a name is still looked up
    try:
        return outcome.get(timeout=CONNECT_S)
    except Empty:
        return f"no answer in {CONNECT_S:g} s"


def _is_installed() -> bool:
    """Whether there is Dask, which takes seconds to load."""
    try:
        return find_spec("distributed") is not None
    except ValueError:  # it is marked as missing
        return False


def _distributed() -> Any:
    try:
        import distributed
    except ImportError:
        raise InputError(MISSING) from None
    return distributed


def _refuse_others(client: Any, asked: Asked, mixed: bool) -> None:
    """InputError for a worker that would make other records. Those that come later refuse by themselves."""
    for worker, threads in client.nthreads().items():
        if threads != 1:
            raise InputError(f"--cluster: worker {worker}: expected one thread (--nthreads 1), got {threads}")
    for worker, found in client.run(fingerprint, on_error="return").items():
        if isinstance(found, BaseException):
            raise InputError(f"--cluster: worker {worker}: expected vpf_sim as it is here, got: {found}")
        if not mixed:
            _compare(worker, found, asked)


def _compare(worker: str, found: dict[str, str], asked: Asked) -> None:
    if found != asked["fingerprint"]:
        what = change(asked["fingerprint"], found)
        raise InputError(f"--cluster: worker {worker}: another fingerprint: {what}; --mixed accepts it")


def _result(future: Any) -> Any:
    """What the worker returned or raised."""
    try:
        return future.result()
    except (CancelledError, OSError) as error:
        raise InputError(f"--cluster: lost the scheduler ({type(error).__name__})") from None
    finally:
        future.release()


def _reason(error: Any, limit_s: float) -> str:
    return (
        f"lost its worker process or took longer than {limit_s:g} s, {ATTEMPTS} times of {ATTEMPTS}; "
        f"the log of the worker {error.last_worker.address} has more\n"
    )


def _drive(
    job: Job, asked: Asked, limit_s: float, mixed: bool
) -> tuple[dict[str, Any], dict[str, Any], steps.StepTable | None]:
    """On a worker: drive one episode, if that makes the record that is wanted."""
    worker = str(_distributed().get_worker().name)
    own = fingerprint()
    if not mixed:
        _compare(worker, own, asked)
    _check_inputs(worker, job, asked)
    limit_opencv()
    with watchdog.at_most(limit_s, 2):
        record, timing, table = sweep.drive(None if own == asked["fingerprint"] else digest(own), job)
    return record, {**timing, "worker": worker}, table


def _check_inputs(worker: str, job: Job, asked: Asked) -> None:
    """InputError where the scenario, weather or driver of that name says something else to this worker."""
    for kind, hashes in Plan.of(job).check().items():
        for name, value in hashes.items():
            if asked.get(kind, {}).get(name) != value:
                raise InputError(f"--cluster: worker {worker}: {name}: expected the file as it is here, got another")
