"""Reads and writes the table of perception metrics, by default `perception.json` in a run folder."""

import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from vpf_sim import configuration
from vpf_sim.errors import InputError, unknown_name
from vpf_sim.evaluation.metrics.records import Schema, checked
from vpf_sim.evaluation.perception import scores
from vpf_sim.evaluation.perception.scorer import DriveEvaluation
from vpf_sim.evaluation.perception.stored_drives import Evaluated, StoredDrive, replay
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.sweeps.fingerprint import digest, fingerprint
from vpf_sim.evaluation.sweeps.manifest import MANIFEST, Manifest, change, read_manifest
from vpf_sim.evaluation.sweeps.plan import Plan, make_plan
from vpf_sim.evaluation.sweeps.run_folder import read_records, write_json
from vpf_sim.system import command

NAME = "perception.json"
SCHEMA = 1


Number = float | None
Numbers = dict[str, Number]
PACKAGE, FIXED = "vpf_sim.evaluation.perception", "drives.toml"


class Metrics(Schema):
    """The metrics that comparisons and rules use."""

    recall: Number
    precision: Number
    false_positives_per_minute: Number
    distance_error_m: Numbers | None
    left_error_m: Numbers | None
    right_error_m: Numbers | None
    speed_error_mps: Numbers | None
    edge_error_m: Numbers | None
    lane_error_m: Numbers | None
    foe_error_px: Numbers | None


class MetObject(Schema):
    kind: str
    first_confirmed_m: Number


class Record(Metrics):
    """One driver's metrics on one drive."""

    drive: str
    scenario: str
    weather: str
    driver: str
    seed: int
    states_sha256: str
    bodies: list[MetObject]


class Row(Metrics):
    """The metrics of a cell's drives."""

    scenario: str
    weather: str
    driver: str


class Table(Schema):
    records: list[Record]
    rows: list[Row]


def write(path: Path, table: scores.Row) -> None:
    """Write the table with the code's fingerprint, atomically."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_json(path, {"schema": SCHEMA, "fingerprint": fingerprint(), **table})


def read(path: Path) -> Table:
    """The table stored in a file or a run folder."""
    file = path / NAME if path.is_dir() else path
    try:
        stored: Any = json.loads(file.read_bytes())
    except OSError as error:
        hint = f"; {command('perception', path)} creates it" if path.is_dir() else ""
        raise InputError(f"{file}: expected a table of perception, got: {error.strerror}{hint}") from None
    except (ValueError, RecursionError):
        raise InputError(f"{file}: expected JSON, got something else") from None
    if not isinstance(stored, dict):
        raise InputError(f"{file}: expected a JSON object, got something else")
    return checked(Table, stored, str(file))


def fixed_set() -> Plan:
    """The fixed set of drives, used where no run is named."""
    return make_plan(configuration.read(PACKAGE, FIXED), FIXED)


def folder_of(plan: Plan) -> Path:
    """The run folder of a plan, named by a hash of plan, scenarios and weathers."""
    return Path("runs") / f"perception-{digest([plan.jobs(), plan.hashes()])[:8]}"


def stored_drives(folders: Iterable[Path], ids: Sequence[str] = ()) -> list[StoredDrive]:
    """The episodes with steps in run folders, only those named by `ids` if given."""
    found: dict[tuple[str, str | None], StoredDrive] = {}
    for folder in folders:
        for drive in _of_run(folder):
            found.setdefault((drive.record.id, drive.record.states_sha256), drive)
    available = {name for name, _ in found}
    for name in ids:
        if name not in available:
            raise unknown_name("drive", name, available)
    return [drive for (name, _), drive in found.items() if not ids or name in ids]


def _of_run(folder: Path) -> list[StoredDrive]:
    if not folder.is_dir():
        raise InputError(
            f"{folder}: expected a run folder, got {'a file' if folder.exists() else 'nothing of that name'}"
        )
    manifest = read_manifest(folder)
    drives = [StoredDrive(folder, record) for record in read_records(folder) if record.steps]
    if not drives:
        raise InputError(f"{folder}: expected at least one episode with steps, got none")
    _check_world(folder, manifest, drives)
    return drives


def _check_world(folder: Path, manifest: Manifest, drives: Sequence[StoredDrive]) -> None:
    """InputError where a scenario or weather changed since the run."""
    names = [tuple(sorted({getattr(drive.record, key) for drive in drives})) for key in ("scenario", "weather")]
    now = Plan(names[0], names[1], ("neutral",), "0:1").hashes(RunInputs.of(folder, manifest.made_in))
    for kind in ("scenarios", "weathers"):
        stored = {name: manifest.hashes(kind).get(name) for name in now[kind]}
        if stored != now[kind]:
            raise InputError(f"{folder / MANIFEST}: {kind} changed since the run: {change(stored, now[kind])}")


def measure(
    drives: Iterable[StoredDrive], names: Sequence[str], workers: int, notify: Callable[[StoredDrive], None]
) -> list[Evaluated]:
    """Evaluate the named drivers on each drive; `notify` is called with each finished drive."""
    found = []
    for drive, evaluations in replay(drives, names, workers):
        found.append((drive, evaluations))
        notify(drive)
    return found


def table(found: Iterable[Evaluated]) -> scores.Row:
    """The metrics of all drives: `records`, `rows`, `totals` (see `scores.table`)."""
    return scores.table(_flat(found))


def store_by_run(found: Sequence[Evaluated]) -> None:
    """Store the metrics of each run's drives in its folder, for rules of the gate."""
    for folder in {drive.folder for drive, _ in found}:
        own = [(drive, evaluations) for drive, evaluations in found if drive.folder == folder]
        write(folder / NAME, table(own))


def _flat(found: Iterable[Evaluated]) -> list[DriveEvaluation]:
    return [evaluation for _, evaluations in found for evaluation in evaluations]
