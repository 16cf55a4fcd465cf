"""The manifest of a run: its plan, and what an episode's bytes depend on beside it."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from datetime import datetime
from pathlib import Path

from pydantic import Field

from vpf_sim.errors import InputError
from vpf_sim.evaluation.metrics.records import Schema, checked, short
from vpf_sim.evaluation.score_keys import Json
from vpf_sim.evaluation.sweeps.fingerprint import fingerprint, forget_code
from vpf_sim.evaluation.sweeps.plan import Plan, make_plan

MANIFEST = "manifest.json"
SCHEMA = 1
HASHED = ("scenarios", "weathers", "drivers")  # whose hashes are stored by name


class Manifest(Schema):
    """Command, plan, day, fingerprint, and the hashes of scenarios, weathers and users' drivers."""

    command: str
    plan: Json
    fingerprint: dict[str, str]
    scenarios: dict[str, str]
    weathers: dict[str, str]
    drivers: dict[str, str] = Field(default_factory=dict)
    privileged: dict[str, str] = Field(default_factory=dict)  # by driver; runs of earlier versions lack it
    begun: str | None = None  # ISO 8601; runs of earlier versions lack it, or have the day alone
    made_in: str | None = None  # the working folder; runs of earlier versions lack it

    @classmethod
    def of(cls, command: str, plan: Plan) -> "Manifest":
        """The manifest of a new run; InputError for an unknown name or file."""
        forget_code()
        requested = json.loads(json.dumps({key: value for key, value in asdict(plan).items() if value}))
        made = {"begun": datetime.now().astimezone().isoformat(), "made_in": str(Path.cwd())}
        known = {"command": command, "plan": requested, "fingerprint": fingerprint()}
        return cls.model_validate({**known, **made, **plan.check()})

    def names(self, kind: str) -> list[str]:
        """The names of the plan's scenarios, weathers or drivers."""
        found = self.plan.get(kind)
        return [name for name in found if isinstance(name, str)] if isinstance(found, list) else []

    def hashes(self, kind: str) -> dict[str, str]:
        """The hashes of one of HASHED by name."""
        found: dict[str, str] = getattr(self, kind)
        return found

    def as_json(self) -> Json:
        return {"schema": SCHEMA, **self.model_dump(exclude_unset=True)}


def read_manifest(path: Path) -> Manifest:
    """The manifest of a run folder."""
    file = path / MANIFEST
    try:
        stored: object = json.loads(file.read_bytes())
    except OSError as error:
        raise InputError(f"{file}: expected the manifest of a run, got: {error.strerror}") from None
    except (ValueError, RecursionError):
        raise InputError(f"{file}: expected JSON, got something else") from None
    for keys in (("plan", "fingerprint"), ("scenarios", "weathers")):
        if not isinstance(stored, dict) or not all(isinstance(stored.get(key), dict) for key in keys):
            raise InputError(f"{file}: expected a table for {keys[0]} and for {keys[1]}, got something else")
    assert isinstance(stored, dict)
    return checked(Manifest, stored, str(file))


def stored_plan(path: Path) -> Plan:
    """The plan of the run in a folder."""
    return make_plan(read_manifest(path).plan, str(path / MANIFEST))


def change(before: object, after: object) -> str:
    """The differences of two tables as text."""
    if isinstance(before, Mapping) and isinstance(after, Mapping):
        keys = [key for key in sorted(before.keys() | after.keys()) if before.get(key) != after.get(key)]
        return ", ".join(f"{key}: was {short(before.get(key))}, is {short(after.get(key))}" for key in keys)
    return f"was {short(before)}, is {short(after)}"
