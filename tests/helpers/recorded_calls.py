"""Records the calls of the core's module while frames are drawn, for replay.c."""

import struct
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, BinaryIO

import numpy as np
import pytest

from vpf_sim.envs.camera import glass
from vpf_sim.envs.camera.core import _core, frames
from vpf_sim.envs.camera.rain import streaks


class Recorder:
    """In place of the module: passes calls on, writes them down, and notes a checksum of their arrays afterwards."""

    def __init__(self, out: BinaryIO) -> None:
        self._out = out
        self._made: dict[int, int] = {}  # capsules by the number of the call that made them
        self._kept: list[Any] = []  # so that no capsule takes the place of another
        self.checksums: list[str] = []

    def __getattr__(self, name: str) -> Callable[..., Any]:
        function = getattr(_core, name)

        def called(*arguments: Any) -> Any:
            self._write(name.encode())
            self._write(arguments)
            result = function(*arguments)
            self._made[id(result)] = len(self.checksums)
            self._kept.append(result)
            arrays = b"".join(one.tobytes() for one in arguments if isinstance(one, np.ndarray))
            self.checksums.append(f"{name} {zlib.adler32(arrays):08x}")
            return result

        return called

    def _write(self, value: Any) -> None:
        if isinstance(value, tuple):
            self._head("t", len(value))
            for one in value:
                self._write(one)
        elif isinstance(value, (bytes, np.ndarray)):
            content = value if isinstance(value, bytes) else value.tobytes()
            self._head("a", len(content))
            self._out.write(content)
        elif isinstance(value, float):
            self._out.write(struct.pack("<qd", ord("d"), value))
        elif isinstance(value, (int, np.integer)):
            self._head("i", int(value))
        else:
            self._head("c", self._made[id(value)])

    def _head(self, kind: str, value: int) -> None:
        self._out.write(struct.pack("<qQ", ord(kind), value % 2**64))


@contextmanager
def recorded(out: BinaryIO) -> Iterator[Recorder]:
    """Record all calls of the core within this context."""
    recorder = Recorder(out)
    with pytest.MonkeyPatch.context() as patch:
        for module in (frames, glass, streaks):
            patch.setattr(module, "_core", recorder)
        yield recorder
