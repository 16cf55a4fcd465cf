"""Fitting the network to the collected drives."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from behaviour_cloning.collect import Drive
from behaviour_cloning.network import SCALES, Network
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Integers, Singles

BATCH = 128
LEARNING_RATE, WEIGHT_DECAY = 2e-3, 1e-4
BRAKING_WEIGHT = 4.0  # by which a decision to brake fully counts more
NOISE_VALUES, MOST_SMEAR_PX = 2_000_000, 12
Batch = tuple[Tensor, Tensor, Tensor]


class Decisions:
    """All decisions of all drives, stacked when they are read."""

    def __init__(self, drives: Sequence[Drive], frames_ago: Sequence[int]) -> None:
        self._pictures = np.concatenate([one.pictures for one in drives])
        self._states = np.concatenate([one.states for one in drives])
        self._labels = np.concatenate([one.labels for one in drives])
        ago = [np.maximum(np.arange(len(one))[:, None] - np.array(frames_ago), 0) for one in drives]
        starts = np.cumsum([0, *(len(one) for one in drives[:-1])])
        self._frames = np.concatenate([start + rows for start, rows in zip(starts, ago, strict=True)])

    def __len__(self) -> int:
        return len(self._labels)

    def stacked(self, rows: Integers) -> Singles:
        """(B, channels, H, W) the pictures of some decisions, in 0..1; before a drive's first frame, that frame."""
        pictures: Singles = self._pictures[self._frames[rows]].astype(np.float32)
        pictures /= 255.0
        return pictures.reshape(len(rows), -1, *pictures.shape[-2:])

    def given(self, rows: Integers) -> tuple[Singles, Singles]:
        """(B, values) the states and (B, 2) the teacher's commands of some decisions, as copies."""
        return self._states[rows], self._labels[rows]

    def batches(self, rng: np.random.Generator) -> Iterator[Batch]:
        """Every decision once, in random order, half of them mirrored, with disturbed pictures."""
        order, disturbances = rng.permutation(len(self)), Disturbances(rng)
        for first in range(0, len(order) - BATCH // 2, BATCH):
            rows = order[first : first + BATCH]
            pictures, (states, labels) = self.stacked(rows), self.given(rows)
            mirror(pictures, labels, rng.random(len(rows)) < 0.5)
            disturbances.apply(pictures)
            yield torch.from_numpy(pictures), torch.from_numpy(states), torch.from_numpy(labels)


def mirror(pictures: Singles, labels: Singles, which: Bools) -> None:
    """Swap left and right of some decisions, in place; the speed, which is all of the state, stays."""
    pictures[which] = pictures[which, ..., ::-1]
    labels[which, 1] *= -1.0


class Disturbances:
    """Pictures with another contrast, a gradient of brightness, noise, a rise or fall by a pixel, and smears."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._noise = rng.standard_normal(NOISE_VALUES, np.float32)  # drawn once, and read from anywhere

    def apply(self, pictures: Singles) -> None:
        """Change (B, channels, H, W) pictures in 0..1 in place."""
        count, _, height, width = pictures.shape
        pictures *= self._drawn(0.7, 1.3, count)
        pictures += self._drawn(-0.1, 0.1, count) * np.linspace(-1.0, 1.0, width, dtype=np.float32)
        for picture in pictures:
            first = int(self._rng.integers(NOISE_VALUES - picture.size))
            noise = self._noise[first : first + picture.size].reshape(picture.shape)
            picture += np.float32(self._rng.uniform(0.0, 0.03)) * noise
            picture[:] = np.roll(picture, int(self._rng.integers(-1, 2)), axis=1)
            for _ in range(int(self._rng.integers(0, 3))):  # as drops on the windscreen do
                y, x, size = (int(self._rng.integers(high)) for high in (height, width, MOST_SMEAR_PX))
                picture[:, y : y + size, x : x + size] = self._rng.uniform(0.2, 0.8)

    def _drawn(self, low: float, high: float, count: int) -> Singles:
        return self._rng.uniform(low, high, (count, 1, 1, 1)).astype(np.float32)


def ahead(batches: Iterator[Batch]) -> Iterator[Batch]:
    """The batches, each made in another thread while the one before is used."""
    with ThreadPoolExecutor(1) as thread:
        following = thread.submit(next, batches, None)
        while (batch := following.result()) is not None:
            following = thread.submit(next, batches, None)
            yield batch


def fit(network: Network, decisions: Decisions, epochs: int, seed: int) -> Iterator[float]:
    """Fit by AdamW with one cycle of the learning rate; the mean loss after each epoch."""
    optimiser = torch.optim.AdamW(network.parameters(), LEARNING_RATE, weight_decay=WEIGHT_DECAY)
    steps = epochs * (1 + len(decisions) // BATCH)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, LEARNING_RATE, total_steps=steps + 1)
    rng = stream(seed, "batches")
    network.train().to(memory_format=torch.channels_last)
    for _ in range(epochs):
        losses = []
        for pictures, states, labels in ahead(decisions.batches(rng)):
            optimiser.zero_grad()
            pictures = pictures.to(memory_format=torch.channels_last)  # twice as fast
            loss, doubt = losses_of(*network(pictures, states), labels)
            (loss + doubt).backward()  # type: ignore[no-untyped-call]
            optimiser.step()
            schedule.step()
            losses.append(loss.item())
        yield float(np.mean(losses))


def losses_of(commands: Tensor, deviations: Tensor, labels: Tensor) -> tuple[Tensor, Tensor]:
    """Losses of the command, and of its deviation.

    Huber's loss of throttle and steering, each by its scale; braking is rare, so it counts more. The deviation's is the
    negative log-likelihood of the command's errors under Laplace's distribution, less a constant.
    """
    scales = torch.tensor(SCALES)
    losses = torch.nn.functional.smooth_l1_loss(commands / scales, labels / scales, reduction="none")
    weights = 1.0 + BRAKING_WEIGHT * labels[:, :1].clamp(-1.0, 0.0).abs()
    errors, widths = (labels - commands).detach().abs() / scales, deviations / scales / 2.0**0.5
    return (weights * losses).mean(), (errors / widths + widths.log()).mean()


class Answers(NamedTuple):
    """What the network answers to undisturbed pictures, for the steering of each decision."""

    errors: Singles  # (T,) from the teacher's
    deviations: Singles  # (T,) that it states


def answers(network: Network, decisions: Decisions) -> Answers:
    """The network's answers to all decisions."""
    network.eval()
    found = []
    with torch.no_grad():
        for first in range(0, len(decisions), BATCH):
            rows = np.arange(first, min(first + BATCH, len(decisions)))
            states, labels = decisions.given(rows)
            command, deviation = network(torch.from_numpy(decisions.stacked(rows)), torch.from_numpy(states))
            found.append(np.stack([np.abs(command.numpy() - labels)[:, 1], deviation.numpy()[:, 1]]))
    return Answers(*np.concatenate(found, axis=1))


def unsure_ratio(found: Answers, share: float = 0.1) -> float:
    """The mean error of the most unsure share of the answers, divided by that of the others."""
    unsure = found.deviations >= np.quantile(found.deviations, 1.0 - share)
    return float(found.errors[unsure].mean() / found.errors[~unsure].mean())
