"""Standard output and error, so that the answer comes alone and whole, in whatever the terminal can show."""

import io
import os
import sys
from typing import Any, TextIO


class _Outlet(io.FileIO):
    """A descriptor that goes on as if its reader were there when it has gone: `vpf-sim ... | head`."""

    def write(self, data: Any) -> int:
        try:
            return super().write(data)
        except BrokenPipeError:
            return len(data)


def take() -> None:
    """Keep the descriptor of standard output for the answer alone: what is written to number 1 from here on, by native
    code as well, goes to standard error. Characters that an output cannot take are written as escapes."""
    try:
        answer = os.dup(1)
        os.dup2(2, 1)
    except OSError:  # closed by who started us
        return
    sys.stdout = _opened(answer, sys.stdout)
    sys.stderr = _opened(os.dup(2), sys.stderr)


def _opened(descriptor: int, like: TextIO) -> TextIO:
    """A text stream to a descriptor, line by line on a terminal and for errors."""
    os.set_inheritable(descriptor, False)
    outlet = _Outlet(descriptor, "w")
    by_line = like is sys.stderr or outlet.isatty()
    encoding = getattr(like, "encoding", None) or "utf-8"
    return io.TextIOWrapper(
        io.BufferedWriter(outlet), encoding, errors="backslashreplace", line_buffering=by_line, write_through=by_line
    )
