"""Which of the road's lines are the edges of the carriageway, and so which lane this is and how many there are.

The lines repeat every lane's width, the edges do not. A hypothesis names the two lines that are the edges. Each is
judged by what kind of line lies at every place (solid edges, dashed lines within, none outside) and by the ground
between them: within the carriageway it looks like the ego's own lane, outside mostly not, whatever its colour. How many
lanes a road has is known beforehand only as what is likely; an edge that cannot be seen is where it likely is.
"""

from dataclasses import dataclass

import numpy as np

from vpf_sim.perception.road.birds_eye import BirdsEye
from vpf_sim.perception.road.config import GroundConfig, HypothesesConfig
from vpf_sim.perception.road.line_type import DashDutyCycle
from vpf_sim.perception.road.markings import RidgeMap, sight
from vpf_sim.perception.road.model import WIDTH, seen_places
from vpf_sim.types import Bools, Floats, Image, Integers

SOLID, DASHED, NONE = 0, 1, 2
MOST_LANES = 6


def _all_edges() -> Integers:
    """(H, 2) the left and the right edge of every hypothesis: lines 0 and 1 hold the lane of the road when found."""
    pairs = [
        (left, left + lanes)
        for lanes in range(1, MOST_LANES + 1)
        for left in range(-MOST_LANES, 2)
        if 0 <= left + lanes <= MOST_LANES + 1
    ]
    return np.array(pairs, np.int64)


def _kinds(edges: Integers, numbers: Floats) -> Integers:
    """(H, L) the kind of each line under each hypothesis."""
    left, right = edges[:, :1], edges[:, 1:]
    within = (numbers > left) & (numbers < right)
    return np.where((numbers == left) | (numbers == right), SOLID, np.where(within, DASHED, NONE))


def _on_road(edges: Integers, strips: Floats) -> Bools:
    """(H, S) whether each strip is part of the carriageway under each hypothesis."""
    within: Bools = (strips >= edges[:, :1]) & (strips < edges[:, 1:])
    return within


EDGES = _all_edges()
NUMBERS: Floats = np.arange(-MOST_LANES - 1.0, MOST_LANES + 3.0)  # of the lines that are looked at
STRIPS: Floats = NUMBERS[:-1]  # between each line and the next, by the number of the line at its left
KINDS, ON_ROAD = _kinds(EDGES, NUMBERS), _on_road(EDGES, STRIPS)


