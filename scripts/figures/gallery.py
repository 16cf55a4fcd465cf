"""Draw the moving pictures of README and docs, and write docs/gallery.md: `python scripts/figures/gallery.py`.

Each picture shows 2.6 seconds of a drive, about its least distance from another object or its sharpest turn. What is
drawn stays, with how the drive ended in drives.json; remove a picture, or give its name, to draw it again. Pictures of
all weathers at one pose are `vpf-sim weathers gallery`.
"""

import io
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from pathlib import Path

import cv2
import gallery_page as page
import numpy as np
from PIL import Image as Picture  # comes with matplotlib

import vpf_sim
from vpf_sim import drivers
from vpf_sim.evaluation.episode.episode import EpisodeResult
from vpf_sim.evaluation.steps import StepTable
from vpf_sim.geometry import unwrapped
from vpf_sim.reporting import overlay, top_view
from vpf_sim.reporting.canvas import Canvas
from vpf_sim.reporting.redraw import Moment, Redrawing
from vpf_sim.system import one_thread
from vpf_sim.types import Image

FOLDER = page.DOCS / "pictures" / "gallery"
DRIVES = FOLDER / "drives.json"
RATE_HZ, STRIDE = 10.0, 6  # of the pictures; steps of a drive from one to the next
BEFORE_S, AFTER_S = 1.8, 0.8  # of the moment that is shown
ROWS = slice(90, 450)  # less sky, and 16:9
CAMERA_PX, ABOVE_PX = (288, 162), (90, 162)
QUALITY = 28  # of WebP


@dataclass(frozen=True, slots=True)
class Moving:
    """How a drive becomes a moving picture."""

    camera_px: tuple[int, int] = CAMERA_PX
    beside: bool = (
        False  # the camera's frame stands beside what the driver makes of it, in place of the road from above
    )
    shown_s: tuple[float, float] | None = None
    quality: int = QUALITY


README = page.Shown("town04-rain", "town04", "rain", ("vpf",))
OF_README = Moving((480, 270), beside=True, shown_s=(2.5, 7.5), quality=40)


def rows_of(table: StepTable, shown_s: tuple[float, float] | None) -> range:
    """The rows to draw."""
    turning = np.abs(np.gradient(unwrapped(table.yaw_rad[:-1])))
    clearance_m = table.clearance_m[:-1]
    moment = int(np.argmin(clearance_m) if np.isfinite(clearance_m).any() else np.argmax(turning))
    hz, commands = STRIDE * RATE_HZ, len(clearance_m)
    first_s, last_s = shown_s or (moment / hz - BEFORE_S, moment / hz + AFTER_S)
    count = min(round((last_s - first_s) * hz), commands)
    first = min(max(round(first_s * hz), 0), commands - count)
    return range(first - first % STRIDE, first + count, STRIDE)


def arriving(shown: page.Shown) -> EpisodeResult:
    """The first drive that arrives; the first drive if none does."""
    first = None
    for name, seed in product(shown.drivers, shown.seeds):
        blind = not drivers.uses_images(drivers.create(name))  # drives the same in every weather of the catalog
        done = driven(shown.scenario, "clear" if blind else shown.weather, name, seed)
        if done.record.succeeded:
            return done
        first = first or done
    assert first is not None
    return first


@lru_cache(1)
def driven(scenario: str, weather: str, name: str, seed: int) -> EpisodeResult:
    """A drive."""
    return vpf_sim.drive(scenario, driver=name, weather=weather, seed=seed).result


def shots(shown: page.Shown, done: EpisodeResult, moving: Moving) -> Iterator[Image]:
    """The pictures of a drive, in the weather to be shown."""
    record = done.record.model_copy(update={"weather": shown.weather})
    drawn, rows = Redrawing(record, done.steps, replan=True), rows_of(done.steps, moving.shown_s)
    for moment in drawn.moments():
        if moment.index in rows:
            yield picture(drawn, moment, moving)
        if moment.index >= rows[-1]:
            return


def picture(drawn: Redrawing, moment: Moment, moving: Moving) -> Image:
    """(H, W, 3) the driver's view, beside the road from above."""
    view = overlay.draw(moment.image, moment.plan, drawn.camera)
    if moving.beside:
        return np.hstack([small(moment.image, "camera", moving), small(view, "driver", moving)])
    table, now = drawn.table, moment.index
    trail, pose = table.positions_m[: now + 1], np.array([*table.positions_m[now], table.yaw_rad[now]])
    above = top_view.draw(drawn.scene, moment.objects, trail, pose, None, *ABOVE_PX)
    return np.hstack([small(view, "", moving), above])


def small(image: Image, words: str, moving: Moving) -> Image:
    """An image with less sky, smaller, and named."""
    made = np.ascontiguousarray(cv2.resize(image[ROWS], moving.camera_px, interpolation=cv2.INTER_AREA))
    if words:
        Canvas(made, vpf_sim.Camera()).text(words, 8.0, moving.camera_px[1] - 10.0, size=0.7)
    return made


def webp(pictures: Sequence[Image], quality: int) -> bytes:
    """An animation that repeats, of (H, W, 3) RGB pictures."""
    first, *others = (Picture.fromarray(one) for one in pictures)
    target = io.BytesIO()
    timing = {"duration": round(1000.0 / RATE_HZ), "loop": 0}
    first.save(target, "webp", save_all=True, append_images=others, quality=quality, **timing)
    return target.getvalue()


def draw(shown: page.Shown, target: Path, moving: Moving) -> page.Drive:
    """Write the picture, and return the drive that it shows."""
    with one_thread():
        done = arriving(shown)
        target.write_bytes(webp([*shots(shown, done, moving)], moving.quality))
    record = done.record
    time_s = round(float(done.steps.time_s[-1]), 1)
    return page.Drive(record.driver, record.seed, record.status, record.collided_with or "", time_s)


def main(names: Sequence[str]) -> None:
    FOLDER.mkdir(parents=True, exist_ok=True)
    drives = page.stored(DRIVES)
    for shown in page.everything():
        target = FOLDER / shown.file
        if shown.name in names or shown.name not in drives or not target.exists():
            drives[shown.name] = draw(shown, target, Moving())
            page.store(DRIVES, drives)
            print(f"{shown.name}: {drives[shown.name].status}, {target.stat().st_size // 1000} kB", flush=True)
    readme = page.DOCS / "pictures" / README.file
    if README.name in names or not readme.exists():
        draw(README, readme, OF_README)
    page.PAGE.write_text(page.text(drives), "utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
