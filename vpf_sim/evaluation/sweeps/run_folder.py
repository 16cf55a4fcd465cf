"""The run folder: manifest, records, timing and steps; a run can be resumed after any crash."""

import errno
import json
import os
import shutil
from collections.abc import Iterable, Mapping
from contextlib import ExitStack, closing, suppress
from datetime import datetime
from pathlib import Path

from filelock import FileLock, Timeout
from pydantic_core import from_json

from vpf_sim import system
from vpf_sim.errors import InputError, option
from vpf_sim.evaluation.metrics.records import Record, Timing, checked, read_record
from vpf_sim.evaluation.run_inputs import INPUTS, RunInputs, contents
from vpf_sim.evaluation.score_keys import Json
from vpf_sim.evaluation.sweeps.fingerprint import digest
from vpf_sim.evaluation.sweeps.manifest import HASHED, MANIFEST, Manifest, change, read_manifest
from vpf_sim.files import DRAFT, write_bytes, write_text

LINES = ("episodes.jsonl", "timing.jsonl")
OUTPUTS = ("steps", "errors")  # folders
LATEST = "latest"  # in the place of a folder's name
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
        row = from_json(line, allow_inf_nan=True)  # twice as fast as json.loads
    except ValueError:
        row = None
    if not isinstance(row, dict):
        raise InputError(f"{path}: line {number}: expected a JSON object, got {line[:40]!r}")
    return row


def new_path(command: str) -> Path:
    """Create a folder under runs/, named by time and command."""
    stem = f"runs/{datetime.now():%Y%m%d-%H%M%S}-{command}"
    for name in [stem, *(f"{stem}-{number}" for number in range(2, 1000))]:
        try:
            os.makedirs(name)
        except FileExistsError:
            continue
        return Path(name)
    raise InputError(f"{stem}: expected a free name for a run folder, found none")


def located(path: Path) -> Path:
    """The folder that a user names: `runs/latest` is the run in runs/ that began last.

    A path without such a run is returned as it is, and refused by its reader.
    """
    if path.name != LATEST or path.exists():
        return path
    files = [file for file in path.parent.glob(f"*/{MANIFEST}") if (file.parent / LINES[0]).exists()]
    return max(files, key=_begun, default=path / MANIFEST).parent


def _begun(manifest: Path) -> tuple[float, int]:
    """When a run began by its manifest, s, then the time of the file, which orders runs of earlier versions.

    They stored the day alone, or nothing. A run whose folder has been removed meanwhile comes before all others.
    """
    try:
        written_ns = manifest.stat().st_mtime_ns
        return datetime.fromisoformat(json.loads(manifest.read_text("utf-8"))["begun"]).timestamp(), written_ns
    except OSError:
        return -2.0, 0
    except (ValueError, KeyError, TypeError, RecursionError, OverflowError):
        return -1.0, written_ns


class RunFolder:
    """An open, locked run folder; `done` has the ids of its records."""

    def __init__(self, path: Path, requested: Manifest, resume: bool = False, mixed: bool = False) -> None:
        self.path = path
        self.requested = requested
        admitted(path, requested, resume, mixed)  # before anything is written
        path.mkdir(parents=True, exist_ok=True)
        with ExitStack() as opened:
            self._lock = locked(path)
            opened.callback(self._lock.release)
            new, self.mark = admitted(path, requested, resume, mixed)  # another run may have begun in it until now
            self._lines = [opened.enter_context(closing(JsonLines(path / name))) for name in LINES]
            if new:
                self._keep_inputs()
                self.write_json(MANIFEST, requested.as_json())
            self.done = {record.id for record in self.records()}
            opened.pop_all()

    def add(self, record: Record, timing: Timing, traceback: str | None = None) -> None:
        """Store a finished episode; the traceback of an error is written to its own file."""
        if traceback is not None:
            write_text(self.error_file(record.id), traceback.rstrip() + "\n")
        records, timings = self._lines
        timings.append(timing.as_json())
        records.append(record.as_json())
        self.done.add(record.id)

    def replace_records(self, records: Iterable[Record]) -> None:
        """Replace all records; none can be added afterwards."""
        self._lines[0].rewrite(record.as_json() for record in records)

    def error_file(self, episode: str) -> Path:
        """The file with the reason of an `error`."""
        return self.path / "errors" / f"{episode}.txt"

    def records(self) -> list[Record]:
        """All records, sorted by id."""
        return read_records(self.path)

    def write_json(self, name: str, value: Mapping[str, object]) -> None:
        """Write a JSON file of the folder with sorted keys, atomically."""
        write_json(self.path / name, value)

    def close(self) -> None:
        for lines in self._lines:
            lines.close()
        self._lock.release()

    def discard(self, keep_folder: bool = False) -> None:
        """Remove what a new run wrote, and its folder unless it has other files."""
        for lines in self._lines:
            lines.close()
        with closing(self), suppress(OSError):
            for name in OUTPUTS:
                shutil.rmtree(self.path / name, ignore_errors=True)
            for name in (MANIFEST, INPUTS, *LINES):
                (self.path / name).unlink(missing_ok=True)
            if system.WINDOWS:  # which removes no open file, hence none that another run has locked
                self._lock.release()
            (self.path / LOCK).unlink(missing_ok=True)
            if not keep_folder:
                self.path.rmdir()

    def _keep_inputs(self) -> None:
        """Write what the plan's own files say, if it has any."""
        kept = contents(self.requested.names("scenario"), self.requested.names("weather"))
        if any(kept.values()):
            self.write_json(INPUTS, kept)


