"""A recorded drive, whatever its layout: frames, times, camera, motion, commands, and what is known of the truth.

Axes of the vehicle: X forward, Y right, yaw clockwise. Every reader turns its source's signs and units into these.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, Protocol

import numpy as np

from vpf_sim.replay.mounting_estimate import Angle
from vpf_sim.types import Bools, Camera, Floats, Image

Kind = Literal["recorded", "derived", "assumed", "absent"]
PICTURES = "pictures"  # the name of their flow among the inputs of a signal


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a signal comes from."""

    kind: Kind
    how: str = ""  # from which file and column, from what it is computed, or what is taken for granted
    inputs: frozenset[str] = frozenset()  # all that it follows from, near and far: signals' names, or PICTURES

    @classmethod
    def following(cls, how: str, inputs: "Mapping[str, Origin]") -> "Origin":
        """That of a signal computed from others: derived, or assumed if one of them is.

        The scales of a measurement, camera and clock, are no signals: `how` says what of them is assumed.
        """
        guessed = [name for name, origin in inputs.items() if origin.kind == "assumed"]
        told = "".join(f"; {name} is assumed" for name in guessed)
        every = frozenset(inputs).union(*(origin.inputs for origin in inputs.values()))
        return cls("assumed" if guessed else "derived", how + told, every)

    @property
    def is_known(self) -> bool:
        """Whether there is a signal, and nothing in it is assumed: others may be held against it."""
        return self.kind in ("recorded", "derived")

    def __str__(self) -> str:
        return f"{self.kind}: {self.how}" if self.how else self.kind


ABSENT = Origin("absent")


@dataclass(frozen=True, slots=True)
class Frame:
    """The picture number `index` of a recording, or why there is none: the drive goes on after a gap."""

    index: int
    image: Image | None  # (H, W, 3) RGB
    fault: str = ""  # one line; empty where there is an image
    time_s: float | None = None  # when the picture was taken; None: at the time of its number


@dataclass(frozen=True, slots=True)
class Recording:
    """N frames and what is known at each; nan where a signal is unknown. `origins` has an entry for every signal.

    The pose is the camera's place, with the heading of the vehicle. Frames are as `camera` describes them: whatever
    else the lens or the mounting did (tangential distortion, yaw, roll) is removed from them.
    """

    name: str
    layout: str  # such as "KITTI odometry"
    camera: Camera
    times_s: Floats  # (N,) ascending
    poses: Floats  # (N, 3) x m, y m, yaw rad
    speed_mps: Floats  # (N,)
    yaw_rate_radps: Floats  # (N,) + turns right
    frames: Callable[[], Iterator[Frame]]  # from the first, decoded as they are asked for; N of them, gaps included
    origins: Mapping[str, Origin]  # by the names of the signals, and "camera"
    foe_px: Floats = field(default_factory=lambda: np.empty(0))  # (N, 2) truth, of the motion from the frame before,
    # in the axes half way between, in undistorted pixels
    steering_rad: Floats = field(default_factory=lambda: np.empty(0))  # (N,) of the road wheels, + is right
    throttle: Floats = field(default_factory=lambda: np.empty(0))  # (N,) -1 .. 1, negative brakes
    obstacle: Floats = field(default_factory=lambda: np.empty(0))  # (N,) 1 where labelled as in the way, else 0
    lead_gap_m: Floats = field(default_factory=lambda: np.empty(0))  # (N,) from the camera to the body ahead
    weather: str = ""  # as the recording names it; empty where it does not
    notes: tuple[str, ...] = ()  # gaps and assumptions, a line each
    mounting_found: Mapping[str, Angle] = field(default_factory=dict)  # "pitch", "yaw" of a camera found on the way
    no_images: str = ""  # why there are none, and what can be done; then `frames` raises it as an InputError
    files: tuple[Path | None, ...] = ()  # its pictures, and others of which it is a function; some may be missing
    bridged: Mapping[str, Bools] = field(default_factory=dict)  # (N,) where a signal was filled in over a gap

    def __post_init__(self) -> None:
        for name in ("steering_rad", "throttle", "obstacle", "lead_gap_m"):
            if not len(getattr(self, name)):
                object.__setattr__(self, name, np.full(len(self.times_s), np.nan))
        if not len(self.foe_px):
            object.__setattr__(self, "foe_px", np.full((len(self.times_s), 2), np.nan))
        unsaid = {name: ABSENT for name in SIGNALS if name not in self.origins}
        object.__setattr__(self, "origins", {**self.origins, **unsaid})

    def __len__(self) -> int:
        return len(self.times_s)

    def known(self, name: str) -> Bools:
        """(N,) frames at which a signal is recorded, or follows from what is: neither assumed nor bridged."""
        there = np.full(len(self), self.origins[name].is_known)
        return there & ~self.bridged[name] if name in self.bridged else there

    @property
    def rate_hz(self) -> float:
        """Frames a second, by the median of the intervals."""
        return 1.0 / float(np.median(np.diff(self.times_s)))

    @property
    def derived(self) -> tuple[str, ...]:
        """The signals that were not recorded but computed or assumed."""
        return tuple(name for name, origin in self.origins.items() if origin.kind in ("derived", "assumed"))


SIGNALS = (
    "camera",
    "times_s",
    "poses",
    "speed_mps",
    "yaw_rate_radps",
    "foe_px",
    "steering_rad",
    "throttle",
    "obstacle",
    "lead_gap_m",
)


class Reader(Protocol):
    """One layout of recordings; a module of `vpf_sim.replay.readers` is one."""

    LAYOUT: str  # its name
    EXPECTED: str  # the files it is known by

    def recognises(self, folder: Path) -> bool:
        """Whether the content of the folder is of this layout, complete or not."""

    def read(self, folder: Path) -> Recording:
        """The recording; what is wrong with it is an InputError of one line."""
