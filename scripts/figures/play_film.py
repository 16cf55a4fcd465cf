"""Film `vpf-sim play`: `python scripts/figures/play_film.py docs/pictures/play.webp`.

The window, its keys and the ghost are those of the command; SDL draws in memory, so no display is needed. Keys are held
as a person would who follows the ghost's path.
"""

import os
import sys
from math import atan, hypot
from pathlib import Path
from unittest.mock import patch

import cv2
import numpy as np
import pygame
from gallery import RATE_HZ, webp

import vpf_sim
from vpf_sim import DriverSetup, Observation
from vpf_sim.drivers import keyboard
from vpf_sim.reporting.play_view import Ghost, PlayView
from vpf_sim.types import Image

SCENARIO, WEATHER, SEED, GHOST = "town04", "rain", 3, "expert"
SHOWN_S, OVERLAY_S = (3.0, 9.0), 6.0
SIZE_PX, QUALITY = (400, 300), 30
AHEAD_M = 7.0  # to the place on the ghost's path that the person steers to
SPEEDS_MPS = (4.3, 4.8)  # the slower person has the ghost ahead
LEAST_TURN = 0.12  # of the wheel, for which a key is pressed


class Filmed(PlayView):
    """The view, filmed, and a person at its keys."""

    def __init__(self, ghost: Ghost) -> None:
        super().__init__("vpf", ghost)
        self.pictures: list[Image] = []
        self._path_m = np.array(ghost.steps.positions_m)
        self._held: set[int] = set()

    def reset(self, setup: DriverSetup) -> None:
        super().reset(setup)
        self._hands = keyboard.Hands(setup.vehicle)
        self._vehicle = setup.vehicle

    def picture(self, observation: Observation) -> Image:
        """The picture; the keys that it makes a person press are posted."""
        made = super().picture(observation)
        first_s, last_s = SHOWN_S
        if first_s + len(self.pictures) / RATE_HZ <= observation.time_s < last_s:
            self.pictures.append(np.asarray(cv2.resize(made, SIZE_PX, interpolation=cv2.INTER_AREA), np.uint8))
        wheel = self._wanted_wheel(observation)
        self._hold(
            {
                pygame.K_UP: observation.speed_mps < SPEEDS_MPS[0],
                pygame.K_DOWN: observation.speed_mps > SPEEDS_MPS[1],
                pygame.K_LEFT: wheel < -LEAST_TURN,
                pygame.K_RIGHT: wheel > LEAST_TURN,
                pygame.K_o: observation.time_s >= OVERLAY_S,
            }
        )
        return made

    def _wanted_wheel(self, observation: Observation) -> float:
        """How far the wheel should be turned towards the path ahead, [-1, 1] and beyond."""
        x_m, y_m = (self._path_m - observation.pose[:2]).T
        c, s = np.cos(observation.yaw_rad), np.sin(observation.yaw_rad)
        ahead_m, right_m = c * x_m + s * y_m, c * y_m - s * x_m
        place = int(np.argmin(np.abs(np.hypot(ahead_m, right_m) - AHEAD_M) + 1e3 * (ahead_m < 0.0)))
        curvature = 2.0 * right_m[place] / hypot(ahead_m[place], right_m[place]) ** 2
        angle_rad = atan(self._vehicle.wheelbase_m * curvature)
        full = self._hands.full_steering(observation.speed_mps) * self._vehicle.steering_limit_rad
        return float(angle_rad / full)

    def _hold(self, wanted: dict[int, bool]) -> None:
        for key, is_down in wanted.items():
            if is_down != (key in self._held):
                kind = pygame.KEYDOWN if is_down else pygame.KEYUP
                pygame.event.post(pygame.event.Event(kind, key=key))
                self._held ^= {key}


def main(target: Path) -> None:
    os.environ["SDL_VIDEODRIVER"] = "dummy"
    ghost = Ghost(GHOST, vpf_sim.drive(SCENARIO, driver=GHOST, weather=WEATHER, seed=SEED).result.steps)
    view = Filmed(ghost)
    with patch.object(keyboard, "require_display"):
        episode = vpf_sim.drive(SCENARIO, driver=keyboard.KeyboardDriver(view), weather=WEATHER, seed=SEED)
    target.write_bytes(webp(view.pictures, QUALITY))
    print(f"{episode.status}, {len(view.pictures)} pictures, {target.stat().st_size // 1000} kB in {target}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
