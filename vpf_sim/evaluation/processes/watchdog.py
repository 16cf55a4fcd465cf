"""A time limit for this process, by faulthandler's watchdog thread, which needs no GIL."""

import faulthandler
from collections.abc import Iterator
from contextlib import contextmanager
from math import isfinite


@contextmanager
def at_most(limit_s: float, log: int) -> Iterator[None]:
    """A context that ends the process after `limit_s`; the stack at that time or at a crash is written to `log`.

    A process has one watchdog, so contexts must not nest or overlap.
    """
    faulthandler.enable(log)
    if isfinite(limit_s):
        faulthandler.dump_traceback_later(limit_s, exit=True, file=log)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()
