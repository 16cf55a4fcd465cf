"""The tables of a replay, for the terminal and the page."""

from collections.abc import Callable, Mapping, Sequence

from vpf_sim.evaluation.score_keys import Number
from vpf_sim.replay.records import (
    Agreement,
    Commands,
    DriveRecord,
    LanePart,
    Pixels,
    Row,
    Spread,
    Summary,
    Timing,
    TtcScores,
)
from vpf_sim.replay.scores import SIGNALS
from vpf_sim.reporting.kit.page import Line, Table, formatted

PART_NAMES = {"clear_of_obstacles": "no obstacles", "with_obstacles": "with obstacles", "not divided": "not divided"}
NOTHING = "no recording"
ORIGIN_SIGNALS = (
    "camera",
    "times_s",
    "poses",
    "speed_mps",
    "yaw_rate_radps",
    "steering_rad",
    "throttle",
    "obstacle",
    "foe_px",
)


def tables(records: Sequence[DriveRecord], timing: Mapping[str, Timing], summary: Summary) -> list[Table]:
    """All tables with rows; the paper's comes last."""
    found = [
        warnings(records),
        drives(records),
        origins(records),
        lanes(records),
        checks(records),
        perception(records),
        compute(records, timing),
        real_images(summary),
    ]
    return [table for table in found if table.rows]


def real_images(summary: Summary) -> Table:
    """Commands beside the human's and the paper's cells; those without a recording come last."""
    names = ("weather", "part", "signals", "drives")
    scores = ("range", "span", "tol.", "mae", "idle")
    of_both = [f"{signal} {score}" for signal in ("a", "δ") for score in scores]
    note = (
        "a is throttle, δ steering; range, span and tol. (tolerance) are accuracies in %, mae the mean |difference|; "
        "idle is the range accuracy of zero commands, which shows the share of the road; unseen is the "
        "share of scored frames without an image or with the last command held. Assumed signals are not scored."
    )
    return Table(
        (*names, "frames", "unseen %", *of_both, "paper a", "paper δ"),
        tuple(map(_score, sorted(summary.rows, key=lambda row: not row.frames))),
        words=len(names),
        title="Throttle and steering beside the human's",
        notes=(note, *summary.differences),
        faint=sum(not row.frames for row in summary.rows),
    )


def _score(row: Row) -> Line:
    kinds = row.signals
    signals = f"a {kinds.throttle}, δ {kinds.steering}" if row.frames else NOTHING
    unseen = formatted(row.unseen / row.frames if row.frames else None, 1, True)
    return (
        row.weather + (f" + {row.added}" if row.added else ""),
        PART_NAMES[row.part],
        signals,
        ", ".join(row.drives),
        str(row.frames),
        unseen,
        *_agreement(row.accuracy, row.idle),
        *(formatted(row.paper[signal] if row.paper else None, 1, True) for signal in SIGNALS),
    )


def _agreement(accuracy: Commands, idle: Commands) -> Line:
    """The cells of both commands."""
    cells: list[str] = []
    for signal in SIGNALS:
        scores, unsteered = accuracy[signal] or Agreement(), idle[signal] or Agreement()
        cells += [formatted(share, 1, True) for share in (scores.range, scores.span, scores.tolerance)]
        cells += [formatted(scores.mae, 3), formatted(unsteered.range, 1, True)]
    return tuple(cells)


def drives(records: Sequence[DriveRecord]) -> Table:
    """The drives and how they were driven."""
    header = "drive, layout, weather, camera, obstacles by, frames, gaps, segments, restarts, road found %"
    notes = [f"{record.name}: {record.protocol}; goal: {record.goal}" for record in records if record.driven]
    notes += [f"{record.name}: {note}" for record in records for note in record.notes]
    notes += [
        f"{record.name}: the driver failed at frame {error.frame}, at {error.place}: {error.what}; not scored"
        for record in records
        if (error := record.error)
    ]
    notes += [record.no_images for record in records if record.no_images]
    rows = tuple(_drive(record) for record in records)
    return Table(tuple(header.split(", ")), rows, words=5, title="The drives", notes=tuple(notes))


def _drive(record: DriveRecord) -> Line:
    camera = record.camera
    counts = (record.frames, record.gaps, record.segments, record.restarts)
    return (
        record.name,
        record.layout,
        record.weather or "unknown",
        f"{camera.width_px} x {camera.height_px}, {record.rate_hz:.3g} Hz",
        record.obstacles_by or "none",
        *map(str, counts),
        formatted(record.perception.road_found_share, 1, True),
    )


