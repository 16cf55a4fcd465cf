"""The stored drives whose poses are replayed: of given runs, or of a fixed set that is driven once."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from vpf_sim import configuration
from vpf_sim.errors import InputError, unknown_name
from vpf_sim.evaluation.perception.replay import StoredDrive
from vpf_sim.evaluation.run_inputs import RunInputs
from vpf_sim.evaluation.sweeps.fingerprint import digest
from vpf_sim.evaluation.sweeps.manifest import MANIFEST, Manifest, change, read_manifest
from vpf_sim.evaluation.sweeps.plan import Plan, make_plan
from vpf_sim.evaluation.sweeps.run_folder import read_records

PACKAGE, FIXED = "vpf_sim.evaluation.perception", "drives.toml"


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
