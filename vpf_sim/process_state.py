"""Isolation of process-wide settings that a user's driver may change."""

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
    """Process-wide settings: working directory, numpy's error handling, warning filters, OpenCV's threads."""

    directory: str
    errors: Any
    filters: list[Any]
    threads: int

    @classmethod
    def current(cls) -> "Settings":
        cv2 = sys.modules.get("cv2")
        try:
            directory = os.getcwd()
        except OSError:  # the directory was deleted
            directory = ""
        return cls(directory, np.geterr(), list(warnings.filters), cv2.getNumThreads() if cv2 else 0)

    def apply(self) -> None:
        """Set them in this process."""
        now = Settings.current()
        if now.directory != self.directory:
            with suppress(OSError):  # the directory was deleted
                os.chdir(self.directory)
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
    """Restore settings, environment variables and Python's and numpy's global random states on exit."""
    settings, variables = Settings.current(), dict(os.environ)
    python_state, numpy_state = random.getstate(), np.random.get_state()  # noqa: NPY002 (the global one is what drivers change)
    try:
        yield
    finally:
        settings.apply()
        if dict(os.environ) != variables:
            os.environ.clear()
            os.environ.update(variables)
        random.setstate(python_state)
        np.random.set_state(numpy_state)  # noqa: NPY002


class Isolated:
    """A user's object whose code runs under settings of its own; its changes persist for it alone."""

    def __init__(self, own: Any) -> None:
        self._own = own
        self._settings = Settings.current()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or name in ("_own", "_settings"):  # a copy that is not initialised yet
            raise AttributeError(name)
        with self._own_settings():
            value = getattr(self._own, name)
        if not callable(value):
            return value

        def call(*arguments: Any, **options: Any) -> Any:
            with self._own_settings():
                return value(*arguments, **options)

        return call

    @contextmanager
    def _own_settings(self) -> Iterator[None]:
        outer = Settings.current()
        self._settings.apply()
        try:
            yield
        finally:
            self._settings = Settings.current()
            outer.apply()


def unwrapped(value: Any) -> Any:
    """The object inside an Isolated one, or the value itself."""
    return value._own if isinstance(value, Isolated) else value
