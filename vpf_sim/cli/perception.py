"""`vpf-sim perception`: open-loop evaluation of perception on stored drives."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vpf_sim.cli.options import DriversOption, JsonOption, WorkersOption, located, print_json, prints_on_stderr

if TYPE_CHECKING:
    from vpf_sim.evaluation.perception.replay import StoredDrive

RunsArgument = Annotated[
    list[Path] | None,
    typer.Argument(metavar="RUN", help="Run folders; by default a fixed set of drives.", callback=located),
]
IdsOption = Annotated[
    list[str] | None, typer.Option("--id", metavar="ID", help="A drive of the runs; may be repeated; by default all.")
]
FileOption = Annotated[Path | None, typer.Option("--out", metavar="FILE", help="Write the table as JSON.")]
AgainstOption = Annotated[
    Path | None,
    typer.Option("--against", metavar="FILE", help="An earlier table, or its run folder.", callback=located),
]


def perception(
    runs: RunsArgument = None,
    driver: DriversOption = None,
    ids: IdsOption = None,
    against: AgainstOption = None,
    workers: WorkersOption = None,
    out: FileOption = None,
    json: JsonOption = False,
) -> None:
    """Score perception alone on stored drives.

    Their frames are rendered again, and the detections are compared with the ground truth.
    """
    from vpf_sim.cli.perception_tables import print_differences, print_totals
    from vpf_sim.evaluation.perception import measure, poses, store
    from vpf_sim.evaluation.sweeps.sweep import default_workers

    before = None if against is None else store.read(against)
    drivers = list(dict.fromkeys(driver or ["vpf"]))
    with prints_on_stderr():
        drives = poses.stored_drives(runs or [_fixed_set(workers)], ids or [])
        found = measure.measure(drives, drivers, workers or default_workers(), _Progress(len(drives)))
        table = measure.table(found)
        table["differences"] = _differences(table, before, against)
        if not ids:
            measure.store_by_run(found)
        if out is not None:
            store.write(out, table)
    if json:
        print_json({"runs": sorted({str(drive.folder) for drive in drives}), **table})
        return
    print_totals(table["totals"])
    print_differences(table["differences"])
    _print_remarks(table["records"])


def _fixed_set(workers: int | None) -> Path:
    """The run folder of the fixed set, which is driven first if it is incomplete."""
    from vpf_sim.api.execution import Execution
    from vpf_sim.api.progress import say
    from vpf_sim.cli.running import fill
    from vpf_sim.evaluation.perception import poses
    from vpf_sim.evaluation.sweeps.run_folder import MANIFEST, read_records

    plan = poses.fixed_set()
    folder = poses.folder_of(plan)
    begun = (folder / MANIFEST).exists()
    if begun and {record["id"] for record in read_records(folder)} >= {job.id for job in plan.jobs()}:
        return folder
    say(f"driving the {len(plan.jobs())} drives of the fixed set once: {folder}")
    return fill("sweep", plan, Execution(workers, out=folder, resume=begun, mixed=begun))


def _differences(table: dict[str, Any], before: Any, name: Path | None) -> list[dict[str, Any]]:
    """Differences between the drivers, and to the earlier table."""
    from vpf_sim.evaluation.perception import comparison
    from vpf_sim.evaluation.perception.store import Record

    records = [Record.model_validate(record) for record in table["records"]]
    found = comparison.between_drivers(records)
    return found if before is None else found + comparison.between_versions(records, before.records, str(name))


class _Progress:
    """Prints a line on stderr for each finished drive."""

    def __init__(self, total: int) -> None:
        self._total, self._done = total, 0

    def __call__(self, drive: "StoredDrive") -> None:
        from vpf_sim.api.progress import say

        self._done += 1
        say(f"{self._done}/{self._total} {drive.record['id']}")


def _print_remarks(records: list[dict[str, Any]]) -> None:
    """Print how replayed drives deviate from the stored ones."""
    for name, remark in sorted({(record["drive"], remark) for record in records for remark in record["remarks"]}):
        print(f"{name}: {remark}")
