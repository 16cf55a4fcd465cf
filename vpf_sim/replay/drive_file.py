"""drive.toml: what someone tells of a recording of their own. docs/recordings.md explains each key."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from vpf_sim import configuration
from vpf_sim.replay import plausible
from vpf_sim.replay.assemble import CAMERA_AHEAD_M, WHEELBASE_M

LONGEST_NAME = 200
Sided = Literal["steering", "yaw_rate", "yaw", "y"]


@dataclass(frozen=True, slots=True)
class CameraKeys:
    """Angles: pitch + looks down, yaw + looks right, roll + clockwise; left out they are found on the way."""

    fx_px: float | None = None
    fy_px: float | None = None  # left out: as fx_px
    cx_px: float | None = None  # left out: the middle
    cy_px: float | None = None
    field_of_view_deg: float | None = None  # across, instead of fx_px
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
            plausible.key(name, getattr(self, name))
        for name, limit in {
            "fx_px": "focal_px",
            "fy_px": "focal_px",
            "cx_px": "centre_px",
            "cy_px": "centre_px",
        }.items():
            plausible.key(name, getattr(self, name), limit)
        for coefficient in self.distortion:
            plausible.key("distortion", coefficient)
        if self.model == "fisheye" and len(self.distortion) != 4:
            raise ValueError(f"distortion: expected the 4 numbers of a fisheye, got {len(self.distortion)}")
        if self.model == "pinhole" and len(self.distortion) not in (0, 1, 2, 4, 5, 8):
            raise ValueError(f"distortion: expected 2, 4, 5 or 8 numbers, got {len(self.distortion)}")
        angles = [angle is None for angle in (self.pitch_deg, self.yaw_deg)]
        if any(angles) and not all(angles):
            raise ValueError("pitch_deg, yaw_deg: expected both or neither")


@dataclass(frozen=True, slots=True)
class VehicleKeys:
    """The recorded car; its full scales stay those of the driver's model."""

    wheelbase_m: float = WHEELBASE_M
    steering_ratio: float | None = None  # steering wheel over road wheels

    def __post_init__(self) -> None:
        plausible.key("wheelbase_m", self.wheelbase_m)
        plausible.key("steering_ratio", self.steering_ratio)


@dataclass(frozen=True, slots=True)
class SignalKeys:
    """The table of signals. `columns` says how those are called whose names are not ours."""

    file: str = "signals.csv"
    offset_s: float = 0.0  # added to the table's times: the first frame is at 0
    left_is_positive: tuple[Sided, ...] = ()
    columns: tuple[tuple[str, str], ...] = ()  # (our name, the table's name)

    def __post_init__(self) -> None:
        plausible.key("offset_s", self.offset_s)
        _check_letters(self.file, *(name for pair in self.columns for name in pair))


@dataclass(frozen=True, slots=True)
class DriveFile:
    """The whole file."""

    schema: Literal[1]
    frames: str = ""  # a video or a folder of pictures; left out, the only one there is
    name: str = ""
    weather: str = ""
    rate_hz: float | None = None  # of pictures without times
    speed_mps: float | None = None  # if it was held, and no table has it
    camera: CameraKeys = field(default_factory=CameraKeys)
    vehicle: VehicleKeys = field(default_factory=VehicleKeys)
    signals: SignalKeys | None = None  # left out: signals.csv, if there is one

    def __post_init__(self) -> None:
        _check_letters(self.frames, self.name, self.weather)
        plausible.key("rate_hz", self.rate_hz)
        plausible.key("speed_mps", self.speed_mps, "speed_mps_held")


def _check_letters(*texts: str) -> None:
    """Names stand in messages and tables, in a line each."""
    for text in texts:
        if not text.isprintable() or len(text) > LONGEST_NAME:
            raise ValueError(f"expected names of at most {LONGEST_NAME} printable letters, got {text[:40]!r}")


def load(path: Path) -> DriveFile:
    """The file as it was written; what is wrong with it is an InputError of one line."""
    table = configuration.read_file(path, "drive")
    columns = table.get("signals", {}).get("columns") if isinstance(table.get("signals"), dict) else None
    if isinstance(columns, dict):
        table["signals"]["columns"] = [[ours, theirs] for ours, theirs in columns.items()]
    return configuration.build(DriveFile, table, str(path))
