"""Solid or dashed: the share of its length over which a line is painted, whatever the contrast of its paint.

Paint that is there for a share d of the time, of contrast a, has the mean d a and the mean square d a^2: the square of
the one over the other is d. So a faint line, worn, far aside or under water, is told from one with gaps, and no
threshold of contrast is asked for. Mean and mean square are over the road that passes through stretches of the view,
each shorter than a dash, so that the fall of contrast with distance does not matter either.
"""

from dataclasses import dataclass

import numpy as np

from vpf_sim.perception.road.config import DashDutyConfig
from vpf_sim.perception.road.markings import RidgeMap
from vpf_sim.types import Bools, Floats


@dataclass(slots=True)
class DashDutyCycle:
    """Sums over the road that has passed, for L lines in B stretches of the view."""

    sums: Floats  # (5, L, B) weight; line, its square; background, its square
    config: DashDutyConfig
    travelled_m: float | None = None  # at the last look

    @classmethod
    def start(cls, lines: int, config: DashDutyConfig) -> "DashDutyCycle":
        return cls(np.zeros((5, lines, 0)), config)

    def look(self, ridges: RidgeMap, right_m: Floats, visible: Bools, travelled_m: float) -> None:
        """Take in the ridges of a frame at the lines' expected places (L, R), after so many metres in all."""
        view = ridges.view
        moved_m = 0.0 if self.travelled_m is None else travelled_m - self.travelled_m
        self.travelled_m = travelled_m
        stretch = ((view.forward_m - view.forward_m[0]) / self.config.stretch_m).astype(np.intp)
        member = np.eye(stretch[-1] + 1)[stretch]  # (R, B)
        if self.sums.shape[2] != member.shape[1]:
            self.sums = np.zeros((*self.sums.shape[:2], member.shape[1]))
        count = visible @ member  # (L, B)
        places_m = np.stack([right_m, right_m - self.config.beside_m, right_m + self.config.beside_m])
        line, left, right = _contrast(ridges, places_m, visible, member, count, self.config.reach_m)
        beside = 0.5 * (left + right)
        now = np.stack([np.ones_like(line), line, line**2, beside, beside**2])
        known = count >= 2
        keep = np.where(known, np.exp(-moved_m / self.config.memory_m), 1.0)
        seen_m = min(moved_m, self.config.stretch_m)  # after a gap in the looks, no more of the road than one shows
        self.sums = keep * self.sums + seen_m * np.where(known, now, 0.0)

    def duty(self) -> tuple[Floats, Bools]:
        """(L,) share of each line that is painted, 0 .. 1, and whether it is known."""
        weight = self.sums[0]
        enough = weight > self.config.memory_m * (1.0 - np.exp(-self.config.least_memory_m / self.config.memory_m))
        mean = self.sums[1:] / np.maximum(weight, 1e-9)
        line, square, beside, beside_square = mean
        paint = np.where(enough, np.maximum(line - beside, 0.0), 0.0)
        noise = np.maximum(beside_square - beside**2, 0.0)
        paint_square = np.maximum(square - 2.0 * line * beside + beside**2 - noise, paint**2)
        total = np.sum(np.where(enough, paint_square, 0.0), axis=1)
        strong = np.sum(paint**2, axis=1) > self.config.least_contrast**2 * np.count_nonzero(enough, axis=1)
        return np.sum(paint**2, axis=1) / np.maximum(total, 1e-9), strong & enough.any(axis=1)


def _contrast(
    ridges: RidgeMap, right_m: Floats, visible: Bools, member: Floats, count: Floats, reach_m: float
) -> Floats:
    """(S, L, B) mean ridge over each stretch, about each of S places (S, L, R), where within reach it is most."""
    view, response = ridges.view, ridges.response
    reach = round(reach_m / view.column_m)
    column = np.where(visible, np.rint((right_m - view.right_m[0]) / view.column_m), 0.0).astype(np.intp)
    about = column + np.arange(-reach, reach + 1)[:, None, None, None]  # (A, S, L, R)
    about = np.minimum(np.maximum(about, 0), response.shape[1] - 1)
    found = np.where(visible, response[np.arange(len(view.forward_m)), about], 0.0)
    most: Floats = (found @ member).max(axis=0) / np.maximum(count, 1.0)
    return most
