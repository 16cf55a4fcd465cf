"""One thread per process: workers run side by side, and results must not depend on the number of cores."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

LIMITS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS"), "1")


def are_limited() -> bool:
    """Whether the environment limits the numeric libraries to one thread."""
    return all(os.environ.get(name) == value for name, value in LIMITS.items())


@contextmanager
def limited_environment() -> Iterator[None]:
    """Set the limits in the environment while a process starts, and restore it."""
    before = {name: os.environ.get(name) for name in LIMITS}
    os.environ.update(LIMITS)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def limit_opencv() -> None:
    """Limit OpenCV to one thread and no GPU, whose results would differ."""
    import cv2

    cv2.setNumThreads(1)
    cv2.ocl.setUseOpenCL(False)


@contextmanager
def one_thread() -> Iterator[None]:
    """Drive in a process of the user's as in one of ours; its number of OpenCV's threads is restored.

    The threads of numpy's BLAS are read from the environment when numpy is imported, and stay. An episode then computes
    about 10 % more on two cores, with the same states; the environment variable OPENBLAS_NUM_THREADS=1 avoids it.
    """
    import cv2

    threads = cv2.getNumThreads()
    limit_opencv()
    try:
        yield
    finally:
        cv2.setNumThreads(threads)
