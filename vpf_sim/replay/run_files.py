"""Paths of a drive's files in the folder of a replay."""

from pathlib import Path

from vpf_sim.files import file_name

FRAMES, VIDEOS = "frames", "videos"


def table_path(folder: Path, drive: str) -> Path:
    """The table of a drive's frames."""
    return folder / FRAMES / f"{file_name(drive)}.parquet"


def video_path(folder: Path, drive: str) -> Path:
    """The video of a drive."""
    return folder / VIDEOS / f"{file_name(drive)}.mp4"
