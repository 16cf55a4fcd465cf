"""Reader of your own recording: video or images, drive.toml, table of signals (docs/recordings.md)."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import radians
from pathlib import Path

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.replay import assemble, drive_file, image_files, video_file
from vpf_sim.replay.drive_file import CameraKeys, DriveFile, SignalKeys
from vpf_sim.replay.image_files import Frame
from vpf_sim.replay.readers import general_signals
from vpf_sim.replay.recording import Assumption, Origin, Recording
from vpf_sim.replay.rectify import Lens, Mounting
from vpf_sim.types import Floats

LAYOUT = "video or images with drive.toml"
EXPECTED = "drive.toml and a video or a folder of images, optionally signals.csv"
FILE = "drive.toml"
FOLDERS = ("image", "images", "frames")


@dataclass(frozen=True, slots=True)
class _FrameSource:
    """The frames of a recording before they are decoded."""

    size: tuple[int, int]
    times_s: Floats
    how: Origin  # origin of the times
    frames: Callable[[], Iterator[Frame]]
    names: tuple[str, ...]  # of the images; empty for a video
    notes: tuple[str, ...]
    files: Sequence[Path | None]


def recognises(folder: Path) -> bool:
    return (folder / FILE).exists()


def read(folder: Path) -> Recording:
    """The recording that drive.toml describes."""
    drive = drive_file.load(folder / FILE)
    return _recording(folder, drive, _find_frames(folder, drive))


def read_video(path: Path) -> Recording:
    """A video without further data."""
    drive = DriveFile(schema=1, frames=path.name)
    return replace(_recording(path.parent, drive, _from_video(path, drive)), name=path.stem)


def _recording(folder: Path, drive: DriveFile, source_frames: _FrameSource) -> Recording:
    keys, signals = drive.camera, drive.signals or SignalKeys()
    table = image_files.resolve(folder, signals.file)
    source = assemble.Source(
        name=drive.name or folder.resolve().name,
        layout=LAYOUT,
        times_s=source_frames.times_s,
        frames=source_frames.frames,
        lens=_lens(keys, source_frames.size),
        mounting=_mounting(keys),
        height_m=keys.height_m or assemble.HEIGHT_M,
        assumed=_assumed(keys),
        wheelbase_m=drive.vehicle.wheelbase_m,
        camera_ahead_m=keys.ahead_of_rear_axle_m,
        weather=drive.weather,
        notes=list(source_frames.notes),
        files=[*source_frames.files, *(path for path in (folder / FILE, table) if path.is_file())],
    )
    source.origins["camera"] = _camera_origin(keys, source.lens)
    source.origins["times_s"] = source_frames.how
    if drive.signals is not None or table.exists():
        general_signals.put(source, table, signals, drive.vehicle, source_frames.names)
    if drive.speed_mps is not None and "speed_mps" not in source.signals:
        held = np.full(len(source.times_s), drive.speed_mps)
        source.put("speed_mps", held, f"{FILE}: speed_mps, constant", "assumed")
    return assemble.recording(source)


def _find_frames(folder: Path, drive: DriveFile) -> _FrameSource:
    if drive.frames:
        path = image_files.resolve(folder, drive.frames)
        if path.is_dir():
            return _from_images(path, drive, folder)
        if not path.exists():
            raise InputError(f"{folder / FILE}: frames: expected a video or a folder of images, found no '{path}'")
        return _from_video(path, drive)
    videos = sorted(path for path in folder.iterdir() if path.suffix.lower() in video_file.SUFFIXES)
    folders = [folder / name for name in FOLDERS if (folder / name).is_dir()]
    found = [path.name for path in [*videos, *folders]]
    if len(found) != 1:
        listed = ", ".join(found) or "none"
        raise InputError(f"{folder / FILE}: frames is not set: expected one video or folder of images, found {listed}")
    return _from_images(folders[0], drive, folder) if folders else _from_video(videos[0], drive)


def _from_images(folder: Path, drive: DriveFile, drive_folder: Path) -> _FrameSource:
    """The images of a folder; `drive_folder` is that of drive.toml."""
    there = image_files.listed(folder)
    files: list[Path | None] = [*there]
    size = image_files.size(there, folder)
    notes: list[str] = []
    if (bits := image_files.used_bits(there)) < 16:
        notes.append(f"{folder.name}/: 16-bit images that use {bits} bits")
    names = tuple(file.name for file in there)
    times = general_signals.frame_times(drive_folder, drive.signals or SignalKeys(), names, notes)
    how = Origin("recorded", "the table's rows of the images")
    if times is None:
        if drive.rate_hz is None:
            wanted = "expected rate_hz, or a table with 'file' and 'time_s'"
            raise InputError(f"{drive_folder / FILE}: images have no times: {wanted}")
        files, missing = image_files.with_gaps(there)
        notes += [f"{folder.name}/: {note}" for note in missing]
        names = tuple(file.name if file else "" for file in files)
        times, how = np.arange(len(files)) / drive.rate_hz, Origin("recorded", f"{FILE}: rate_hz")
    return _FrameSource(
        size, times - times[0], how, lambda: image_files.frames(files, size), names, tuple(notes), files
    )


def _from_video(path: Path, drive: DriveFile) -> _FrameSource:
    video = video_file.read(path, rate_hz=drive.rate_hz)
    how = Origin("recorded", f"{path.name}" if drive.rate_hz is None else f"{FILE}: rate_hz")
    return _FrameSource((video.width_px, video.height_px), video.times_s, how, video.frames, (), video.notes, (path,))


def _lens(keys: CameraKeys, size: tuple[int, int]) -> Lens:
    width, height = size
    if keys.field_of_view_deg is None:  # along the longer side: an upright phone has the same lens
        across = 2.0 * float(np.arctan(width / max(size) * np.tan(0.5 * assemble.FIELD_OF_VIEW_RAD)))
    else:
        across = float(np.radians(keys.field_of_view_deg))
    lens = assemble.assumed_lens(width, height, across)
    fx = lens.fx_px if keys.fx_px is None else keys.fx_px
    return replace(
        lens,
        fx_px=fx,
        fy_px=fx if keys.fy_px is None else keys.fy_px,
        cx_px=lens.cx_px if keys.cx_px is None else keys.cx_px,
        cy_px=lens.cy_px if keys.cy_px is None else keys.cy_px,
        distortion=keys.distortion,
        model=keys.model,
    )


def _mounting(keys: CameraKeys) -> Mounting | None:
    """None: to be estimated."""
    if keys.pitch_deg is None or keys.yaw_deg is None:
        return None
    degrees = (keys.pitch_deg, keys.yaw_deg, keys.roll_deg or 0.0)
    pitch, yaw, roll = (radians(angle) for angle in degrees)
    return Mounting(pitch, yaw, roll, keys.height_m or assemble.HEIGHT_M)


def _assumed(keys: CameraKeys) -> frozenset[Assumption]:
    """What is not known of the camera."""
    unknown: dict[Assumption, bool] = {
        "lens": keys.fx_px is None and keys.field_of_view_deg is None,
        "height": keys.height_m is None,
    }
    return frozenset(name for name, is_unknown in unknown.items() if is_unknown)


def _camera_origin(keys: CameraKeys, lens: Lens) -> Origin:
    """What is set and what is assumed about the camera."""
    assumed, unknown = [], _assumed(keys)
    if "lens" in unknown:
        side = "across" if lens.width_px >= lens.height_px else "vertically"
        assumed.append(f"field of view {np.degrees(assemble.FIELD_OF_VIEW_RAD):.0f} deg {side}")
    if "height" in unknown:
        assumed.append(f"{assemble.HEIGHT_M:g} m above the road")
    if assumed:
        return Origin("assumed", f"{' and '.join(assumed)} assumed; f = {lens.fx_px:.0f} px")
    return Origin("recorded", f"{FILE}; f = {lens.fx_px:.0f} px")