def admitted(path: Path, requested: Manifest, resume: bool, mixed: bool) -> tuple[bool, str | None]:
    """Whether the run of a folder is a new one, and the mark of its records if the fingerprint is another.

    InputError where the folder cannot take the run. Nothing is written.
    """
    if not resume or not (path / MANIFEST).exists():
        _check_new(path)
        return True, None
    return False, digest(requested.fingerprint) if _has_other_fingerprint(path, requested, mixed) else None


def check_name(path: Path) -> None:
    """InputError for a new folder that would hide the run that `runs/latest` stands for."""
    if path.name == LATEST:
        raise InputError(f"{path}: expected another name: this one stands for the run that began last")


def _check_new(path: Path) -> None:
    check_name(path)
    if path.exists() and not path.is_dir():
        raise InputError(f"{path}: expected a folder, got a file")
    if path.exists() and not all(map(_is_unwritten, path.iterdir())):
        other = f"choose another {option('out')}, or {option('resume')} what is there"
        remedy = other if (path / MANIFEST).exists() else "got other files"
        raise InputError(f"{path}: expected an empty or new run folder, {remedy}")


def _has_other_fingerprint(path: Path, requested: Manifest, mixed: bool) -> bool:
    """Check that plan and inputs are unchanged; return whether the fingerprint differs, which needs `mixed`."""
    stored = read_manifest(path)
    for key in ("command", "plan", *HASHED):
        before, after = (getattr(one, key) for one in (stored, requested))
        if before != after:
            what = f"{change(before, after)}{RunInputs.of(path, stored.made_in).place}"
            raise InputError(f"{path}: {option('resume')}: {key} changed: {what}; start a new run")
    if stored.fingerprint == requested.fingerprint:
        return False
    if not mixed:
        what = change(stored.fingerprint, requested.fingerprint)
        raise InputError(f"{path}: {option('resume')}: fingerprint changed: {what}; {option('mixed')} accepts it")
    return True


def _is_unwritten(path: Path) -> bool:
    """Whether a run that was killed before writing its manifest could have left this file."""
    drafts = [f"{name}{DRAFT}" for name in (MANIFEST, INPUTS)]
    if path.name in (*drafts, INPUTS, LOCK):  # where the file system has no locks, the holder's name is in the file
        return True
    return path.name in LINES and path.is_file() and path.stat().st_size == 0


def write_json(path: Path, value: Mapping[str, object]) -> None:
    """Write a JSON file with sorted keys, atomically."""
    write_text(path, json.dumps(value, indent=2, sort_keys=True, allow_nan=False) + "\n")


def read_records(path: Path) -> list[Record]:
    """The records of a run folder, sorted by id."""
    file = path / LINES[0]
    return sorted((read_record(row, str(file)) for row in read_lines(file)), key=lambda record: record.id)


def read_timing(path: Path) -> dict[str, Timing]:
    """The timing of a run folder's episodes by id."""
    file = path / LINES[1]
    found = (checked(Timing, row, f"{file}: {row.get('id')!r}") for row in read_lines(file))
    return {timing.id: timing for timing in found}


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
