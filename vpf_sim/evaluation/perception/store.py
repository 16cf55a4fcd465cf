"""Reads and writes the table of perception metrics, by default `perception.json` in a run folder."""

import json
from pathlib import Path
from typing import Any

from vpf_sim.errors import InputError
from vpf_sim.evaluation.metrics.records import Schema, checked
from vpf_sim.evaluation.sweeps.fingerprint import fingerprint
from vpf_sim.evaluation.sweeps.run_folder import write_json
from vpf_sim.shell import command

NAME = "perception.json"
SCHEMA = 1


Number = float | None
Numbers = dict[str, Number]


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


def write(path: Path, table: dict[str, Any]) -> None:
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
