"""One run at a time in a folder, on every operating system."""

from pathlib import Path

from filelock import FileLock, Timeout

from vpf_sim.errors import InputError

LOCK = ".lock"  # an empty file in the folder; it may stay, since removing it while others wait is a race


def locked(folder: Path) -> FileLock:
    """Lock the folder until `release` or the end of the process; InputError if another run holds it."""
    lock = FileLock(folder / LOCK)
    try:
        lock.acquire(blocking=False)
    except Timeout:
        raise InputError(f"{folder}: in use by another run") from None
    except NotImplementedError:
        raise InputError(f"{folder}: expected a file system with locks, got one without") from None
    return lock
