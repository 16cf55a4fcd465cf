"""How much an acceleration changes within a time: comfort's bound on jerk that leaves braking its reaction.

nuPlan takes the jerk as the slope of a line laid through 1.5 s of the acceleration. A step of D within it is a jerk of
no more than D / 1 s, however sudden: so a bound of the change within about half that window bounds the jerk, and the
brakes may still bite at once. A bound of the command's own slope would do so only by delaying them.
"""

from collections import deque


class ChangeLimit:
    """The accelerations asked for last."""

    def __init__(self, most_mps2: float, within_s: float, dt_s: float) -> None:
        self._most_mps2 = most_mps2
        self._last: deque[float] = deque(maxlen=max(1, round(within_s / dt_s)))

    def reset(self) -> None:
        """What comes next has nothing to be smooth with: the car brakes in need."""
        self._last.clear()

    def limit(self, wish_mps2: float) -> float:
        """m/s2 of the next step of dt, as near to the wish as the bound lets it."""
        if self._last:
            wish_mps2 = min(max(wish_mps2, max(self._last) - self._most_mps2), min(self._last) + self._most_mps2)
        self._last.append(wish_mps2)
        return wish_mps2
