"""Settings in drive.toml for a recording of your own; docs/recordings.md explains each key."""

from pathlib import Path
from typing import Literal

from vpf_sim import configuration
from vpf_sim.configuration import setting, settings
from vpf_sim.replay import plausible
from vpf_sim.replay.assemble import CAMERA_AHEAD_M, WHEELBASE_M

LONGEST_NAME = 200
LeftPositive = Literal["steering", "yaw_rate", "yaw", "y"]


@settings
class CameraKeys:
    """The camera's calibration and mounting."""

    fx_px: float | None = setting("Focal length across.", default=None)
    fy_px: float | None = setting("Focal length down; by default `fx_px`.", default=None)
    cx_px: float | None = setting("Column of the optical axis; by default the middle.", default=None)
    cy_px: float | None = setting("Row of the optical axis; by default the middle.", default=None)
    field_of_view_deg: float | None = setting("Angle of view across, in place of `fx_px`.", default=None)
    distortion: tuple[float, ...] = setting("Coefficients of OpenCV's lens model.", default=())
    model: Literal["pinhole", "fisheye"] = setting("Kind of the lens.", default="pinhole")
    height_m: float | None = setting("Height of the camera above the road.", default=None)
    pitch_deg: float | None = setting(
        "Pitch of the camera, positive where it looks down; estimated by default.", default=None
    )
    yaw_deg: float | None = setting(
        "Yaw of the camera, positive where it looks right; estimated by default.", default=None
    )
    roll_deg: float | None = setting("Roll of the camera, positive clockwise; estimated by default.", default=None)
    ahead_of_rear_axle_m: float = setting("Distance of the camera ahead of the rear axle.", default=CAMERA_AHEAD_M)

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


@settings
class VehicleKeys:
    """The recorded car; full throttle and brake are those of the driver's model."""

    wheelbase_m: float = setting("Distance between the axles.", default=WHEELBASE_M)
    steering_ratio: float | None = setting("Angle of the steering wheel over that of the road wheels.", default=None)

    def __post_init__(self) -> None:
        plausible.check_key("wheelbase_m", self.wheelbase_m)
        plausible.check_key("steering_ratio", self.steering_ratio)


@settings
class SignalKeys:
    """The table of signals; `columns` maps our names to the names in the table."""

    file: str = setting("File of the table of signals.", default="signals.csv")
    offset_s: float = setting("Time added to the times of the table: the first frame is at 0.", default=0.0)
    left_is_positive: tuple[LeftPositive, ...] = setting("Signals that grow to the left.", default=())
    columns: dict[str, str] = setting("Our name of each column and its name in the table.", default_factory=dict)

    def __post_init__(self) -> None:
        plausible.check_key("offset_s", self.offset_s)
        _check_letters(self.file, *self.columns, *self.columns.values())


@settings
class DriveFile:
    """The whole file."""

    schema: Literal[1]
    frames: str = setting("Video or folder of pictures; by default the only one there is.", default="")
    name: str = setting("Name of the drive in messages and tables.", default="")
    weather: str = setting("Weather of the drive, in your own words.", default="")
    rate_hz: float | None = setting("Frames a second of pictures without times.", default=None)
    speed_mps: float | None = setting("Speed that was held, where no table has it.", default=None)
    camera: CameraKeys = setting("Calibration and mounting of the camera.", default=CameraKeys())
    vehicle: VehicleKeys = setting("The recorded car.", default=VehicleKeys())
    signals: SignalKeys | None = setting("Table of signals; by default signals.csv, if there is one.", default=None)

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
    """The file as it was written; what is wrong with it is an InputError of one line."""
    return configuration.build(DriveFile, configuration.read_file(path, "drive"), str(path))
