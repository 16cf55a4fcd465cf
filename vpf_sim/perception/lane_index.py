"""Which lane this is: the lines repeat every lane's width, the edges of the carriageway do not.

A hypothesis n says that the true place is n lanes right of the one that is tracked. Each is judged by what kind of line
lies at every place (solid edges, dashed lines within, none outside) and by the ground between them: within the
carriageway it looks like the ego's own lane, outside mostly not, whatever its colour.
"""

from dataclasses import dataclass

import numpy as np

from vpf_sim.perception.birds_eye import BirdsEye
from vpf_sim.perception.line_search import RidgeMap, sight
from vpf_sim.perception.road_model import lines
from vpf_sim.types import Bools, Floats, Image

SOLID, DASHED, NONE = 0, 1, 2
# Share of the length on which a line of each kind is seen: mean and standard deviation. A body may hide any of it.
SHARES = np.array([[0.92, 0.12], [0.34, 0.12], [0.02, 0.06]])
# How much of its marks a road shows: wear, drops on the glass and bright water hide them on all lines alike.
PRESENCES = np.array([1.0, 0.75, 0.55])
SURPRISE = float(np.log(0.03))  # the least that one line can say, natural logarithm
HIDDEN = float(np.log(0.15))  # the least that a line can say by not being seen: something may stand before it
LEAST_LENGTH_M = 8.0  # of road in view, below which a line or a strip says nothing
LIKE_LEVELS = 14.0  # difference of colour at which ground is as likely another surface as the same
FORGET = 0.85  # of the evidence, kept from one judgement to the next
LINE_REACH_M = 0.2
# A lane is left for another that has been likelier for this share of the time it was followed, at most so many
# judgements: a frame's lines and ground stay in view for seconds, so judgements repeat each other's errors.
LASTING_SHARE, LASTING_MOST = 0.5, 40