@dataclass(slots=True)
class CarriagewayHypotheses:
    """The log-probabilities of the hypotheses, gathered over time, and the one that is believed."""

    prior: Floats  # (H,)
    log_odds: Floats  # (H,) of the evidence
    believed: int  # index in EDGES
    config: HypothesesConfig
    duty: DashDutyCycle | None
    agreement: float | None = None  # 0 .. 1, how much of the expected lines is seen, lately; None: nothing judged
    followed: int = 0  # judgements since these edges were taken
    rival: int | None = None  # hypothesis that is likelier now, None: none is
    led: int = 0  # judgements in a row in which it was

    @classmethod
    def start(cls, lanes: int, lane: int, config: HypothesesConfig) -> "CarriagewayHypotheses":
        """Before any evidence: so many lanes, and the road was found in this one, counted from the right."""
        prior = np.where(EDGES[:, 1] - EDGES[:, 0] == lanes, 0.0, np.log(config.other_lanes))
        prior += np.where(EDGES[:, 1] == lane, 0.0, np.log(config.other_lane))
        duty = DashDutyCycle.start(len(NUMBERS), config.duty) if config.duty else None
        return cls(prior, np.zeros(len(EDGES)), _index_of(lane - lanes, lane), config, duty)

    @property
    def edges(self) -> tuple[int, int]:
        """Numbers of the lines that are believed to be the left and the right edge."""
        left, right = EDGES[self.believed].tolist()
        return left, right

    @property
    def numbers(self) -> Floats:
        """Of all lines of the believed carriageway."""
        left, right = self.edges
        return np.arange(left, right + 1, dtype=float)

    def probabilities(self, state: Floats) -> Floats:
        """(H,) of the hypotheses."""
        place, margin = state[0] / state[WIDTH], self.config.beside_m / state[WIDTH]
        possible = (place > EDGES[:, 0] - margin) & (place < EDGES[:, 1] + margin)
        if not possible.any():
            return np.full(len(EDGES), 1.0 / len(EDGES))
        likely = np.where(possible, self.log_odds + self.prior, -np.inf)
        weight = np.exp(likely - likely.max())
        return np.asarray(weight / weight.sum())

    def judge(self, state: Floats, travelled_m: float, ridges: RidgeMap, colour: Image, colour_view: BirdsEye) -> None:
        """Take in one frame, and other edges if they are likelier beyond doubt, and go on to be."""
        config, evidence = self.config, self._line_evidence(state, travelled_m, ridges)
        if config.ground is not None:
            least_m = config.least_length_m
            evidence = evidence + _ground_evidence(state, ridges, colour, colour_view, config.ground, least_m)
        self.log_odds = config.kept * self.log_odds + config.weight * (evidence - evidence.max())
        likely = self.probabilities(state)
        best = int(np.argmax(likely))
        certain = likely[best] > config.switch_odds * likely[self.believed]
        if self.is_lasting(best if certain else None):
            self.believed = best
            self.agreement, self.followed, self.rival, self.led = None, 0, None, 0

    def is_lasting(self, rival: int | None) -> bool:
        """Whether this hypothesis, likelier at this judgement (None: none is), has been so for long enough."""
        self.followed += 1
        self.led = self.led + 1 if rival == self.rival else 1
        self.rival = rival
        lasting = self.config.lasting
        return rival is not None and (lasting is None or self.led >= min(lasting.share * self.followed, lasting.most))

    def _line_evidence(self, state: Floats, travelled_m: float, ridges: RidgeMap) -> Floats:
        """(H,) by the kinds of the lines."""
        view = ridges.view
        right, reached = seen_places(state, NUMBERS, view.forward_m, view.camera)
        columns, inside = view.columns(right, reached)
        visible = inside & ridges.visible[np.arange(len(view.forward_m)), columns]
        found = sight(ridges, right, visible, NUMBERS, self.config.line_reach_m, np.zeros(len(view.forward_m)))
        length = visible @ view.length_m
        share = (found.seen @ view.length_m) / np.maximum(length, 1e-9)
        config = self.config
        known = length >= config.least_length_m
        self._compare(share, known)
        mean = np.array(config.presences)[:, None] * [config.solid_share, config.dashed_share, config.absent_share]
        sigma = np.array([config.solid_sd, config.dashed_sd, config.absent_sd])
        says = -0.5 * ((share[:, None, None] - mean) / sigma) ** 2 - np.log(sigma / sigma.max())
        least: Floats = np.asarray(
            np.where(share < config.hidden_share, np.log(config.hidden), np.log(config.surprise)), np.float64
        )
        says = np.maximum(says - says.max(axis=(1, 2), keepdims=True), least[:, None, None])
        says = np.where(known[:, None, None], says, 0.0)
        if self.duty is not None:
            self.duty.look(ridges, right, visible, travelled_m)
            says = self._by_duty(says, self.duty)
        return np.asarray(says[np.arange(len(NUMBERS)), :, KINDS].sum(axis=1).max(axis=1))

    def _by_duty(self, says: Floats, lines: DashDutyCycle) -> Floats:
        """(L, presences, kinds) the evidence, where solid or dashed is told by the gaps, once they are known."""
        duty, known = lines.duty()
        mean = np.array([self.config.solid_share, lines.config.dashed_share])
        sigma = np.array([lines.config.solid_sd, lines.config.dashed_sd])
        gaps = np.maximum(-0.5 * ((duty[:, None] - mean) / sigma) ** 2, np.log(self.config.surprise))
        gaps -= gaps.max(axis=1, keepdims=True)
        told = says.copy()
        told[..., [SOLID, DASHED]] = says[..., [SOLID, DASHED]].max(axis=-1, keepdims=True) + gaps[:, None]
        return np.asarray(np.where(known[:, None, None], told, says))

    def _compare(self, share: Floats, known: Bools) -> None:
        """Note how much of the lines of the believed carriageway is seen."""
        kinds = KINDS[self.believed]
        counts = known & (kinds != NONE)
        if not counts.any():
            return
        now = float(
            np.mean(
                np.minimum(
                    share[counts] / np.array([self.config.solid_share, self.config.dashed_share])[kinds[counts]], 1.0
                )
            )
        )
        self.agreement = (
            now if self.agreement is None else self.config.kept * self.agreement + (1.0 - self.config.kept) * now
        )


def _index_of(left: int, right: int) -> int:
    edges: list[list[int]] = EDGES.tolist()
    return edges.index([left, right])


