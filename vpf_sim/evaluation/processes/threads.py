"""One thread a process: episodes run side by side in workers, and results must not depend on the number of cores."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

LIMITS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS"), "1")


def are_limited() -> bool:
    """Whether the numeric libraries were told so before they were loaded."""
    return all(os.environ.get(name) == value for name, value in LIMITS.items())


@contextmanager
def limited_environment() -> Iterator[None]:
    """The environment in which to start a process; ours is restored behind it."""
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
    """The same for OpenCV, which takes it at run time; and no GPU, whose results would differ."""
    import cv2

    cv2.setNumThreads(1)
    cv2.ocl.setUseOpenCL(False)
