"""What a driver of the user's own may change of the process beside driving, and how it is kept from all others."""

import os
import random
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np


@contextmanager
def kept() -> Iterator[None]:
    """Whatever is done inside: the working directory, the environment's variables, Python's and numpy's global random
    numbers, filters of warnings, numpy's error handling and OpenCV's threads are as before behind it."""
    place, variables = os.getcwd(), dict(os.environ)
    randoms, numbers = random.getstate(), np.random.get_state()  # noqa: NPY002 (the global one is what drivers change)
    filters, errors = warnings.filters[:], np.geterr()
    cv2 = sys.modules.get("cv2")
    threads = cv2.getNumThreads() if cv2 else 0
    try:
        yield
    finally:
        with suppress(OSError):  # it is gone
            os.chdir(place)
        if dict(os.environ) != variables:
            os.environ.clear()
            os.environ.update(variables)
        random.setstate(randoms)
        np.random.set_state(numbers)  # noqa: NPY002
        warnings.filters[:] = filters  # type: ignore[index]
        np.seterr(**errors)
        if cv2 and cv2.getNumThreads() != threads:
            cv2.setNumThreads(threads)


class InItsOwnPlace:
    """An object of the user's own whose working directory is its own: where its code goes, it finds itself again, and
    nobody else is moved."""

    def __init__(self, own: Any) -> None:
        self._own = own
        self._place = os.getcwd()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or name in ("_own", "_place"):  # of a copy that is not filled yet
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
        ours = os.getcwd()
        with suppress(OSError):
            os.chdir(self._place)
        try:
            yield
        finally:
            with suppress(OSError):
                self._place = os.getcwd()
            os.chdir(ours)
