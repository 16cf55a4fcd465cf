"""Which of the road's lines are the edges of the carriageway: the lane of the car and the number of lanes.

A hypothesis names the two lines that are the edges. Evidence is the kind of line at each place (solid edges, dashed
lines within, none outside) and the ground between the lines: within the carriageway it looks like the ego's own lane. A
solid line that parts the ego's lanes from oncoming traffic is the left edge, too, with lanes and a solid line beyond.
The number of lanes is known only as a prior; an edge that is not visible is where it likely is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vpf_sim.perception.road.birds_eye import BirdsEye
from vpf_sim.perception.road.markings import RidgeMap, sight
from vpf_sim.perception.road.model import VERGE, WIDTH, seen_places
from vpf_sim.perception.road.road_settings import GroundConfig, HypothesesConfig
from vpf_sim.types import Bools, Floats, Image, Integers

MOST_LANES, MOST_ONCOMING = 6, 2
NUMBERS: Floats = np.arange(-MOST_LANES - 1.0, MOST_LANES + 3.0)  # of the lines that are compared
SOLID, DASHED, NONE = range(3)


def _all_roads() -> Integers:
    """(H, 3) left edge, right edge and far side of every hypothesis: the latter is left of the lanes that come towards.

    Lines 0 and 1 hold the lane of the road when found.
    """
    roads = [
        (left, left + lanes, left - oncoming)
        for oncoming in range(MOST_ONCOMING + 1)
        for lanes in range(max(oncoming, 1), MOST_LANES + 1)
        for left in range(oncoming - MOST_LANES, 2)
        if 0 <= left + lanes <= MOST_LANES + 1
    ]
    return np.array(roads, np.int64)


def _kinds() -> Integers:
    """(H, L) the kind of each line under each hypothesis."""
    left, right, far = LEFT[:, None], RIGHT[:, None], FAR[:, None]
    solid = (left == NUMBERS) | (right == NUMBERS) | (far == NUMBERS)
    return np.where(solid, SOLID, np.where((far < NUMBERS) & (right > NUMBERS), DASHED, NONE))


ROADS = _all_roads()
LEFT, RIGHT, FAR = ROADS.T
KINDS = _kinds()


@dataclass(slots=True)
class CarriagewayHypotheses:
    """Log-probabilities of the hypotheses over time, and the current hypothesis."""

    prior: Floats  # (H,)
    log_odds: Floats  # (H,) of the evidence
    current: int  # index in ROADS
    config: HypothesesConfig
    agreement: float | None = None  # 0 .. 1, share of the expected lines that is visible; None: nothing judged
    judgements: int = 0  # since the last change
    rival: int | None = None  # hypothesis that is likelier now, None: none is
    streak: int = 0  # consecutive judgements in which it was

    @classmethod
    def start(cls, lanes: int, lane: int, config: HypothesesConfig) -> "CarriagewayHypotheses":
        """Before any evidence: the likely number of lanes on a road of one direction, and the car's lane on it.

        Lanes count from the right.
        """
        two_way, own = FAR < LEFT, RIGHT - LEFT
        prior = np.where(two_way | (own == lanes), 0.0, np.log(config.other_lanes))
        usual = np.where(two_way, own == LEFT - FAR, lane == RIGHT)  # as many lanes either way
        prior += np.where(usual, 0.0, np.log(config.other_lane))
        prior[two_way] += np.log(config.two_way)
        return cls(prior, np.zeros(len(ROADS)), ROADS.tolist().index([lane - lanes, lane, lane - lanes]), config)

    @property
    def edges(self) -> tuple[int, int]:
        """Numbers of the lines that are the left and the right edge."""
        return int(LEFT[self.current]), int(RIGHT[self.current])

    @property
    def oncoming(self) -> int:
        """Lanes of oncoming traffic beyond the left edge."""
        return int(LEFT[self.current] - FAR[self.current])

    @property
    def numbers(self) -> Floats:
        """Of all lines of the carriageway, with those of oncoming traffic."""
        return np.arange(FAR[self.current], RIGHT[self.current] + 1.0)

    def probabilities(self, state: Floats) -> Floats:
        """(H,) of the hypotheses."""
        place, margin = state[0] / state[WIDTH], self.config.beside_m / state[WIDTH]
        possible = (place > LEFT - margin) & (place < RIGHT + margin)
        if not possible.any():
            return np.full(len(ROADS), 1.0 / len(ROADS))
        likely = np.where(possible, self.log_odds + self.prior, -np.inf)
        weight = np.exp(likely - likely.max())
        return np.asarray(weight / weight.sum())

    def of_these_edges(self, state: Floats) -> float:
        """The probability that the edges are those of the current one, whatever lies beyond."""
        same = (LEFT[self.current] == LEFT) & (RIGHT[self.current] == RIGHT)
        return float(self.probabilities(state)[same].sum())

    def judge(
        self, state: Floats, ridges: RidgeMap, colour: Image, colour_view: BirdsEye, verges: Sequence[float]
    ) -> None:
        """Add the evidence of one frame; change the hypothesis if another one is far likelier for long enough.

        `verges` are the numbers of those that are clear.
        """
        config, evidence = self.config, self._line_evidence(state, ridges)
        least_m = config.least_length_m
        evidence = evidence + _ground_evidence(state, ridges, colour, colour_view, config.ground, least_m)
        for number in verges:
            evidence = evidence + _verge_evidence(number, state, config)
        self.log_odds = config.kept * self.log_odds + config.weight * (evidence - evidence.max())
        likely = self.probabilities(state)
        best = int(np.argmax(likely))
        certain = likely[best] > config.switch_odds * likely[self.current]
        if self.is_lasting(best if certain else None):
            self.current = best
            self.agreement, self.judgements, self.rival, self.streak = None, 0, None, 0

    def is_lasting(self, rival: int | None) -> bool:
        """Whether this hypothesis, likelier at this judgement (None: none is), has been so for long enough."""
        self.judgements += 1
        self.streak = self.streak + 1 if rival == self.rival else 1
        self.rival = rival
        lasting = self.config.lasting
        return rival is not None and self.streak >= min(lasting.share * self.judgements, lasting.most)

    def _line_evidence(self, state: Floats, ridges: RidgeMap) -> Floats:
        """(H,) by the kinds of the lines."""
        view, config = ridges.view, self.config
        right, reached = seen_places(state, NUMBERS, view.forward_m, view.camera)
        columns, inside = view.columns(right, reached)
        visible = inside & ridges.visible[np.arange(len(view.forward_m)), columns]
        _, seen = sight(ridges, right, visible, config.line_reach_m)
        length = visible @ view.length_m
        share = (seen @ view.length_m) / np.maximum(length, 1e-9)
        known = length >= config.least_length_m
        self._update_agreement(share, known)
        mean = np.array(config.presences)[:, None] * [config.solid_share, config.dashed_share, config.absent_share]
        sigma = np.array([config.solid_sd, config.dashed_sd, config.absent_sd])
        likely = -0.5 * ((share[:, None, None] - mean) / sigma) ** 2 - np.log(sigma / sigma.max())  # (L, presences, 3)
        least = np.log(np.where(share < config.hidden_share, config.hidden, config.surprise))
        likely = np.maximum(likely - likely.max(axis=(1, 2), keepdims=True), least[:, None, None])
        likely = np.where(known[:, None, None], likely, 0.0)
        return np.asarray(likely[np.arange(len(NUMBERS)), :, KINDS].sum(axis=1).max(axis=1))

    def _update_agreement(self, share: Floats, known: Bools) -> None:
        """Average the visible share of the current carriageway's lines."""
        kinds, config = KINDS[self.current], self.config
        counts = known & (kinds != NONE)
        if counts.any():
            usual = np.array([config.solid_share, config.dashed_share])[kinds[counts]]
            now = float(np.mean(np.minimum(share[counts] / usual, 1.0)))
            before = self.agreement
            self.agreement = now if before is None else config.kept * before + (1.0 - config.kept) * now


