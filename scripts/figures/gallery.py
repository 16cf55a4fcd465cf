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
from typing import Any

import cv2
import gallery_page as page
import numpy as np
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
from vpf_sim.system import one_thread
from vpf_sim.types import Image, Plan

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


@dataclass(slots=True)
class Driven:
    """A drive, to be played again."""

    drive: page.Drive
    commands: list[Any]  # (2,) throttle and steering
    plans: dict[int, Plan | None]  # by row, of each row that may be drawn
    clearance_m: list[float]
    yaw_rad: list[float]

    def rows(self, shown_s: tuple[float, float] | None) -> range:
        """The rows to draw."""
        turning = np.abs(np.gradient(unwrapped(np.array(self.yaw_rad))))
        moment = int(np.argmin(self.clearance_m) if np.isfinite(self.clearance_m).any() else np.argmax(turning))
        hz = STRIDE * RATE_HZ
        first_s, last_s = shown_s or (moment / hz - BEFORE_S, moment / hz + AFTER_S)
        count = min(round((last_s - first_s) * hz), len(self.commands))
        first = min(max(round(first_s * hz), 0), len(self.commands) - count)
        return range(first - first % STRIDE, first + count, STRIDE)


def arriving(shown: page.Shown) -> Driven:
    """The first drive that arrives; the first drive if none does."""
    first = None
    for name, seed in product(shown.drivers, shown.seeds):
        blind = not drivers.uses_images(drivers.create(name))  # drives the same in every weather of the catalog
        done = driven(shown.scenario, "clear" if blind else shown.weather, name, seed)
        if done.drive.status == "success":
            return done
        first = first or done
    assert first is not None
    return first


@lru_cache(1)
def driven(scenario: str, weather: str, name: str, seed: int) -> Driven:
    """A drive, with the frames that the driver uses."""
    driver = drivers.create(name)
    uses_images = drivers.uses_images(driver)
    env = FourLane(scenario, weather, frames=uses_images)
    observed, info = env.reset(seed=seed)
    driver.reset(setup_for(driver, env, seed))
    commands, plans, clearance_m, yaw_rad, over = [], {}, [], [], False
    while not over:
        observation = read(observed)
        command = drivers.command_of(driver, observation)
        if len(commands) % STRIDE == 0:
            plans[len(commands)] = drivers.trace_of(driver)
        clearance_m.append(info["clearance_m"])
        yaw_rad.append(observation.yaw_rad)
        commands.append(np.array([command.throttle, command.steering]))
        with_frame = uses_images and drivers.needs_next_frame(driver)
        observed, _, terminated, truncated, info = env.step(commands[-1], with_frame=with_frame)
        over = terminated or truncated
    time_s = round(float(observed["time"][0]), 1)
    drive = page.Drive(name, seed, info["status"], info.get("collided_with") or "", time_s)
    return Driven(drive, commands, plans, clearance_m, yaw_rad)


def shots(shown: page.Shown, done: Driven, moving: Moving) -> Iterator[Image]:
    """The pictures of a drive, which is played again, with frames where they are needed."""
    env, rows, trail = FourLane(shown.scenario, shown.weather), done.rows(moving.shown_s), []
    observed, _ = env.reset(seed=done.drive.seed)
    for row in range(rows.stop):
        trail.append(env.ego.position.copy())
        if row in rows:
            yield picture(env, observed["image"], done.plans[row], np.array(trail), moving)
        observed = env.step(done.commands[row], with_frame=row + 1 in rows)[0]


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
    with one_thread():
        done = arriving(shown)
        target.write_bytes(webp([*shots(shown, done, moving)], moving.quality))
    return done.drive


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
