"""What a replay stores of each drive and of all together, as objects; written and read here.

Records of earlier versions are read, too: what they lack is None or empty, keys that this version does not know are
left out.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Generic, Literal, NamedTuple, TypeVar

from pydantic import Strict

from vpf_sim.evaluation.metrics.records import Schema, checked, short
from vpf_sim.evaluation.score_keys import Json, Number
from vpf_sim.evaluation.sweeps.run_folder import read_lines

Part = Literal["clear_of_obstacles", "with_obstacles", "not divided"]
Signal = Literal["throttle", "steering"]
Texts = Annotated[tuple[str, ...], Strict(False)]  # JSON has lists


class Agreement(Schema):
    """How closely commands agree with the human's (`evaluation.metrics.tracking`); shares but for `mae`."""

    range: Number = None
    span: Number = None
    tolerance: Number = None
    mae: Number = None


Value = TypeVar("Value")


class Both(Schema, Generic[Value]):
    """A value for each of the two commands."""

    throttle: Value
    steering: Value

    def __getitem__(self, signal: Signal) -> Value:
        return self.throttle if signal == "throttle" else self.steering


Commands = Both[Agreement | None]  # None where there is nothing to score


class ByPart(Commands):
    """The agreement over a whole drive, and over its frames without and with obstacles."""

    clear_of_obstacles: Commands
    with_obstacles: Commands

    def part(self, name: Part) -> Commands:
        """The agreement over a part; the whole drive's if that is not divided."""
        return {"clear_of_obstacles": self.clear_of_obstacles, "with_obstacles": self.with_obstacles}.get(name, self)


class Counts(Schema):
    """The number of frames; None for the parts of a drive that is not divided."""

    whole: int
    clear_of_obstacles: int | None
    with_obstacles: int | None

    def part(self, name: Part) -> int:
        """The number in a part; that of the whole drive if it is not divided."""
        parts = {"clear_of_obstacles": self.clear_of_obstacles, "with_obstacles": self.with_obstacles}
        return parts.get(name, self.whole) or 0


class LanePart(Schema):
    """The steering's agreement over the frames with, or without, a lane; `idle` is that of no steering."""

    frames: int
    steering: Agreement | None
    idle: Agreement | None


class Lanes(Schema):
    """The frames in which a lane was found, and the others."""

    found: LanePart
    not_found: LanePart


class Accuracies(ByPart):
    """The agreement of a driver's commands in scored frames; `idle` is that of zero commands."""

    frames: Counts
    unseen: Counts  # frames of these without an image, or with the last command held
    idle: ByPart
    lane: Lanes


class Pixels(Schema):
    """A value across and one down the image, px."""

    x: Number = None
    y: Number = None


class Foe(Schema):
    """The focus of expansion of a driver: share of the moving frames with one, and its interquartile range."""

    share: Number
    interquartile_range_px: Pixels | None


class Spread(Schema):
    """Median and interquartile range."""

    median: Number = None
    interquartile_range: Number = None


class TtcScores(Schema):
    """The time to contact against the gap to the lead vehicle (`scores.time_to_contact`)."""

    frames: int = 0
    seen: Number = None
    median_error: Number = None
    within_25_percent: Number = None
    standing_frames: int = 0
    false_alarms: Number = None


class PerceptionScores(Schema):
    """Perception against the ground truth that the recording has."""

    foe: Foe
    yaw_rate_median_error_radps: Number
    speed_scale: Spread | None  # by the flow / recorded
    ttc: TtcScores | None
    road_found_share: Number


class YawRateCheck(Schema):
    """The yaw rate over that of speed and steering (`scores.signal_checks`)."""

    gain: Number = None
    correlation: Number = None


class SignalChecks(Schema):
    """Whether independent signals agree by physics."""

    origins: dict[str, str]
    yaw_rate: YawRateCheck | None


class SignalOrigin(Schema):
    """Where a signal comes from."""

    kind: str
    how: str


class CameraShape(Schema):
    """The camera of the rectified frames."""

    width_px: int
    height_px: int
    focal_px: Number
    height_m: Number


