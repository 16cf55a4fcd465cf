"""A stopwatch for named stages: code marks its stages, and whoever wants times switches a stopwatch on."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from time import perf_counter
from typing import ParamSpec, TypeVar

import numpy as np

WINDOW_STEPS = 30  # half a second: some stages run in one step of three only

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class Stopwatch:
    """Milliseconds of each stage in each step; calls of one stage within a step add up."""

    def __init__(self) -> None:
        self._step_ms: dict[str, float] = {}
        self._steps_ms: list[dict[str, float]] = []

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time the body of a `with` statement."""
        started_s = perf_counter()
        try:
            yield
        finally:
            self.add(name, started_s)

    def add(self, name: str, started_s: float) -> None:
        """Add the time since `started_s`, of `perf_counter`, to a stage."""
        self._step_ms[name] = self._step_ms.get(name, 0.0) + 1e3 * (perf_counter() - started_s)

    def end_step(self) -> None:
        """Close the step; later times belong to the next one."""
        self._steps_ms.append(self._step_ms)
        self._step_ms = {}

    def skip_step(self) -> None:
        """Drop the times since the last step."""
        self._step_ms = {}

    def medians_ms(self) -> dict[str, float]:
        """The median of each stage over the steps in which it ran."""
        return {name: float(np.median([step[name] for step in self._steps_ms if name in step])) for name in self._names}

    def typical_ms(self, window: int = WINDOW_STEPS) -> dict[str, float]:
        """The time of each stage in a step: the median over windows of `window` steps of the mean within each.

        A stage that runs in some steps only counts by its share; a short disturbance does not count.
        """
        if not self._steps_ms:
            return {}
        names = self._names
        count = max(len(self._steps_ms) // window, 1)
        windows = np.array_split(np.array([[step.get(name, 0.0) for name in names] for step in self._steps_ms]), count)
        typical = np.median([part.mean(axis=0) for part in windows], axis=0)
        return dict(zip(names, typical.tolist(), strict=True))

    @contextmanager
    def running(self) -> Iterator[None]:
        """Time all marked stages meanwhile; one stopwatch runs at a time."""
        global _running
        before, _running = _running, self
        try:
            yield
        finally:
            _running = before

    @property
    def _names(self) -> list[str]:
        """The stages in the order in which they first ran."""
        return list({name: None for step in self._steps_ms for name in step})


_running: Stopwatch | None = None


def call(name: str, function: Callable[Arguments, Result], *args: Arguments.args, **named: Arguments.kwargs) -> Result:
    """Call a function as the stage of that name."""
    if (watch := _running) is None:
        return function(*args, **named)
    started_s = perf_counter()
    try:
        return function(*args, **named)
    finally:
        watch.add(name, started_s)


def timed(name: str) -> Callable[[Callable[Arguments, Result]], Callable[Arguments, Result]]:
    """Mark a function as the stage of that name. A name with a point is a part of the stage before the point."""

    def mark(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
        @wraps(function)
        def marked(*args: Arguments.args, **named: Arguments.kwargs) -> Result:
            return function(*args, **named) if _running is None else call(name, function, *args, **named)

        return marked

    return mark
