"""Draw the moving pictures of README and docs, and write docs/gallery.md: `python scripts/gallery/draw.py`.

Each picture shows 2.6 seconds of a drive, about its least distance from another object or its sharpest turn. What is
drawn stays, with how the drive ended in drives.json; remove a picture, or give its name, to draw it again. Pictures of
all weathers at one pose are `vpf-sim weathers gallery`.
"""

import io
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import page
from PIL import Image as Picture  # comes with matplotlib

import vpf_sim
from vpf_sim import drivers
from vpf_sim.envs.contacts import solid_objects
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.evaluation.episode.episode import read, setup_for
from vpf_sim.geometry import unwrapped
from vpf_sim.reporting import overlay, top_view
from vpf_sim.reporting.canvas import Canvas
from vpf_sim.reporting.redraw import rectangle_of, scene_of
from vpf_sim.types import Image, Plan

FOLDER = page.DOCS / "pictures" / "gallery"
DRIVES = FOLDER / "drives.json"
RATE_HZ, STRIDE = 10.0, 6  # of the pictures; steps of a drive from one to the next
BEFORE_S, AFTER_S = 1.8, 0.8  # of the moment that is shown
ROWS = slice(90, 450)  # less sky, and 16:9
CAMERA_PX, ABOVE_PX = (320, 180), (100, 180)
QUALITY = 32  # of WebP


@dataclass(frozen=True, slots=True)
class Moving:
    """How a drive becomes a moving picture."""

    camera_px: tuple[int, int] = CAMERA_PX
    beside: bool = (
        False  # the camera's frame stands beside what the driver makes of it, in place of the road from above
    )
    shown_s: tuple[float, float] | None = None
    quality: int = QUALITY


README = page.Shown("town04-rain", "town04", "rain", "vpf")
OF_README = Moving((480, 270), beside=True, shown_s=(2.5, 7.5))


def driven(shown: page.Shown) -> vpf_sim.Episode:
    """The first drive that arrives, of a few seeds; the first drive if none does."""
    first = None
    for seed in shown.seeds:
        episode = vpf_sim.drive(shown.scenario, driver=shown.driver, weather=shown.weather, seed=seed)
        if episode.status == "success":
            return episode
        first = first or episode
    assert first is not None
    return first


def rows_of(steps: Any, shown_s: tuple[float, float] | None) -> range:
    """The steps to draw."""
    clearance_m = steps["clearance_m"].to_numpy()
    turning = np.abs(np.gradient(unwrapped(steps["yaw_rad"].to_numpy())))
    moment = int(np.argmin(clearance_m) if np.isfinite(clearance_m).any() else np.argmax(turning))
    hz = STRIDE * RATE_HZ
    first_s, last_s = shown_s or (moment / hz - BEFORE_S, moment / hz + AFTER_S)
    last = min(round(last_s * hz), len(steps) - 1)
    return range(max(last - round((last_s - first_s) * hz), 0), last, STRIDE)


def shots(episode: vpf_sim.Episode, moving: Moving) -> Iterator[Image]:
    """The pictures of an episode, which is driven again, with frames where they are needed."""
    record, rows = episode.record, rows_of(episode.steps, moving.shown_s)
    env, driver = FourLane(record["scenario"], record["weather"]), drivers.create(record["driver"])
    observed, _ = env.reset(seed=record["seed"])
    driver.reset(setup_for(driver, env, record["seed"]))
    trail = []
    for row in range(rows.stop):
        observation = read(observed)
        command = drivers.command_of(driver, observation)
        trail.append((observation.x_m, observation.y_m))
        if row in rows:
            yield picture(env, observation.image, drivers.trace_of(driver), np.array(trail), moving)
        needed = row + 1 in rows or (drivers.uses_images(driver) and drivers.needs_next_frame(driver))
        observed = env.step(np.array([command.throttle, command.steering]), with_frame=needed)[0]


def picture(env: Any, image: Image, plan: Plan | None, trail_m: Any, moving: Moving) -> Image:
    """(H, W, 3) what is seen, beside the road from above."""
    drawn = image if plan is None else overlay.draw(image, plan, env.camera)
    if moving.beside:
        return np.hstack([small(image, "camera", moving), small(drawn, "driver", moving)])
    pose = np.array([*trail_m[-1], env.ego.heading])
    objects = tuple(rectangle_of(one) for one in solid_objects(env.ego))
    above = top_view.draw(scene_of(env), objects, trail_m, pose, None, *ABOVE_PX)
    return np.hstack([small(drawn, "", moving), above])


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
    episode = driven(shown)
    target.write_bytes(webp([*shots(episode, moving)], moving.quality))
    record = episode.record
    time_s = round(float(episode.steps["time_s"].iloc[-1]), 1)
    return page.Drive(record["seed"], record["status"], record["collided_with"] or "", time_s)


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
