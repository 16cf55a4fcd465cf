"""A sweep on a Dask cluster: workers drive, and this process stores their records and steps as they arrive.

Workers need the same vpf_sim and one thread each; a shared disk is only needed for a user's scenario and weather files.
"""

import socket
import sys
from collections.abc import Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from importlib.util import find_spec
from logging import CRITICAL, getLogger, root
from queue import Empty, SimpleQueue
from threading import Thread
from typing import Any
from urllib.parse import urlsplit
from uuid import uuid4

from vpf_sim.errors import InputError, option
from vpf_sim.evaluation import pool, steps
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.pool import ATTEMPTS, Done
from vpf_sim.evaluation.sweeps import sweep
from vpf_sim.evaluation.sweeps.fingerprint import digest, fingerprint
from vpf_sim.evaluation.sweeps.manifest import Manifest, change
from vpf_sim.evaluation.sweeps.plan import Plan
from vpf_sim.evaluation.sweeps.run_folder import RunFolder
from vpf_sim.system import limit_opencv

MISSING = "expected Dask, which is not installed: pip install 'vpf_sim[cluster]'"
LOGGING = ("distributed", "asyncio", "tornado")
CONNECT_S = 4.0  # timeout for a scheduler, short so that a wrong address fails soon


def run(client: Any, folder: RunFolder, jobs: Iterable[Job], limit_s: sweep.Limit, mixed: bool) -> sweep.Results:
    """Yield results as they are ready; an episode whose worker died is submitted once more."""
    distributed = _distributed()
    requested = folder.requested
    ready, running = distributed.as_completed(loop=client.loop), {}
    session = uuid4().hex  # a scheduler returns its cached result for a known key

    def submit(job: Job, attempt: int) -> None:
        name = f"{job.id} attempt {attempt} {digest(requested.as_json())} {session}"
        future = client.submit(_drive, job, requested, limit_s(job), mixed, key=name, pure=False)
        running[future.key] = (job, attempt)
        ready.add(future)

    for job in jobs:
        submit(job, 1)
    for future in ready if running else ():
        job, attempt = running.pop(future.key)
        try:
            stored, table, worker = _result(future)
        except distributed.scheduler.KilledWorker as error:
            if attempt == ATTEMPTS:
                yield Done(job, None, attempt, error.last_worker.address, _reason(error, limit_s(job)))
            else:
                submit(job, attempt + 1)
            continue
        if table is not None:
            steps.write(table, folder.path / "steps" / f"{job.id}.parquet")
        yield Done(job, stored, attempt, worker)


@contextmanager
def connected(address: str | None, requested: Manifest, mixed: bool) -> Iterator[Any]:
    """A client of the scheduler at `address` once it has compatible workers; None without an address."""
    if address is None:
        yield None
        return
    client = _client(address)
    with client:
        if not client.nthreads():
            print(f"waiting for the first worker of {address}", file=sys.stderr, flush=True)
            client.wait_for_workers(1)
        _check_workers(client, requested, mixed)
        yield client


def _client(address: str) -> Any:
    """A client of the scheduler; InputError with one line where there is none."""
    if not _is_installed():
        raise _fault(MISSING)
    fault = _unreachable(address)
    if fault is None:
        distributed = _distributed()  # sets log levels when it is imported
        for name in [name for name in root.manager.loggerDict if name.partition(".")[0] in LOGGING]:
            getLogger(name).setLevel(CRITICAL)  # an InputError replaces their tracebacks
        try:
            return distributed.Client(address, timeout=CONNECT_S, name="vpf-sim", set_as_default=False)
        except (OSError, ValueError) as error:
            fault = " ".join(str(error).split()) or type(error).__name__
    raise _fault(f"expected a Dask scheduler at {address}, got: {fault}")


def _unreachable(address: str) -> str | None:
    """Why the host and port of an address do not answer; None if they do, or the address has none.

    Dask itself would retry, and wait for name lookups without a limit.
    """
    try:
        parts = urlsplit(address if "://" in address else f"tcp://{address}")
        if parts.scheme not in ("tcp", "tls"):
            return None if parts.scheme in ("ws", "wss", "inproc", "ucx", "ucxx") else "an unknown kind of address"
        host, port = parts.hostname, parts.port
    except ValueError as error:  # a port that is not a number
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

    Thread(target=connect, daemon=True).start()  # a daemon: a pending name lookup does not keep the process alive
    try:
        return outcome.get(timeout=CONNECT_S)
    except Empty:
        return f"no answer in {CONNECT_S:g} s"


def _fault(what: str) -> InputError:
    return InputError(f"{option('cluster')}: {what}")


def _is_installed() -> bool:
    """Whether Dask is installed, without importing it, which takes seconds."""
    try:
        return find_spec("distributed") is not None
    except ValueError:  # it is marked as missing
        return False


def _distributed() -> Any:
    try:
        import distributed
    except ImportError:
        raise _fault(MISSING) from None
    return distributed


def _check_workers(client: Any, requested: Manifest, mixed: bool) -> None:
    """InputError for a worker that would make different records; later workers check themselves."""
    for worker, threads in client.nthreads().items():
        if threads != 1:
            raise _fault(f"worker {worker}: expected one thread (--nthreads 1), got {threads}")
    for worker, found in client.run(fingerprint, on_error="return").items():
        if isinstance(found, BaseException):
            raise _fault(f"worker {worker}: expected vpf_sim as it is here, got: {found}")
        if not mixed:
            _compare(worker, found, requested)


def _compare(worker: str, found: dict[str, str], requested: Manifest) -> None:
    if found != requested.fingerprint:
        what = change(requested.fingerprint, found)
        raise _fault(f"worker {worker}: another fingerprint: {what}; {option('mixed')} accepts it")


def _result(future: Any) -> Any:
    """The worker's return value; raises its exception."""
    try:
        return future.result()
    except (CancelledError, OSError) as error:
        raise _fault(f"lost the scheduler ({type(error).__name__})") from None
    finally:
        future.release()


def _reason(error: Any, limit_s: float) -> str:
    return (
        f"lost its worker process or took longer than {limit_s:g} s, {ATTEMPTS} times of {ATTEMPTS}; "
        f"the log of the worker {error.last_worker.address} has more\n"
    )


def _drive(
    job: Job, requested: Manifest, limit_s: float, mixed: bool
) -> tuple[sweep.Stored, steps.StepTable | None, str]:
    """Run on a worker: check fingerprint and inputs, then drive one episode."""
    worker = str(_distributed().get_worker().name)
    own = fingerprint()
    if not mixed:
        _compare(worker, own, requested)
    _check_inputs(worker, job, requested)
    limit_opencv()
    with pool.at_most(limit_s, 2):
        stored, table = sweep.drive(None if own == requested.fingerprint else digest(own), job)
    return stored, table, worker


def _check_inputs(worker: str, job: Job, requested: Manifest) -> None:
    """InputError where this worker has another scenario, weather or driver under the same name."""
    for kind, hashes in Plan.of(job).check().items():
        for name, value in hashes.items():
            if requested.hashes(kind).get(name) != value:
                raise _fault(f"worker {worker}: {name}: expected the file as it is here, got another")
