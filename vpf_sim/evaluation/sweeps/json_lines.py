"""Crash-safe JSON lines: each line is one write, synced to disk before the next."""

import errno
import json
import os
from collections.abc import Iterable
from pathlib import Path

from vpf_sim.errors import InputError
from vpf_sim.evaluation.scores import Json
from vpf_sim.files import write_bytes

FLAGS = os.O_RDWR | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0)  # Windows would write "\r\n"


class JsonLines:
    """Appends rows to a file; opening it drops an incomplete last line. The caller locks the file's folder."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file = os.open(path, FLAGS, 0o644)
        self._is_open = True
        stored = path.read_bytes()
        os.ftruncate(self._file, stored.rfind(b"\n") + 1)

    def append(self, row: Json) -> None:
        """Append one line with sorted keys; on OSError nothing is appended."""
        line = _line(row)
        size = os.fstat(self._file).st_size
        try:
            if os.write(self._file, line) != len(line):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            os.fsync(self._file)
        except OSError as error:
            os.ftruncate(self._file, size)
            raise OSError(error.errno, error.strerror, str(self._path)) from None

    def rewrite(self, rows: Iterable[Json]) -> None:
        """Replace all rows atomically; no row can be appended afterwards."""
        self.close()  # Windows does not replace an open file
        write_bytes(self._path, b"".join(map(_line, rows)))

    def close(self) -> None:
        """Close the file; a second call has no effect."""
        if self._is_open:
            self._is_open = False
            os.close(self._file)


def read_lines(path: Path) -> list[Json]:
    """The rows of a file, empty if it is missing; an incomplete last line is dropped, other faults are InputErrors."""
    if not path.exists():
        return []
    whole, _, _ = path.read_bytes().rpartition(b"\n")
    return [_row(path, number, line) for number, line in enumerate(whole.splitlines(), start=1)]


def _line(row: Json) -> bytes:
    return json.dumps(row, sort_keys=True, allow_nan=False).encode() + b"\n"


def _row(path: Path, number: int, line: bytes) -> Json:
    try:
        row = json.loads(line)
    except (ValueError, RecursionError):
        row = None
    if not isinstance(row, dict):
        raise InputError(f"{path}: line {number}: expected a JSON object, got {line[:40]!r}")
    return row
