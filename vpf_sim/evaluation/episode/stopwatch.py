"""Times of the stages of a step, taken from outside: the code that is timed knows nothing of it."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from time import perf_counter
from typing import Any

import numpy as np

WINDOW_STEPS = 30  # half a second: not all stages run in every step


class Stopwatch:
    """Milliseconds that each stage took in each step; a stage that is called twice in a step counts as one."""

    def __init__(self) -> None:
        self._step_ms: dict[str, float] = {}
        self._steps_ms: list[dict[str, float]] = []

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time what is done inside."""
        started_s = perf_counter()
        try:
            yield
        finally:
            self._add(name, started_s)

    def end_step(self) -> None:
        """The next times are another step's."""
        self._steps_ms.append(self._step_ms)
        self._step_ms = {}

    def skip_step(self) -> None:
        """Forget what was timed since the last step."""
        self._step_ms = {}

    def medians_ms(self) -> dict[str, float]:
        """The median of each stage over the steps in which it ran."""
        return {name: float(np.median([step[name] for step in self._steps_ms if name in step])) for name in self._names}

    def typical_ms(self, window: int = WINDOW_STEPS) -> dict[str, float]:
        """What each stage takes a step: the median, over windows of so many steps, of the mean.

        A stage that runs in some steps only counts by its share of them; what disturbs a window now and then does not.
        """
        if not self._steps_ms:
            return {}
        names = self._names
        count = max(len(self._steps_ms) // window, 1)
        windows = np.array_split(np.array([[step.get(name, 0.0) for name in names] for step in self._steps_ms]), count)
        typical = np.median([part.mean(axis=0) for part in windows], axis=0)
        return dict(zip(names, typical.tolist(), strict=True))

    @property
    def _names(self) -> list[str]:
        """The stages, in the order in which they first ran."""
        return list({name: None for step in self._steps_ms for name in step})

    @contextmanager
    def watching(self, stages: Mapping[str, str]) -> Iterator[None]:
        """Time the functions at "module:attribute" or "module:Class.method" under the names that they have here."""
        places = [(*_place(path), name) for name, path in stages.items()]
        originals = [(owner, attribute, getattr(owner, attribute)) for owner, attribute, _ in places]
        try:
            for owner, attribute, name in places:
                setattr(owner, attribute, self._timed(getattr(owner, attribute), name))
            yield
        finally:
            for owner, attribute, original in reversed(originals):
                setattr(owner, attribute, original)

    def _timed(self, function: Callable[..., Any], name: str) -> Callable[..., Any]:
        def timed(*arguments: Any, **named: Any) -> Any:
            started_s = perf_counter()
            try:
                return function(*arguments, **named)
            finally:
                self._add(name, started_s)

        return timed

    def _add(self, name: str, started_s: float) -> None:
        self._step_ms[name] = self._step_ms.get(name, 0.0) + 1e3 * (perf_counter() - started_s)


def _place(path: str) -> tuple[Any, str]:
    """The module or class that holds a function, and its name there."""
    module, _, attributes = path.partition(":")
    *owners, attribute = attributes.split(".")
    owner = import_module(module)
    for name in owners:
        owner = getattr(owner, name)
    return owner, attribute
