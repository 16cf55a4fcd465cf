"""Settings in drive.toml for a recording of your own; docs/recordings.md explains each key."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from vpf_sim import tables
from vpf_sim.replay import plausible
from vpf_sim.replay.assemble import CAMERA_AHEAD_M, WHEELBASE_M

LONGEST_NAME = 200
LeftPositive = Literal["steering", "yaw_rate", "yaw", "y"]


@dataclass(frozen=True, slots=True)
class CameraKeys:
    """Camera settings. Pitch + looks down, yaw + looks right, roll + clockwise; estimated if left out."""

    fx_px: float | None = None
    fy_px: float | None = None  # default: fx_px
    cx_px: float | None = None  # default: the image centre
    cy_px: float | None = None
    field_of_view_deg: float | None = None  # horizontal, instead of fx_px
    distortion: tuple[float, ...] = ()
    model: Literal["pinhole", "fisheye"] = "pinhole"
    height_m: float | None = None
    pitch_deg: float | None = None
    yaw_deg: float | None = None
    roll_deg: float | None = None
    ahead_of_rear_axle_m: float = CAMERA_AHEAD_M

    def __post_init__(self) -> None:
        if self.fx_px is not None and self.field_of_view_deg is not None:
            raise ValueError("fx_px, field_of_view_deg: expected one of them, got both")
        for name in ("field_of_view_deg", "height_m", "pitch_deg", "yaw_deg", "roll_deg", "ahead_of_rear_axle_m"):
            plausible.check_key(name, getattr(self, name))
        for name, limit in {
            "fx_px": "focal_px",
            "fy_px": "focal_px",
            "cx_px": "centre_px",
            "cy_px": "centre_px",
        }.items():
            plausible.check_key(name, getattr(self, name), limit)
        for coefficient in self.distortion:
            plausible.check_key("distortion", coefficient)
        if self.model == "fisheye" and len(self.distortion) != 4:
            raise ValueError(f"distortion: expected the 4 numbers of a fisheye, got {len(self.distortion)}")
        if self.model == "pinhole" and len(self.distortion) not in (0, 1, 2, 4, 5, 8):
            raise ValueError(f"distortion: expected 2, 4, 5 or 8 numbers, got {len(self.distortion)}")
        angles = [angle is None for angle in (self.pitch_deg, self.yaw_deg)]
        if any(angles) and not all(angles):
            raise ValueError("pitch_deg, yaw_deg: expected both or neither")


@dataclass(frozen=True, slots=True)
class VehicleKeys:
    """The recorded car; full throttle and brake are those of the driver's model."""

    wheelbase_m: float = WHEELBASE_M
    steering_ratio: float | None = None  # steering wheel over road wheels

    def __post_init__(self) -> None:
        plausible.check_key("wheelbase_m", self.wheelbase_m)
        plausible.check_key("steering_ratio", self.steering_ratio)


@dataclass(frozen=True, slots=True)
class SignalKeys:
    """The table of signals; `columns` maps our names to the names in the table."""

    file: str = "signals.csv"
    offset_s: float = 0.0  # added to the table's times; the first frame is at 0
    left_is_positive: tuple[LeftPositive, ...] = ()
    columns: tuple[tuple[str, str], ...] = ()  # (our name, the table's name)

    def __post_init__(self) -> None:
        plausible.check_key("offset_s", self.offset_s)
        _check_letters(self.file, *(name for pair in self.columns for name in pair))


@dataclass(frozen=True, slots=True)
class DriveFile:
    """The whole file."""

    schema: Literal[1]
    frames: str = ""  # a video or a folder of images; default: the only one there
    name: str = ""
    weather: str = ""
    rate_hz: float | None = None  # of images without times
    speed_mps: float | None = None  # constant speed, if no table has it
    camera: CameraKeys = field(default_factory=CameraKeys)
    vehicle: VehicleKeys = field(default_factory=VehicleKeys)
    signals: SignalKeys | None = None  # default: signals.csv, if there is one

    def __post_init__(self) -> None:
        _check_letters(self.frames, self.name, self.weather)
        plausible.check_key("rate_hz", self.rate_hz)
        plausible.check_key("speed_mps", self.speed_mps, "speed_mps_held")


def _check_letters(*texts: str) -> None:
    """Refuse names that do not fit in one line of a message or table."""
    for text in texts:
        if not text.isprintable() or len(text) > LONGEST_NAME:
            raise ValueError(f"expected names of at most {LONGEST_NAME} printable letters, got {text[:40]!r}")


def load(path: Path) -> DriveFile:
    """The settings in the file; InputError of one line where it is wrong."""
    table = tables.read_file(path, "drive")
    columns = table.get("signals", {}).get("columns") if isinstance(table.get("signals"), dict) else None
    if isinstance(columns, dict):
        table["signals"]["columns"] = [[ours, theirs] for ours, theirs in columns.items()]
    return tables.build(DriveFile, table, str(path))