@dataclass(slots=True)
class LaneIndex:
    """The log-probabilities of the hypotheses, gathered over time."""

    lanes: int
    lane_width_m: float
    log_odds: Floats  # (2 * lanes - 1,) n = -(lanes - 1) .. lanes - 1
    agreement: float | None  # 0 .. 1, how much of the expected lines is seen, lately; None before the first judgement
    followed: int = 0  # judgements since the lane was taken
    rival: int = 0  # shift to the lane that is likelier now, 0 none
    led: int = 0  # judgements in a row in which it was

    @classmethod
    def start(cls, lanes: int, lane_width_m: float) -> "LaneIndex":
        return cls(lanes, lane_width_m, np.zeros(2 * lanes - 1), None)

    @property
    def shifts(self) -> Floats:
        """(2 * lanes - 1,) lanes."""
        return np.arange(-(self.lanes - 1), self.lanes, dtype=float)

    def probabilities(self, y_m: float) -> Floats:
        """(2 * lanes - 1,) of the hypotheses; the pose is believed to be on the carriageway or just beside it."""
        possible = np.abs(y_m + self.shifts * self.lane_width_m) < 0.5 * self.lanes * self.lane_width_m + 0.5
        likely = np.where(possible, self.log_odds, -np.inf)
        if not possible.any():
            return np.full(len(likely), 1.0 / len(likely))
        weight = np.exp(likely - likely.max())
        return np.asarray(weight / weight.sum())

    def shift(self, lanes: int) -> None:
        """Count the hypotheses anew after the tracked place was moved by `lanes`."""
        moved = np.full_like(self.log_odds, float(self.log_odds.min()))
        for i in range(len(moved)):
            if 0 <= i + lanes < len(moved):
                moved[i] = self.log_odds[i + lanes]
        self.log_odds = moved
        self.agreement = None
        self.followed = self.rival = self.led = 0

    def is_lasting(self, rival: int) -> bool:
        """Whether the lane `rival` lanes off, likelier at this judgement (0: none is), has been so for long enough."""
        self.followed += 1
        self.led = self.led + 1 if rival == self.rival else 1
        self.rival = rival
        return rival != 0 and self.led >= min(LASTING_SHARE * self.followed, LASTING_MOST)

    def judge(self, state: Floats, ridges: RidgeMap, view: BirdsEye, colour: Image, colour_view: BirdsEye) -> None:
        """Take in one frame."""
        evidence = self._line_evidence(state, ridges, view) + self._ground_evidence(
            state, ridges, view, colour, colour_view
        )
        self.log_odds = FORGET * self.log_odds + evidence - evidence.max()

    def _places(self) -> Floats:
        """Lines right of the tracked centre line, three carriageways wide."""
        return np.asarray((np.arange(-self.lanes, 2 * self.lanes + 1) - 0.5 * self.lanes) * self.lane_width_m)

    def _line_evidence(self, state: Floats, ridges: RidgeMap, view: BirdsEye) -> Floats:
        places = self._places()
        right, _, reached = lines(state, places, view.forward_m)
        columns = np.rint((right - view.right_m[0]) / view.column_m)
        inside = reached & (columns >= 0) & (columns < ridges.response.shape[1])
        rows = np.arange(len(view.forward_m))[None, :]
        visible = inside & ridges.visible[rows, np.where(inside, columns, 0).astype(np.intp)]
        found = sight(ridges, view, right, visible, places, LINE_REACH_M, np.zeros(len(view.forward_m)))
        length = visible @ view.length_m
        share = (found.seen @ view.length_m) / np.maximum(length, 1e-9)
        mean, sigma = PRESENCES[:, None] * SHARES[:, 0], SHARES[:, 1]
        says = -0.5 * ((share[:, None, None] - mean) / sigma) ** 2 - np.log(sigma / sigma.max())
        least: Floats = np.asarray(np.where(share < 0.1, HIDDEN, SURPRISE), np.float64)
        says = np.maximum(says - says.max(axis=(1, 2), keepdims=True), least[:, None, None])
        says = np.where((length >= LEAST_LENGTH_M)[:, None, None], says, 0.0)
        self._compare(share, length >= LEAST_LENGTH_M)
        kinds = np.array(
            [[self._kind(j + int(n)) for j in range(-self.lanes, 2 * self.lanes + 1)] for n in self.shifts]
        )
        return np.asarray(says[np.arange(len(places)), :, kinds].sum(axis=1).max(axis=1))

    def _compare(self, share: Floats, known: Bools) -> None:
        """Note how much of the lines of the tracked hypothesis is seen."""
        inside = np.arange(self.lanes, 2 * self.lanes + 1)  # their places among all
        expected = np.array([SHARES[self._kind(line), 0] for line in range(self.lanes + 1)])
        seen = np.minimum(share[inside] / expected, 1.0)
        if known[inside].any():
            now = float(np.mean(seen[known[inside]]))
            self.agreement = now if self.agreement is None else FORGET * self.agreement + (1.0 - FORGET) * now

    def _kind(self, line: int) -> int:
        if line in (0, self.lanes):
            return SOLID
        return DASHED if 0 < line < self.lanes else NONE

    def _ground_evidence(
        self, state: Floats, ridges: RidgeMap, view: BirdsEye, colour: Image, colour_view: BirdsEye
    ) -> Floats:
        middles = self._places()[:-1] + 0.5 * self.lane_width_m
        offsets = (middles[:, None] + np.array([-0.2, 0.0, 0.2]) * self.lane_width_m).ravel()
        right, _, reached = lines(state, offsets, colour_view.forward_m)
        columns = np.rint((right - colour_view.right_m[0]) / colour_view.column_m)
        inside = reached & (columns >= 0) & (columns < len(colour_view.right_m))
        columns = np.where(inside, columns, 0).astype(np.intp)
        rows = np.arange(len(colour_view.forward_m))[None, :]
        inside &= (
            colour_view.visible[rows, columns] & ridges.visible[_nearest(view, colour_view)][rows, _across(view, right)]
        )
        sample = colour[rows, columns].astype(np.float64)
        shape = (len(middles), 3, len(colour_view.forward_m))
        weight = (inside * colour_view.length_m).reshape(shape)[..., None]
        own = int(np.clip(np.searchsorted(self._places(), state[0]) - 1, 0, len(middles) - 1))
        sample = sample.reshape(*shape, 3)
        reference = np.sum(sample[own] * weight[own], axis=0) / np.maximum(weight[own].sum(axis=0), 1e-9)  # (rows, 3)
        weight = weight * (weight[own].sum(axis=0) > 0)
        total = weight.sum(axis=(1, 2))
        difference = np.sum((sample - reference) * weight, axis=(1, 2)) / np.maximum(total, 1e-9)
        unlike = np.linalg.norm(difference, axis=1) / LIKE_LEVELS
        known = total[:, 0] >= 3.0 * LEAST_LENGTH_M
        like = 1.0 / (1.0 + unlike**4)
        says_road = np.where(known, np.log(0.05 + 0.95 * like), 0.0)
        says_verge = np.where(known, np.log(0.35 + 0.65 * (1.0 - like)), 0.0)
        result = np.empty(len(self.shifts))
        for i, n in enumerate(self.shifts):
            strip = np.arange(-self.lanes, 2 * self.lanes) + int(n)
            on_road = (strip >= 0) & (strip < self.lanes)
            result[i] = np.where(on_road, says_road, says_verge).sum()
        return result


def _nearest(view: BirdsEye, coarse: BirdsEye) -> Floats:
    index = np.rint((coarse.forward_m - view.forward_m[0]) / (view.forward_m[1] - view.forward_m[0]))
    return np.asarray(np.clip(index, 0, len(view.forward_m) - 1).astype(np.intp))


def _across(view: BirdsEye, right_m: Floats) -> Floats:
    column = np.rint((right_m - view.right_m[0]) / view.column_m)
    return np.asarray(np.clip(column, 0, len(view.right_m) - 1).astype(np.intp))
