"""What a driver of the user's own may change of the process beside driving, and how it is kept from all others."""

import os
import random
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True, slots=True)
class Settings:
    """What every function of the process is subject to: the working directory, numpy's error handling, the filters of
    warnings, OpenCV's threads."""

    place: str
    errors: Any
    filters: list[Any]
    threads: int

    @classmethod
    def now(cls) -> "Settings":
        cv2 = sys.modules.get("cv2")
        try:
            place = os.getcwd()
        except OSError:  # it is gone
            place = ""
        return cls(place, np.geterr(), list(warnings.filters), cv2.getNumThreads() if cv2 else 0)

    def apply(self) -> None:
        """Make them those of the process."""
        now = Settings.now()
        if now.place != self.place:
            with suppress(OSError):  # it is gone
                os.chdir(self.place)
        if now.errors != self.errors:
            np.seterr(**self.errors)
        if now.filters != self.filters:
            warnings.resetwarnings()
            for entry in reversed(self.filters):
                warnings.filters.insert(0, entry)  # type: ignore[attr-defined]
        if self.threads and now.threads != self.threads:
            sys.modules["cv2"].setNumThreads(self.threads)


@contextmanager
def preserved() -> Iterator[None]:
    """Whatever is done inside: the settings, the environment's variables and the global random numbers of Python and
    numpy are as before behind it."""
    settings, variables = Settings.now(), dict(os.environ)
    randoms, numbers = random.getstate(), np.random.get_state()  # noqa: NPY002 (the global one is what drivers change)
    try:
        yield
    finally:
        settings.apply()
        if dict(os.environ) != variables:
            os.environ.clear()
            os.environ.update(variables)
        random.setstate(randoms)
        np.random.set_state(numbers)  # noqa: NPY002


class Isolated:
    """An object of the user's own with settings of its own: what its code changes of them, it finds again, and nobody
    else does."""

    def __init__(self, own: Any) -> None:
        self._own = own
        self._settings = Settings.now()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or name in ("_own", "_settings"):  # of a copy that is not filled yet
            raise AttributeError(name)
        with self._there():
            value = getattr(self._own, name)
        if not callable(value):
            return value

        def call(*arguments: Any, **options: Any) -> Any:
            with self._there():
                return value(*arguments, **options)

        return call

    @contextmanager
    def _there(self) -> Iterator[None]:
        ours = Settings.now()
        self._settings.apply()
        try:
            yield
        finally:
            self._settings = Settings.now()
            ours.apply()
