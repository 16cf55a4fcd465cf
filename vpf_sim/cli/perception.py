"""`vpf-sim perception`: open-loop evaluation of perception on stored drives."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vpf_sim.cli.options import DriversOption, JsonOption, WorkersOption, located, print_json, prints_on_stderr
from vpf_sim.cli.output import number, percent, percent_within, print_table, within

if TYPE_CHECKING:
    from vpf_sim.evaluation.perception.scores import Row
    from vpf_sim.evaluation.perception.store import Table
    from vpf_sim.evaluation.perception.stored_drives import StoredDrive


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
    from vpf_sim.evaluation.perception import store
    from vpf_sim.evaluation.sweeps.sweep import default_workers

    before = None if against is None else store.read(against)
    drivers = list(dict.fromkeys(driver or ["vpf"]))
    with prints_on_stderr():
        drives = store.stored_drives(runs or [_fixed_set(workers)], ids or [])
        found = store.measure(drives, drivers, workers or default_workers(), _Progress(len(drives)))
        table = store.table(found)
        table["differences"] = _differences(table, before, against)
        if not ids:
            store.store_by_run(found)
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
    from vpf_sim.api.filling import Execution
    from vpf_sim.api.progress import say
    from vpf_sim.cli.run_options import fill
    from vpf_sim.evaluation.perception import store
    from vpf_sim.evaluation.sweeps.manifest import MANIFEST
    from vpf_sim.evaluation.sweeps.run_folder import read_records

    plan = store.fixed_set()
    folder = store.folder_of(plan)
    begun = (folder / MANIFEST).exists()
    if begun and {record.id for record in read_records(folder)} >= {job.id for job in plan.jobs()}:
        return folder
    say(f"driving the {len(plan.jobs())} drives of the fixed set once: {folder}")
    return fill("sweep", plan, Execution(workers, out=folder, resume=begun, mixed=begun))


def _differences(table: "Row", before: "Table | None", name: Path | None) -> "list[Row]":
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
        say(f"{self._done}/{self._total} {drive.record.id}")


def _print_remarks(records: "list[Row]") -> None:
    """Print how replayed drives deviate from the stored ones."""
    for name, remark in sorted({(record["drive"], remark) for record in records for remark in record["remarks"]}):
        print(f"{name}: {remark}")


RATE = "false_positives_per_minute"
OF_DETECTIONS = ("distance_error_m", "left_error_m", "right_error_m", "speed_error_mps")
ERROR_LABELS = ("distance m", "left m", "right m", "speed m/s")
DIFFERENCES = {  # label, digits, scale
    "recall": ("recall at due distance, %", 1, 100.0),
    "precision": ("precision, %", 1, 100.0),
    RATE: ("false positives a minute", 2, 1.0),
    "distance_error_m": ("distance error, m", 3, 1.0),
    "left_error_m": ("left side error, m", 3, 1.0),
    "right_error_m": ("right side error, m", 3, 1.0),
    "speed_error_mps": ("speed error, m/s", 3, 1.0),
    "edge_error_m": ("edge error at 10 m, m", 4, 1.0),
    "lane_error_m": ("lane error at 10 m, m", 4, 1.0),
    "foe_error_px": ("FOE error, px", 3, 1.0),
}


def print_totals(totals: "list[Row]") -> None:
    """Print metrics by driver and weather, then by kind and by distance."""
    print_table(
        ("", "drives", "objects", "recall %", "precision %", "false pos./min"), [_detection_row(row) for row in totals]
    )
    print("\nErrors of correct detections, median / 95th percentile:\n")
    print_table(("", *ERROR_LABELS), [(_name(row), *_errors(row)) for row in totals])
    print("\nLateral overlap (intersection over union) within 12 m, median, %:\n")
    print_table(("", "overlap"), [(_name(row), percent(row["overlap"])) for row in totals])
    _print_calibration(totals)
    print("\nErrors of road and focus of expansion (FOE), median / 95th percentile:\n")
    print_table(("", "edges at 10 m, m", "lane at 10 m, m", "FOE px"), [_frame_row(row) for row in totals])
    for row in _single(totals):
        print(f"\n{_name(row)}, by kind:\n")
        header = ("", "objects", "recall %", "confirmed at m", *ERROR_LABELS)
        print_table(header, [(kind, *_kind_row(one)) for kind, one in row["by_kind"].items()])
        print(f"\n{_name(row)}, by distance from the bumper:\n")
        header = ("m", "recall %", "precision %", "false pos./min", *ERROR_LABELS)
        print_table(header, [_band_row(one) for one in row["by_distance"]])
    print("\nRecall: objects met in the corridor that were confirmed 15 m before (cones 10, pallets 6);")
    print("by distance: at the nearer end of the band or farther. Precision and false positives are means")
    print("over the drives. [95 % intervals]")


def _print_calibration(totals: "list[Row]") -> None:
    """Print how often what is stated with a probability exists, of drivers that state one."""
    bands = [
        (
            _name(row),
            f"{100.0 * band['from']:.0f}-{100.0 * band['to']:.0f}",
            percent(band["stated"]),
            percent(band["right"]),
            str(band["count"]),
        )
        for row in totals
        for band in row["calibration"]
    ]
    if bands:
        print("\nExistence, by the probability that the driver states:\n")
        print_table(("", "band %", "mean %", "exists %", "detections"), bands)


def print_differences(differences: "list[Row]") -> None:
    """Print paired differences between drivers or versions."""
    for found in differences:
        print(f"\n{found['driver']} minus {found['minus']}, {_weather(found)}, {found['drives']} drives:\n")
        print_table(
            ("figure", "difference", "95 % interval", "p", "pairs"),
            [(label, *_difference(found[key], digits, scale)) for key, (label, digits, scale) in DIFFERENCES.items()],
        )
    if differences:
        print("\nRecall: paired by object (McNemar's test). All else: paired by drive (sign flips); errors by their")
        print("medians.")


def _single(totals: "list[Row]") -> "list[Row]":
    """Only single weathers: kinds and distances of all weathers together say little."""
    return [row for row in totals if row["weather"] != "all"]


def _weather(row: "Row") -> str:
    return "all weathers" if row["weather"] == "all" else str(row["weather"])


def _name(row: "Row") -> str:
    return f"{row['driver']}, {_weather(row)}"


def _detection_row(row: "Row") -> tuple[str, ...]:
    ends = row["intervals"]
    return (
        _name(row),
        str(row["drives"]),
        str(row["bodies_met"]),
        percent_within(row["recall"], ends["recall"]),
        percent_within(row["precision"], ends["precision"]),
        within(row[RATE], ends[RATE]),
    )


def _frame_row(row: "Row") -> tuple[str, ...]:
    edges, lane = (_spread(row[key], 3) for key in ("edge_error_m", "lane_error_m"))
    return _name(row), edges, lane, _spread(row["foe_error_px"], 1)


def _kind_row(row: "Row") -> tuple[str, ...]:
    return (str(row["bodies_met"]), percent(row["recall"]), number(row["first_confirmed_m"], 1), *_errors(row))


def _band_row(row: "Row") -> tuple[str, ...]:
    band = f"{row['from_m']:.0f}-{row['to_m']:.0f}" if row["to_m"] is not None else f"{row['from_m']:.0f}-"
    return (band, percent(row["recall"]), percent(row["precision"]), number(row[RATE]), *_errors(row))


def _errors(row: "Row") -> tuple[str, ...]:
    return tuple(_spread(row[key], 2) for key in OF_DETECTIONS)


def _spread(error: "Row | None", digits: int) -> str:
    return "-" if error is None else f"{number(error['median'], digits)} / {number(error['p95'], digits)}"


def _difference(found: "Row | None", digits: int, scale: float) -> tuple[str, ...]:
    if found is None:
        return "-", "-", "-", "0"
    ends = found["interval"]
    interval = "-" if ends is None else f"[{', '.join(f'{scale * end:+.{digits}f}' for end in ends)}]"
    return f"{scale * found['difference']:+.{digits}f}", interval, number(found["p"], 3), str(found["pairs"])
