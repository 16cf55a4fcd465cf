"""Where the files of a drive lie in the folder of a replay; the name of the drive is anyone's text."""

from pathlib import Path

from vpf_sim.files import file_name

FRAMES, VIDEOS = "frames", "videos"


def table_file(folder: Path, drive: str) -> Path:
    """The table of a drive's frames."""
    return folder / FRAMES / f"{file_name(drive)}.parquet"


def film_file(folder: Path, drive: str) -> Path:
    """The film of a drive."""
    return folder / VIDEOS / f"{file_name(drive)}.mp4"
