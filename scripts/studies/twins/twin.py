"""Recordings and their rendered twins, both read from a folder with the same keys, so that both are replayed alike."""

from collections.abc import Iterable
from dataclasses import replace
from math import degrees
from pathlib import Path

import numpy as np
import reference_streets
from street import Street

from vpf_sim.envs.camera import weather as weathers
from vpf_sim.errors import InputError
from vpf_sim.files import write_bytes, write_text
from vpf_sim.gallery.poses import ScriptedDrive
from vpf_sim.replay import readers, video_file
from vpf_sim.replay.recording import Recording
from vpf_sim.reporting.kit.clip import jpeg
from vpf_sim.types import Camera, Image

JPEG_QUALITY = 95
SIGNALS = ("speed_mps", "yaw_rate_radps", "lead_gap_m")


def recorded(drive: Path, scratch: Path) -> Recording:
    """The recorded drive; an unknown camera and speed are those estimated for its street, noted in `scratch`."""
    street = street_of(drive.name)
    if street.camera is None:
        return readers.read(drive)
    videos = [path.resolve() for path in drive.glob("*") if path.suffix in video_file.SUFFIXES]
    if len(videos) != 1:
        raise InputError(f"{drive}: expected one video, found {len(videos)}")
    scratch.mkdir(parents=True)
    _write_toml(scratch, street.camera, frames=str(videos[0]), speed_mps=street.speed_mps)
    return replace(readers.read(scratch), name=drive.name)


def rendered(recording: Recording, seed: int, folder: Path) -> Recording:
    """The twin of a recording, rendered into a new folder of frames and signals."""
    street = street_of(recording.name)
    known = bool(np.isfinite(recording.lead_gap_m).all())
    drive = street.drive(
        recording.camera, recording.rate_hz, recording.speed_mps, recording.lead_gap_m if known else None
    )
    images = (shot.image for shot in drive.shots(weathers.load(street.weather), seed, len(recording)))
    write(folder, drive, images, recording, street)
    return replace(readers.read(folder), name=f"{recording.name}-twin-{seed}")


def street_of(name: str) -> Street:
    """The street of a drive."""
    if name not in reference_streets.STREETS:
        raise InputError(f"{name}: expected a drive with a street, {', '.join(reference_streets.STREETS)}")
    return reference_streets.STREETS[name]


def write(folder: Path, drive: ScriptedDrive, images: Iterable[Image], recording: Recording, street: Street) -> None:
    """Write the twin's frames, and the signals that the recording has; the road is straight."""
    frames = folder / "images"
    frames.mkdir(parents=True)
    for number, image in enumerate(images):
        write_bytes(frames / f"{number:06d}.jpg", jpeg(image, JPEG_QUALITY))
    _write_toml(folder, drive.rig.camera, frames="images", rate_hz=drive.rate_hz, speed_mps=street.speed_mps)
    if street.speed_mps is None:
        straight = replace(recording, yaw_rate_radps=np.zeros(len(recording)))
        columns = [straight.times_s, *(getattr(straight, name) for name in SIGNALS)]
        rows = (",".join(f"{value:.9f}" for value in row) for row in zip(*columns, strict=True))
        write_text(folder / "signals.csv", "\n".join([",".join(("time_s", *SIGNALS)), *rows]) + "\n")


def _write_toml(folder: Path, camera: Camera, frames: str, **keys: float | None) -> None:
    """Write drive.toml with a camera that looks straight ahead."""
    lines = ["schema = 1", f"frames = '{frames}'"]
    lines += [f"{key} = {value!r}" for key, value in keys.items() if value is not None]
    lines += ["[camera]", *(f"{key} = {getattr(camera, key)!r}" for key in ("fx_px", "fy_px", "cx_px", "cy_px"))]
    lines += [f"height_m = {camera.height_m!r}", f"pitch_deg = {degrees(camera.pitch_rad)!r}", "yaw_deg = 0.0"]
    lines += [f"distortion = [{camera.k1!r}, {camera.k2!r}]"]
    write_text(folder / "drive.toml", "\n".join(lines) + "\n")
