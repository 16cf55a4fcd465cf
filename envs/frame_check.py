"""Faults of a camera frame: black, constant, of another shape, or stale."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vpf_sim.types import Image

Fault = Literal["black", "constant", "wrong shape", "stale"]
SAMPLE = 40  # px between the pixels of the cheap comparison that comes first


@dataclass(frozen=True, slots=True)
class InvalidFrame:
    """An invalid frame: its number (0 at the reset), its time and its fault."""

    frame: int
    time_s: float
    fault: Fault


def frame_fault(frame: Image, shape: tuple[int, ...], last: Image | None = None) -> Fault | None:
    """The fault of a frame that should have `shape` and differ from `last`; None for a valid frame."""
    if frame.shape != shape or frame.dtype != np.uint8:
        return "wrong shape"
    if _constant(frame):
        return "constant" if frame.any() else "black"
    return "stale" if last is not None and _same(frame, last) else None


def _constant(frame: Image) -> bool:
    """Whether all pixels have one colour."""
    first = frame[0, 0]
    return bool((frame[::SAMPLE, ::SAMPLE] == first).all() and (frame == first).all())


def _same(a: Image, b: Image) -> bool:
    if a.shape != b.shape:
        return False
    return bool((a[::SAMPLE, ::SAMPLE] == b[::SAMPLE, ::SAMPLE]).all() and (a == b).all())