class MountingAngle(Schema):
    """An estimated angle with its 95 % interval; one that is not used is assumed to be 0."""

    used: bool
    deg: Number
    from_deg: Number
    to_deg: Number
    straight_s: Number


class MeanSpeed(Schema):
    """The interval of the mean speed, and of its ratio to the stated one."""

    mean_mps: Number
    from_mps: Number
    to_mps: Number
    low: Number
    high: Number
    narrowed_by: str


class Fault(Schema):
    """An exception of the driver that ended the drive."""

    frame: int
    place: str  # module, line and function
    what: str


class DriveWarning(NamedTuple):
    """A reason to doubt a replay, in one line."""

    what: str
    why: str


class DriveRecord(Schema):
    """One replayed drive: a function of recording, driver and code."""

    name: str
    file: str  # of its frame table and video, without the ending
    driver: str
    layout: str
    weather: str
    added: str | None  # what was simulated on top of the recording
    frames: int
    held: int
    gaps: int
    rate_hz: Number
    foe_median_error_px: Pixels | None
    foe_median_error_own_derotation_px: Pixels | None
    accuracy: Accuracies | None  # None if it was not driven
    perception: PerceptionScores
    signal_checks: SignalChecks
    derived: Texts
    origins: dict[str, SignalOrigin]
    obstacles_by: str | None
    goal: str
    protocol: str
    segments: int
    restarts: int
    camera: CameraShape
    mounting: dict[str, MountingAngle] | None = None
    speed_interval: MeanSpeed | None = None
    notes: Texts
    driven: bool
    no_images: str | None  # the reason, and the remedy
    error: Fault | None
    warnings: Annotated[tuple[DriveWarning, ...], Strict(False)] = ()
    fingerprint: str | None = None  # digest of the version that made it, if it is not the replay's

    @property
    def seconds(self) -> float:
        return self.frames / self.rate_hz if self.rate_hz else 0.0

    def as_json(self) -> Json:
        """The line of replays.jsonl."""
        return self.model_dump(exclude={"fingerprint"} if self.fingerprint is None else None)


class Timing(Schema):
    """CPU times of a drive, ms a frame; `real_time` is recording time over computing time."""

    name: str
    driver_ms: Number
    driver_p95_ms: Number
    reading_ms: Number
    period_ms: Number
    real_time: Number
    wall_s: Number = None


class Row(Schema):
    """The pooled agreement of the drives of one weather, part and kind of signals, beside the paper's."""

    weather: str
    added: str | None
    part: Part
    drives: Texts
    frames: int
    unseen: int
    signals: Both[str | None]  # the origins of the human's commands
    accuracy: Commands
    idle: Commands
    paper: Both[float] | None


class Summary(Schema):
    """All rows, and how ours differ from the paper's."""

    rows: tuple[Row, ...]
    differences: Texts


Hashes = dict[str, dict[str, str]]  # of what was `read` and what was `derived` from it, by name


class ReplayPlan(Schema):
    """What was requested; `drives` has the folder of each by its name."""

    driver: str
    water: str | None = None
    drives: dict[str, str]
    faults: Json | None = None


class ReplayManifest(Schema):
    """The plan of a replay, and hashes of what its records depend on."""

    command: str = "replay"
    fingerprint: dict[str, str]
    plan: ReplayPlan
    recordings: dict[str, Hashes]
    weathers: dict[str, str]
    drivers: dict[str, str]

    def as_json(self) -> Json:
        stored = self.model_dump()
        if self.plan.faults is None:
            del stored["plan"]["faults"]
        return {"schema": 1, **stored}


Line = TypeVar("Line", DriveRecord, Timing)


def read(schema: type[Line], file: Path) -> list[Line]:
    """The lines of a file, sorted by the drive's name; InputError in one line where one is none of these."""
    rows: Iterable[Json] = read_lines(file)
    return sorted((checked(schema, row, f"{file}: {short(row.get('name'))}") for row in rows), key=lambda one: one.name)
