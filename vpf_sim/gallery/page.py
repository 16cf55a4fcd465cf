"""The gallery: images of every weather at fixed poses, a short video each, and a page."""

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from vpf_sim.envs.camera import Weather
from vpf_sim.errors import InputError
from vpf_sim.evaluation import pool
from vpf_sim.files import file_name, write_bytes, write_text
from vpf_sim.gallery.poses import POSES, SEED, Pose, video_drive
from vpf_sim.gallery.weather_meaning import aliases, factors, in_words
from vpf_sim.reporting.kit.clip import jpeg
from vpf_sim.reporting.kit.page import render
from vpf_sim.reporting.video import Writer, require
from vpf_sim.types import Image

QUALITY = 92  # of JPEG
LEAD_S, LEAD_HZ = (
    3.2,
    15.0,
)  # of the drive to a pose, on which rain wets the windscreen; it ends between two wiper sweeps
VIDEO_S, VIDEO_HZ = 5.0, 30.0


@dataclass(frozen=True, slots=True)
class Picture:
    caption: str
    file: str  # relative to the page


@dataclass(frozen=True, slots=True)
class Entry:
    """One weather."""

    name: str
    aliases: tuple[str, ...]
    meaning: str  # in one line of text
    factors: tuple[tuple[str, str, str], ...]  # name, value, meaning
    pictures: tuple[Picture, ...]  # one per pose, in the same order in every entry
    video: str


def page(entries: Sequence[Entry]) -> str:
    """The page as HTML, one row per weather and one column per pose."""
    return render("gallery.html.jinja", "vpf_sim.gallery", entries=entries)


def make(folder: Path, weathers: Sequence[Weather], workers: int, notify: Callable[[Entry], None]) -> Path:
    """Write the gallery into a new or empty folder; returns its page. On an exception the folder is removed."""
    require("gallery")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(f"{folder}: expected a new or empty folder for the gallery, got one with something in it")
    folder.mkdir(parents=True, exist_ok=True)
    tasks = list(enumerate(weathers))
    entries: dict[int, Entry] = {}
    try:
        for done in pool.run(partial(make_entry, folder), tasks, workers):
            if done.result is None:
                raise RuntimeError(f"the process that drew {done.task[1].name} died")
            entries[done.task[0]] = done.result
            notify(done.result)
        index = folder / "index.html"
        write_text(index, page([entries[number] for number, _ in tasks]))
    except BaseException:
        shutil.rmtree(folder)
        raise
    return index


def make_entry(folder: Path, task: tuple[int, Weather]) -> Entry:
    """Write the images and the video of one weather."""
    number, weather = task
    stem = f"{number + 1:02d}-{file_name(weather.name)}"
    pictures = []
    for pose in POSES:
        file = f"pictures/{stem}-{pose.name}.jpg"
        write_bytes(folder / file, jpeg(picture(pose, weather), QUALITY))
        pictures.append(Picture(pose.caption, file))
    video = f"videos/{stem}.mp4"
    _write_video(folder / video, weather)
    return Entry(weather.name, tuple(aliases(weather)), in_words(weather), factors(weather), tuple(pictures), video)


def picture(pose: Pose, weather: Weather) -> Image:
    """(H, W, 3) the frame at a pose, after a drive that wets the windscreen."""
    count = round(LEAD_S * LEAD_HZ) + 1
    *_, last = pose.drive(LEAD_S, LEAD_HZ).shots(weather, SEED, count)
    return last.image


def _write_video(path: Path, weather: Weather) -> None:
    drive = video_drive(VIDEO_HZ)
    camera = drive.rig.camera
    with Writer(path, (camera.width_px, camera.height_px), VIDEO_HZ) as writer:
        for shot in drive.shots(weather, SEED, round(VIDEO_S * VIDEO_HZ)):
            writer.write(shot.image)
