"""What is wrong with a camera frame: black, constant, of another shape, or stale. None of it may pass for a picture."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vpf_sim.types import Image

Fault = Literal["black", "constant", "wrong shape", "stale"]
SAMPLE = 40  # px between the pixels that are looked at before whole frames are compared


@dataclass(frozen=True, slots=True)
class InvalidFrame:
    """A frame that is none, and when: frame 0 is that of the reset."""

    frame: int
    time_s: float
    fault: Fault


def frame_fault(frame: Image, shape: tuple[int, ...], last: Image | None = None) -> Fault | None:
    """What is wrong with a frame that should have `shape`; `last` is one that it must differ from."""
    if frame.shape != shape or frame.dtype != np.uint8:
        return "wrong shape"
    if _constant(frame):
        return "constant" if frame.any() else "black"
    return "stale" if last is not None and _same(frame, last) else None


def _constant(frame: Image) -> bool:
    """Of one colour."""
    first = frame[0, 0]
    return bool((frame[::SAMPLE, ::SAMPLE] == first).all() and (frame == first).all())


def _same(a: Image, b: Image) -> bool:
    if a.shape != b.shape:
        return False
    return bool((a[::SAMPLE, ::SAMPLE] == b[::SAMPLE, ::SAMPLE]).all() and (a == b).all())
