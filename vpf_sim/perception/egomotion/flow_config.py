"""What the flow follows, and how; and the bands of the picture that its corners are spread over."""

from dataclasses import dataclass
from math import inf
from typing import Literal


@dataclass(frozen=True, slots=True)
class Band:
    """A strip of the image with its own share of the corners, so that one strong edge does not starve the far road."""

    top: float  # tangent of the angle below the horizon
    bottom: float
    share: float  # of FlowConfig.points


BANDS = {
    "whole": (Band(-inf, inf, 1.0),),
    # Scenery, which holds the FOE's height; the road beyond 10 m and what stands on it; the road before it.
    "road": (Band(-0.35, 0.0, 0.2), Band(0.0, 0.14, 0.55), Band(0.14, 0.55, 0.25)),
}


@dataclass(frozen=True, slots=True)
class FlowConfig:
    """What is followed and how. The defaults are the paper's; the paper leaves corners and iterations open."""

    period_s: float = 0.0  # between two frames that are looked at; in between all is carried on by the own motion
    window_px: int = 25
    max_level: int | None = 2  # three levels; None: as many as `reach_px_per_s` needs
    epsilon_px: float = 0.03
    iterations: int = 30
    window_s: float = 0.1  # frames are chained over this time
    points: int = 300
    quality: float = 0.01
    min_distance_px: float = 7.0
    block_px: int = 3
    bands: Literal["whole", "road"] = "whole"
    detect_period_s: float = 0.1
    forward_backward_px: float | None = None  # largest distance after tracking back, once a period; None: no check
    reach_px_per_s: float = 400.0  # fastest motion to follow
    texture_floor: float = 0.0  # least small eigenvalue of a corner's structure tensor, grey levels^2 / px^2
    corner_ratio: float = 0.0  # and its least share of the large one: edges slide
    hold_s: float | None = None  # for so long a point is sought again that a wiper covers; None: it is taken along
    keyframe_s: float | None = None  # a point's first sighting is replaced by one between so old and twice; None: never

    def __post_init__(self) -> None:
        if self.window_px < 3 or self.window_px % 2 == 0:
            raise ValueError(f"window_px: expected an odd number >= 3, got {self.window_px}")
        if self.window_s <= 0.0 or self.detect_period_s <= 0.0:
            raise ValueError(f"window_s, detect_period_s: expected > 0, got {self.window_s}, {self.detect_period_s}")
        if not 0.0 <= self.period_s <= self.window_s:
            raise ValueError(f"period_s: expected 0 .. window_s = {self.window_s}, got {self.period_s}")
        if self.hold_s is not None and not self.hold_s > 0.0:
            raise ValueError(f"hold_s: expected > 0, got {self.hold_s}")
        if self.points < 8:
            raise ValueError(f"points: expected >= 8, got {self.points}")
        if self.bands not in BANDS:
            raise ValueError(f"bands: expected one of {sorted(BANDS)}, got '{self.bands}'")
