"""When periodic work is due: periods in seconds, counted in frames."""


class Schedule:
    """Work with a period in seconds, done at whole frames: the nearest number to the period, at least one.

    `at_least_as_often` rounds down instead. At 10 frames a second a period of 0.2 s is two frames.
    """

    def __init__(self, period_s: float, rate_hz: float, at_least_as_often: bool = False) -> None:
        count = period_s * rate_hz
        self.frames = max(1, int(count + 1e-6) if at_least_as_often else round(count))
        self.rate_hz = rate_hz / self.frames
        self._frame = 0

    @property
    def is_due(self) -> bool:
        """Whether work is due at the next frame."""
        return self._frame % self.frames == 0

    def step(self) -> bool:
        """Whether work is due at this frame, as it is at the first."""
        due = self.is_due
        self._frame += 1
        return due
