"""Limit on the change of acceleration within a time window: bounds comfort jerk without delaying the brakes.

nuPlan fits the jerk as a slope over 1.5 s of acceleration. A step of D within that window is a jerk of at most D / 1 s,
however sudden. So a limit on the change within about half the window bounds the jerk, while a step is still possible. A
slope limit would delay the brakes.
"""

from collections import deque


class ChangeLimit:
    """The recent acceleration commands."""

    def __init__(self, limit_mps2: float, window_s: float, dt_s: float) -> None:
        self._limit_mps2 = limit_mps2
        self._last: deque[float] = deque(maxlen=max(1, round(window_s / dt_s)))

    def reset(self) -> None:
        """Forget the recent commands, for emergency braking."""
        self._last.clear()

    def limit(self, demand_mps2: float) -> float:
        """m/s2, the demand clipped to the limit; call once per step."""
        if self._last:
            demand_mps2 = min(max(demand_mps2, max(self._last) - self._limit_mps2), min(self._last) + self._limit_mps2)
        self._last.append(demand_mps2)
        return demand_mps2
