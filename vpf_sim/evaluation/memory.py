"""The memory of long-lived workers: what an episode freed goes back to the system."""

import ctypes
import sys


def give_back_memory() -> None:
    """Have the C library return its free pages, where it can (glibc's malloc_trim).

    It keeps them otherwise, in arenas that grow with the busiest episode so far: tens of megabytes a worker.
    """
    if sys.platform == "linux":
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
        if trim is not None:
            trim(0)