def _verge_evidence(number: float, state: Floats, config: HypothesesConfig) -> Floats:
    """(H,) by a verge: no edge lies beyond it. How far before it does not matter, as beside a paved shoulder."""
    outermost = RIGHT if number > 0.0 else FAR
    gap_m = np.sign(number) * (state[VERGE[number]] - outermost * state[WIDTH])
    return np.where(gap_m > -config.line_reach_m, 0.0, np.log(config.off_verge))


def _ground_evidence(
    state: Floats, ridges: RidgeMap, colour: Image, colour_view: BirdsEye, config: GroundConfig, least_length_m: float
) -> Floats:
    """(H,) by the ground between the lines."""
    unlike, known = _unlike_own_lane(state, ridges, colour, colour_view, least_length_m)
    road, verge = config.least_road, config.least_verge
    like = 1.0 / (1.0 + (unlike / config.unlike_levels) ** 4)
    of_road = config.weight * np.log(road + (1.0 - road) * like)
    of_verge = config.weight * np.log(verge + (1.0 - verge) * (1.0 - like))
    on_road = (NUMBERS[:-1] >= FAR[:, None]) & (NUMBERS[:-1] < RIGHT[:, None])
    return np.asarray(np.where(on_road, np.where(known, of_road, 0.0), np.where(known, of_verge, 0.0)).sum(axis=1))


