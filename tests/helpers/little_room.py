"""A disk without room, by the limit on the size of files: writes stop short or fail in the kernel, as on a full one."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest


@contextmanager
def limited(size: int) -> Iterator[None]:
    """No file of this process may grow beyond `size` bytes."""
    resource = pytest.importorskip("resource", reason="the limit on the size of files is POSIX's")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
