"""JSON lines that a crash cannot spoil: each is written by one call, and is on the disk before the next."""

import errno
import fcntl
import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from vpf_sim.errors import InputError
from vpf_sim.files import write_bytes


class JsonLines:
    """Append rows to a file, as the only one who does; opening it drops a last line that a crash left torn."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # the end of the process, whatever ends it, frees it
        except BlockingIOError:
            os.close(self._file)
            raise InputError(f"{path.parent}: in use by another run") from None
        stored = path.read_bytes()
        os.ftruncate(self._file, stored.rfind(b"\n") + 1)

    def append(self, row: dict[str, Any]) -> None:
        """One line, keys sorted; whole, or not there and OSError."""
        line = _line(row)
        size = os.fstat(self._file).st_size
        try:
            if os.write(self._file, line) != len(line):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            os.fsync(self._file)
        except OSError as error:
            os.ftruncate(self._file, size)
            raise OSError(error.errno, error.strerror, str(self._path)) from None

    def rewrite(self, rows: Iterable[dict[str, Any]]) -> None:
        """Put these rows in the place of all that are there, whole or not at all; nothing can be appended after it."""
        write_bytes(self._path, b"".join(map(_line, rows)))

    def close(self) -> None:
        os.close(self._file)


def read_lines(path: Path) -> list[dict[str, Any]]:
    """The rows of a file, none if it does not exist; a torn last line is left out, any other fault is told."""
    if not path.exists():
        return []
    whole, _, _ = path.read_bytes().rpartition(b"\n")
    return [_row(path, number, line) for number, line in enumerate(whole.splitlines(), start=1)]


def _line(row: dict[str, Any]) -> bytes:
    return json.dumps(row, sort_keys=True, allow_nan=False).encode() + b"\n"


def _row(path: Path, number: int, line: bytes) -> dict[str, Any]:
    try:
        row = json.loads(line)
    except (ValueError, RecursionError):
        row = None
    if not isinstance(row, dict):
        raise InputError(f"{path}: line {number}: expected a JSON object, got {line[:40]!r}")
    return row
