"""A limit to what runs in this process, whatever it hangs in: Python's watchdog is a thread that needs no GIL."""

import faulthandler
from collections.abc import Iterator
from contextlib import contextmanager
from math import isfinite


@contextmanager
def at_most(limit_s: float, log: int) -> Iterator[None]:
    """A context that ends the process after `limit_s`; where the code was then, or crashed, is written to file `log`.

    A process has one watchdog, so contexts must not be nested or run side by side.
    """
    faulthandler.enable(log)
    if isfinite(limit_s):
        faulthandler.dump_traceback_later(limit_s, exit=True, file=log)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()
