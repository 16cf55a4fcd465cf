"""The table of figures as a file: `perception.json` in a run folder, or where a user wants it."""

import json
from pathlib import Path
from typing import Any

from vpf_sim.errors import InputError
from vpf_sim.evaluation.sweeps.fingerprint import fingerprint
from vpf_sim.evaluation.sweeps.run_folder import write_json
from vpf_sim.evaluation.sweeps.schema import Number, Numbers, Schema, checked
from vpf_sim.shell import command

NAME = "perception.json"
SCHEMA = 1


class Figures(Schema):
    """What is compared and held to rules."""

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


class Body(Schema):
    kind: str
    first_confirmed_m: Number


class Record(Figures):
    """One drive as one driver perceives it."""

    drive: str
    scenario: str
    weather: str
    driver: str
    seed: int
    states_sha256: str
    bodies: list[Body]


class Row(Figures):
    """The drives of a cell."""

    scenario: str
    weather: str
    driver: str


class Table(Schema):
    records: list[Record]
    rows: list[Row]


def write(path: Path, table: dict[str, Any]) -> None:
    """The table with the fingerprint of the code that perceived; whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_json(path, {"schema": SCHEMA, "fingerprint": fingerprint(), **table})


def read(path: Path) -> Table:
    """The table that is stored in a file, or in a run folder."""
    file = path / NAME if path.is_dir() else path
    try:
        stored: Any = json.loads(file.read_text("utf-8"))
    except OSError as error:
        hint = f"; {command('perception', path)} makes it" if path.is_dir() else ""
        raise InputError(f"{file}: expected a table of perception, got: {error.strerror}{hint}") from None
    except (ValueError, RecursionError):
        raise InputError(f"{file}: expected JSON, got something else") from None
    if not isinstance(stored, dict):
        raise InputError(f"{file}: expected a JSON object, got something else")
    return checked(Table, stored, str(file))