def _ground_evidence(
    state: Floats,
    ridges: RidgeMap,
    colour: Image,
    colour_view: BirdsEye,
    config: GroundConfig,
    least_length_m: float,
) -> Floats:
    """(H,) by the ground between the lines."""
    unlike, unlike_hue, known = _unlike_own_lane(state, ridges, colour, colour_view, config, least_length_m)
    road, verge = config.least_road, config.least_verge
    like = 1.0 / (1.0 + (unlike / config.unlike_levels) ** 4)
    of_road = config.weight * np.log(road + (1.0 - road) * like)
    if config.hue is not None:
        like_hue = 1.0 / (1.0 + (unlike_hue / config.hue.unlike_levels) ** 4)
        of_road = of_road + np.log(road + (1.0 - road) * like_hue)
    says_road = np.where(known, of_road, 0.0)
    says_verge = np.where(known, config.weight * np.log(verge + (1.0 - verge) * (1.0 - like)), 0.0)
    return np.asarray(np.where(ON_ROAD, says_road, says_verge).sum(axis=1))


def _unlike_own_lane(
    state: Floats,
    ridges: RidgeMap,
    colour: Image,
    colour_view: BirdsEye,
    config: GroundConfig,
    least_length_m: float,
) -> tuple[Floats, Floats, Bools]:
    """(strips,) levels by which colour and hue differ from those of the ego's own lane, and whether they are known.

    The median over a strip: what a wet road mirrors, and what stands on it, cover a part; another ground is everywhere.
    """
    numbers = (STRIPS[:, None] + np.array([0.3, 0.5, 0.7])).ravel()
    right, reached = seen_places(state, numbers, colour_view.forward_m, colour_view.camera)
    columns, inside = colour_view.columns(right, reached)
    rows = np.arange(len(colour_view.forward_m))[None, :]
    inside &= colour_view.visible[rows, columns]
    inside &= ridges.visible[_nearest(ridges.view, colour_view)][rows, _across(ridges.view, right)]
    shape = (len(STRIPS), 3, len(colour_view.forward_m))
    weight = (inside * colour_view.length_m).reshape(shape)[..., None]
    sample = colour[rows, columns].astype(np.float64).reshape(*shape, 3)
    own = int(np.clip(np.searchsorted(NUMBERS, state[0] / state[WIDTH]) - 1, 0, len(STRIPS) - 1))
    reference = np.sum(sample[own] * weight[own], axis=0) / np.maximum(weight[own].sum(axis=0), 1e-9)  # (rows, 3)
    weight = weight * (weight[own].sum(axis=0) > 0)
    known = weight[..., 0] > 0.0
    enough = weight.sum(axis=(1, 2))[:, 0] >= 3.0 * least_length_m
    difference = np.where(known[..., None], sample - reference, np.nan).reshape(len(STRIPS), -1, 3)
    unlike = np.zeros(len(STRIPS))
    unlike[enough] = np.linalg.norm(median_of_known(difference[enough]), axis=1)
    if config.hue is None:
        return unlike, np.zeros(len(STRIPS)), enough
    return unlike, _unlike_in_hue(sample, known, own, colour_view.forward_m < config.hue.near_m, enough), enough


def _unlike_in_hue(sample: Floats, known: Bools, own: int, near: Bools, enough: Bools) -> Floats:
    """(strips,) levels by which the hue, brightness apart, differs from that of the ego's own lane nearby.

    Of samples (strips, 3, rows, RGB) and which are known. The lane's far part may be of a body's hue, or its image's.
    """
    hue = np.where(known[..., None], sample - sample.mean(axis=-1, keepdims=True), np.nan)
    reference = hue[own][:, near].reshape(-1, 3)
    reference = reference[np.isfinite(reference[:, 0])]
    unlike = np.zeros(len(STRIPS))
    if len(reference) and enough.any():
        median = median_of_known(hue.reshape(len(STRIPS), -1, 3)[enough])
        unlike[enough] = np.linalg.norm(median - np.median(reference, axis=0), axis=1)
    return unlike


def median_of_known(samples: Floats) -> Floats:
    """(S, 3) medians of S sets of samples (S, n, 3), nan left out; each has some. `np.nanmedian` takes far longer."""
    ordered = np.sort(samples, axis=1)  # nan comes last
    known = np.count_nonzero(np.isfinite(samples), axis=1, keepdims=True)
    middle = [np.take_along_axis(ordered, index, axis=1)[:, 0] for index in ((known - 1) // 2, known // 2)]
    median: Floats = 0.5 * (middle[0] + middle[1])
    return median


def _nearest(view: BirdsEye, coarse: BirdsEye) -> Integers:
    index = np.rint((coarse.forward_m - view.forward_m[0]) / (view.forward_m[1] - view.forward_m[0]))
    return np.asarray(np.clip(index, 0, len(view.forward_m) - 1).astype(np.intp))


def _across(view: BirdsEye, right_m: Floats) -> Integers:
    column = np.rint((right_m - view.right_m[0]) / view.column_m)
    return np.asarray(np.clip(column, 0, len(view.right_m) - 1).astype(np.intp))
