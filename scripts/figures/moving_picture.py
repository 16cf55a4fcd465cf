"""Draw the README's moving picture: the camera's frames beside what the driver detects and plans.

python scripts/figures/moving_picture.py docs/pictures/town04-rain.webp
"""

import io
import sys
from pathlib import Path

import cv2
import numpy as np
from PIL import Image as Picture  # comes with matplotlib

from vpf_sim.evaluation.episode import episode
from vpf_sim.reporting import overlay
from vpf_sim.reporting.canvas import Canvas
from vpf_sim.types import Camera, Image, Plan

SCENARIO, WEATHER, DRIVER, SEED = "town04", "rain", "vpf", 3
SHOWN_S = (2.0, 8.0)  # the approach to a parked car, until the car is past it
EPISODE_HZ, RATE_HZ = 60.0, 10.0
HALF_PX = (480, 270)  # of each of the two pictures
ROWS = slice(90, 450)  # less sky, and 16:9
QUALITY = 50


class Recorder:
    """Keeps the pictures of the shown seconds while an episode runs."""

    def __init__(self) -> None:
        self.pictures: list[Image] = []
        self._camera = Camera()
        self._frame = 0

    def watch(self, frame: Image, plan: Plan | None) -> None:
        """Take one of the episode's frames, with the plan that the driver makes of it."""
        time_s = self._frame / EPISODE_HZ
        is_due = self._frame % round(EPISODE_HZ / RATE_HZ) == 0
        if plan is not None and is_due and SHOWN_S[0] <= time_s < SHOWN_S[1]:
            self.pictures.append(self._beside(frame, overlay.draw(frame, plan, self._camera)))
        self._frame += 1

    def _beside(self, *pictures: Image) -> Image:
        halves = []
        for picture, words in zip(pictures, ("camera", "driver"), strict=True):
            half = np.ascontiguousarray(cv2.resize(picture[ROWS], HALF_PX, interpolation=cv2.INTER_AREA))
            Canvas(half, self._camera).text(words, 8.0, HALF_PX[1] - 10.0, size=0.7)
            halves.append(half)
        return np.hstack(halves)


def webp(pictures: list[Image]) -> bytes:
    """An animation that repeats, of (H, W, 3) RGB pictures."""
    first, *others = (Picture.fromarray(picture) for picture in pictures)
    target = io.BytesIO()
    duration_ms = round(1000.0 / RATE_HZ)
    first.save(target, "webp", save_all=True, append_images=others, duration=duration_ms, loop=0, quality=QUALITY)
    return target.getvalue()


def main() -> None:
    recorder = Recorder()
    episode.run(SCENARIO, WEATHER, DRIVER, SEED, recorder.watch)
    target = Path(sys.argv[1])
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(webp(recorder.pictures))


if __name__ == "__main__":
    main()