def _unlike_own_lane(
    state: Floats, ridges: RidgeMap, colour: Image, colour_view: BirdsEye, least_length_m: float
) -> tuple[Floats, Bools]:
    """(S,) levels by which the colour of the strips between lines differs from the own lane's; which are known.

    The median over a strip: mirror images and obstacles cover a part of it, another ground all of it.
    """
    strips, rows = len(NUMBERS) - 1, np.arange(len(colour_view.forward_m))[None, :]
    numbers = (NUMBERS[:-1, None] + np.array([0.3, 0.5, 0.7])).ravel()
    right, reached = seen_places(state, numbers, colour_view.forward_m, colour_view.camera)
    columns, inside = colour_view.columns(right, reached)
    inside &= colour_view.visible[rows, columns] & ridges.visible[ridges.view.nearest(colour_view.forward_m, right)]
    shape = (strips, 3, rows.size)
    weight = (inside * colour_view.length_m).reshape(shape)[..., None]
    sample = colour[rows, columns].astype(np.float64).reshape(*shape, 3)
    own = int(np.clip(np.searchsorted(NUMBERS, state[0] / state[WIDTH]) - 1, 0, strips - 1))
    reference = np.sum(sample[own] * weight[own], axis=0) / np.maximum(weight[own].sum(axis=0), 1e-9)  # (rows, 3)
    weight = weight * (weight[own].sum(axis=0) > 0)
    known = weight[..., 0] > 0.0
    enough = weight.sum(axis=(1, 2))[:, 0] >= 3.0 * least_length_m
    difference = np.where(known[..., None], sample - reference, np.nan).reshape(strips, -1, 3)
    unlike = np.zeros(strips)
    unlike[enough] = np.linalg.norm(median_of_known(difference[enough]), axis=1)
    return unlike, enough


def median_of_known(samples: Floats) -> Floats:
    """(S, 3) medians of S sets of samples (S, n, 3), nan left out; each has some. `np.nanmedian` takes far longer."""
    ordered = np.sort(samples, axis=1)  # nan comes last
    known = np.count_nonzero(np.isfinite(samples), axis=1, keepdims=True)
    middle = [np.take_along_axis(ordered, index, axis=1)[:, 0] for index in ((known - 1) // 2, known // 2)]
    return np.asarray(0.5 * (middle[0] + middle[1]))
