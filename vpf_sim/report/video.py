"""Frames into an .mp4 that a browser plays."""

from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Self

import av
import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.types import Image


class Writer:
    """Writes frames as H.264 at their true speed; a context manager, the file is whole when it closes.

    yuv420p and an index at the front (faststart) are what browsers ask for. Frames whose sides are odd lose their last
    row or column: the format has none.
    """

    def __init__(self, path: Path | str, size: tuple[int, int], rate_hz: float, crf: int = 20) -> None:
        """`size` is (width, height) px; `rate_hz` frames a second; `crf` x264's quality, more is smaller and worse."""
        self.path = Path(path)
        if self.path.suffix.lower() != ".mp4":
            raise InputError(f"video '{path}': expected a file name that ends in .mp4")
        self._width, self._height = (side - side % 2 for side in size)
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.path.open("wb").close()  # av would notice only at the first frame, and not say which file
            self._container = av.open(str(self.path), "w", format="mp4", options={"movflags": "+faststart"})
        except OSError as error:
            raise InputError(f"video '{path}': expected a file that can be written, got: {error.strerror}") from None
        rate = Fraction(rate_hz).limit_denominator(1001)
        self._stream = self._container.add_stream("libx264", rate=rate, options={"crf": str(crf), "preset": "veryfast"})
        self._stream.width, self._stream.height = self._width, self._height
        self._stream.pix_fmt = "yuv420p"
        self._stream.codec_context.thread_count = 1

    def write(self, frame_rgb: Image) -> None:
        """Append one (H, W, 3) frame."""
        cut = np.ascontiguousarray(frame_rgb[: self._height, : self._width])
        if cut.shape != (self._height, self._width, 3):
            expected = f"({self._height}, {self._width}, 3)"
            raise ValueError(f"frame: expected at least {expected}, got {frame_rgb.shape}")
        for packet in self._stream.encode(av.VideoFrame.from_ndarray(cut, format="rgb24")):
            self._container.mux(packet)

    def close(self) -> None:
        """Write what the encoder still holds, and the index."""
        for packet in self._stream.encode():
            self._container.mux(packet)
        self._container.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()