def origins(records: Sequence[DriveRecord]) -> Table:
    """The origin of each signal."""
    rows = [
        (record.name, name, record.origins[name].kind, record.origins[name].how)
        for record in records
        for name in ORIGIN_SIGNALS
    ]
    return Table(("drive", "signal", "origin", "how"), tuple(rows), words=4, title="Origin of the signals")


def warnings(records: Sequence[DriveRecord]) -> Table:
    """Warnings, one line each."""
    rows = [(record.name, *warning) for record in records for warning in record.warnings]
    return Table(("drive", "what", "why"), tuple(rows), words=3, title="Warnings")


def lanes(records: Sequence[DriveRecord]) -> Table:
    """Steering with and without a lane."""
    parts = [
        (record.name, words, part)
        for record in records
        if record.accuracy and record.perception.road_found_share is not None
        for words, part in (("found", record.accuracy.lane.found), ("not found", record.accuracy.lane.not_found))
        if part.frames
    ]
    return Table(
        ("drive", "lane", "frames", "δ range", "δ span", "δ mae", "idle mae"),
        tuple((name, words, *_lane(part)) for name, words, part in parts),
        words=2,
        title="Steering with and without a lane",
        notes=("Without a lane the model car holds course and speed; these frames are not scored.",),
    )


def _lane(part: LanePart) -> Line:
    own, idle = (one or Agreement() for one in (part.steering, part.idle))
    shares = (formatted(share, 1, True) for share in (own.range, own.span))
    return str(part.frames), *shares, formatted(own.mae, 4), formatted(idle.mae, 4)


def checks(records: Sequence[DriveRecord]) -> Table:
    """Independent signals checked by physics."""
    checked = [(record.name, check) for record in records if (check := record.signal_checks.yaw_rate)]
    note = (
        "gain: slope of the yaw rate over v tan(δ) / 2.7 m; 1 for correct ratio, wheelbase and sign without slip, "
        "negative for a wrong sign, about 0.5 for an understeering car at 25 m/s."
    )
    rows = tuple((name, formatted(one.gain, 3), formatted(one.correlation, 3)) for name, one in checked)
    return Table(("drive", "gain", "correlation"), rows, title="Signals checked by physics", notes=(note,))


def perception(records: Sequence[DriveRecord]) -> Table:
    """Perception against ground truth."""
    foe = ("FOE x px", "FOE y px", "own x px", "own y px", "FOE found %", "spread x px", "spread y px")
    note = (
        "FOE: median error of the focus of expansion, recorded rotation removed; own: without recorded rotation; "
        "spread: interquartile range; yaw rate: median error by the flow; speed scale: by the road's flow / recorded; "
        "TTC: to the lead vehicle where the gap closes faster than 0.5 m/s; false alarms: below 4 s at standstill."
    )
    return Table(
        ("drive", *foe, "yaw rate rad/s", "speed scale", "TTC error %", "within 25 %", "false alarms %"),
        tuple(_perception(record) for record in records if record.driven),
        title="Perception against ground truth",
        notes=(note,),
    )


def _perception(record: DriveRecord) -> Line:
    scores = record.perception
    scale, ttc = scores.speed_scale or Spread(), scores.ttc or TtcScores()
    return (
        record.name,
        *_pixels(record.foe_median_error_px),
        *_pixels(record.foe_median_error_own_derotation_px),
        formatted(scores.foe.share, 1, True),
        *_pixels(scores.foe.interquartile_range_px),
        formatted(scores.yaw_rate_median_error_radps, 4),
        formatted(scale.median, 2),
        *(formatted(share, 1, True) for share in (ttc.median_error, ttc.within_25_percent, ttc.false_alarms)),
    )


def _pixels(found: Pixels | None) -> tuple[str, str]:
    shown = found or Pixels()
    return formatted(shown.x, 1), formatted(shown.y, 1)


COMPUTE: dict[str, Callable[[Timing], Number]] = {
    "driver": lambda one: one.driver_ms,
    "driver 95 %": lambda one: one.driver_p95_ms,
    "reading": lambda one: one.reading_ms,
    "period": lambda one: one.period_ms,
    "times real time": lambda one: one.real_time,
}


def compute(records: Sequence[DriveRecord], timing: Mapping[str, Timing]) -> Table:
    """Computing time on one core."""
    names = [record.name for record in records if record.driven and record.name in timing]
    rows = tuple((name, *(formatted(of(timing[name]), 1) for of in COMPUTE.values())) for name in names)
    title, notes = "Time on one core, ms a frame", ("medians of CPU time",)
    return Table(("drive", *COMPUTE), rows, title=title, notes=notes)
