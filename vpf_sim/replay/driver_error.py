"""A driver that raises on a recording: the frames before it are kept, the record says where it ended."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from vpf_sim.errors import InputError


class DriverError(Exception):
    """The driver raised at a frame; the exception itself is its cause."""

    def __init__(self, frame: int, error: BaseException) -> None:
        self.frame = frame
        self.error = error
        super().__init__(f"frame {frame}, at {place(error)}: {what(error)}")

    def entry(self) -> dict[str, Any]:
        """The `error` of the drive's record."""
        return {"frame": self.frame, "place": place(self.error), "what": what(self.error)}


@contextmanager
def at_frame(frame: int) -> Iterator[None]:
    """Turn exceptions other than InputError into a DriverError at this frame."""
    try:
        yield
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        raise DriverError(frame, error) from error


def place(error: BaseException) -> str:
    """Module, line and function where an exception was raised."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    if trace is None:
        return "an unknown place"
    code = trace.tb_frame
    return f"{code.f_globals.get('__name__', code.f_code.co_filename)}:{trace.tb_lineno} in {code.f_code.co_name}"


def what(error: BaseException) -> str:
    """The exception in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())
