"""Heading and speed reference from the total force (paper, sections V and VI): psi_d = atan(F_Y' / F_X')."""

from math import atan, atan2, hypot
from typing import Literal

from vpf_sim.configuration import setting, settings
from vpf_sim.geometry import wrap_angle
from vpf_sim.types import Floats


@settings
class ReferenceConfig:
    """How the force becomes a heading."""

    heading: Literal["printed", "repaired"] = setting(
        "Heading: `printed`, atan, the same ahead and behind, or `repaired`, atan2."
    )


class HeadingReference:
    """psi_d of the force in the world; the last one where the force vanishes."""

    def __init__(self, config: ReferenceConfig, yaw_rad: float) -> None:
        self._config = config
        self._last_rad = yaw_rad

    def update(self, force_world: Floats) -> float:
        """rad in [-pi, pi)."""
        x, y = float(force_world[0]), float(force_world[1])
        if hypot(x, y) > 0.0:
            repaired = self._config.heading == "repaired" or x == 0.0
            self._last_rad = wrap_angle(atan2(y, x) if repaired else atan(y / x))
        return self._last_rad
