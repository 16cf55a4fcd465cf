"""A recorded drive of any layout: frames, times, camera, motion, commands and ground truth.

Vehicle axes: X forward, Y right, yaw clockwise. Every reader converts its signs and units to these.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, Protocol

import numpy as np

from vpf_sim.replay import fixed_structure
from vpf_sim.replay.fixed_structure import FixedStructure
from vpf_sim.replay.image_files import Frame
from vpf_sim.replay.mounting_estimate import Angle
from vpf_sim.types import Bools, Camera, Floats

Kind = Literal["recorded", "derived", "assumed", "absent"]
Assumption = Literal["lens", "height", "height by lanes"]  # of the camera
IMAGES = "images"  # name of the flow among the inputs of a signal


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a signal comes from."""

    kind: Kind
    how: str = ""  # file and column, computation, or assumption
    inputs: frozenset[str] = frozenset()  # all direct and indirect inputs: signals' names, or IMAGES

    @classmethod
    def derived_from(cls, how: str, inputs: "Mapping[str, Origin]") -> "Origin":
        """Origin of a signal computed from others: assumed if one of them is, else derived."""
        guessed = [name for name, origin in inputs.items() if origin.kind == "assumed"]
        assumed = "".join(f"; {name} is assumed" for name in guessed)
        every = frozenset(inputs).union(*(origin.inputs for origin in inputs.values()))
        return cls("assumed" if guessed else "derived", how + assumed, every)

    @property
    def is_known(self) -> bool:
        """Whether the signal can serve as a reference: nothing in it is assumed."""
        return self.kind in ("recorded", "derived")

    def __str__(self) -> str:
        return f"{self.kind}: {self.how}" if self.how else self.kind


ABSENT = Origin("absent")


@dataclass(frozen=True, slots=True)
class Recording:
    """N frames and the signals at each, nan where unknown; `origins` has an entry for every signal.

    The pose is the position of the camera with the heading of the vehicle. `camera` describes the frames; other
    effects of lens and mounting (tangential distortion, yaw, roll) are removed from them.
    """

    name: str
    layout: str  # such as "KITTI odometry"
    camera: Camera
    times_s: Floats  # (N,) ascending
    poses: Floats  # (N, 3) x m, y m, yaw rad
    speed_mps: Floats  # (N,)
    yaw_rate_radps: Floats  # (N,) + turns right
    frames: Callable[[], Iterator[Frame]]  # N of them, gaps included, decoded on demand
    origins: Mapping[str, Origin]  # by the names of the signals, and "camera"
    foe_px: Floats = field(default_factory=lambda: np.empty(0))  # (N, 2) truth for the motion from the frame before,
    # in the axes halfway between, undistorted
    steering_rad: Floats = field(default_factory=lambda: np.empty(0))  # (N,) of the road wheels, + is right
    throttle: Floats = field(default_factory=lambda: np.empty(0))  # (N,) -1 .. 1, negative brakes
    obstacle: Floats = field(default_factory=lambda: np.empty(0))  # (N,) 1 where labelled as blocked, else 0
    lead_gap_m: Floats = field(default_factory=lambda: np.empty(0))  # (N,) from the camera to the lead vehicle
    weather: str = ""  # as recorded; empty if not
    notes: tuple[str, ...] = ()  # gaps and assumptions, a line each
    mounting_found: Mapping[str, Angle] = field(default_factory=dict)  # estimated "pitch" and "yaw"
    fixed: Callable[[], FixedStructure | None] | None = None  # what is fixed to the camera; None: to find in `frames`
    assumed: frozenset[Assumption] = frozenset()  # what is not known of the camera
    no_images: str = ""  # reason and remedy; `frames` raises it as an InputError
    files: tuple[Path | None, ...] = ()  # images and other files it is read from; some may be missing
    bridged: Mapping[str, Bools] = field(default_factory=dict)  # (N,) where a signal is interpolated over a gap

    def __post_init__(self) -> None:
        for name in ("steering_rad", "throttle", "obstacle", "lead_gap_m"):
            if not len(getattr(self, name)):
                object.__setattr__(self, name, np.full(len(self.times_s), np.nan))
        if not len(self.foe_px):
            object.__setattr__(self, "foe_px", np.full((len(self.times_s), 2), np.nan))
        missing = {name: ABSENT for name in SIGNALS if name not in self.origins}
        object.__setattr__(self, "origins", {**self.origins, **missing})

    def __len__(self) -> int:
        return len(self.times_s)

    def known(self, name: str) -> Bools:
        """(N,) frames where a signal is neither assumed nor bridged."""
        there = np.full(len(self), self.origins[name].is_known)
        return there & ~self.bridged[name] if name in self.bridged else there

    def fixed_to_camera(self) -> FixedStructure | None:
        """What is fixed to the camera in the frames; None if that cannot be known."""
        if self.no_images:
            return None
        return self.fixed() if self.fixed else fixed_structure.find(self.frames(), self.times_s)

    @property
    def rate_hz(self) -> float:
        """Frames a second, by the median interval."""
        return 1.0 / float(np.median(np.diff(self.times_s)))

    @property
    def derived(self) -> tuple[str, ...]:
        """The signals that were not recorded."""
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
    """One layout of recordings; the modules of `vpf_sim.replay.readers` are readers."""

    LAYOUT: str  # name
    EXPECTED: str  # files that identify it

    def recognises(self, folder: Path) -> bool:
        """Whether the folder has this layout, complete or not."""

    def read(self, folder: Path) -> Recording:
        """The recording; InputError of one line where it is wrong."""
