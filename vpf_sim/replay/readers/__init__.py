"""Readers of recordings, and the choice of one for a folder."""

from dataclasses import replace
from pathlib import Path

from vpf_sim.errors import InputError
from vpf_sim.replay import video_file
from vpf_sim.replay.readers import comma2k19, general, kitti_odometry, kitti_raw, lidar_labels, radiate, udacity
from vpf_sim.replay.recording import Reader, Recording

# The first that recognises a folder reads it; the simplest layouts come last.
READERS: tuple[Reader, ...] = (general, comma2k19, kitti_raw, radiate, udacity, lidar_labels, kitti_odometry)


def read(folder: Path | str) -> Recording:
    """The recording in `folder`; InputError of one line where it is wrong.

    A video, or a folder with nothing else, is read too; its camera is assumed or estimated.
    """
    folder = Path(folder)
    if folder.is_file():
        _check_is_video(folder)
        return general.read_video(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: expected the folder of a drive, found nothing")
    for reader in READERS:
        if reader.recognises(folder):
            return reader.read(folder)
    videos = [path for path in folder.iterdir() if path.suffix.lower() in video_file.SUFFIXES]
    if len(videos) == 1:
        return replace(general.read_video(videos[0]), name=folder.resolve().name)
    found = ", ".join(sorted(path.name for path in folder.iterdir())[:8]) or "nothing"
    expected = "; or ".join(f"{reader.LAYOUT}: {reader.EXPECTED}" for reader in READERS)
    video = f"or one video that ends in {' '.join(video_file.CONTAINERS)}"
    raise InputError(f"{folder}: found {found}; expected one of {expected}; {video}")


def _check_is_video(file: Path) -> None:
    """Refuse files that are no video, with what is expected."""
    if file.suffix.lower() in video_file.SUFFIXES:
        return
    try:
        video_file.read(file)
    except InputError:
        endings = " ".join(video_file.CONTAINERS)
        wanted = f"expected the folder of a drive, or a video such as {endings}"
        raise InputError(f"{file}: {wanted}; found a file that does not open as one") from None
