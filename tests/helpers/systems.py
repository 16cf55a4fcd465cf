"""What tests need of the operating system that they run on."""

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

POSIX_ONLY = pytest.mark.skipif(os.name != "posix", reason="the test itself uses POSIX signals, devices or shells")


@contextmanager
def at_most(seconds: float, computing: bool = False) -> Iterator[None]:
    """AssertionError after that time, or computing time; no limit on Windows, which has no alarms."""
    if os.name != "posix":
        yield
        return

    def give_up(*_: object) -> None:
        raise AssertionError(f"{'computes' if computing else 'hangs'} for {seconds} s")

    number, timer = (signal.SIGPROF, signal.ITIMER_PROF) if computing else (signal.SIGALRM, signal.ITIMER_REAL)
    before = signal.signal(number, give_up)
    signal.setitimer(timer, seconds)
    try:
        yield
    finally:
        signal.setitimer(timer, 0)
        signal.signal(number, before)
