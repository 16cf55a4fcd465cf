"""Standard output for the command's answer alone, in any encoding."""

import io
import os
import sys
from typing import Any, TextIO


class _PipeTolerantFile(io.FileIO):
    """A file that ignores a closed reader, as in `vpf-sim ... | head`."""

    def write(self, data: Any) -> int:
        try:
            return super().write(data)
        except BrokenPipeError:
            return len(data)


def reserve_stdout() -> None:
    """Reserve standard output for the answer; all other writes to descriptor 1, also by native code, go to stderr.

    Characters that the encoding lacks are written as escapes.
    """
    for name in ("stdout", "stderr"):
        # One that the parent process closed: the next file that is opened would take its place.
        if getattr(sys, name) is None:
            setattr(sys, name, _text_stream(os.open(os.devnull, os.O_WRONLY), None))
    try:
        answer = os.dup(1)
        os.dup2(2, 1)
    except OSError:
        return
    sys.stdout = _text_stream(answer, sys.stdout)
    sys.stderr = _text_stream(os.dup(2), sys.stderr)


def _text_stream(descriptor: int, like: TextIO | None) -> TextIO:
    """A text stream on a descriptor, line-buffered on a terminal and for stderr."""
    os.set_inheritable(descriptor, False)
    file = _PipeTolerantFile(descriptor, "w")
    by_line = like is sys.stderr or file.isatty()
    encoding = getattr(like, "encoding", None) or "utf-8"
    return io.TextIOWrapper(
        io.BufferedWriter(file), encoding, errors="backslashreplace", line_buffering=by_line, write_through=by_line
    )
