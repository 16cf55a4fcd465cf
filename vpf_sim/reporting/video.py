"""Writes frames to an .mp4 that browsers play."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.files import Draft
from vpf_sim.types import Image

try:
    import av
except ImportError:  # the extra `video` is not installed
    av = None  # type: ignore[assignment]

INSTALL = "pip install 'vpf_sim[video]'"


def is_available() -> bool:
    """Whether videos can be written and read."""
    return av is not None


def can_film(count: int, notify: Callable[[str], None]) -> bool:
    """Whether `count` videos can be written; `notify` receives why not."""
    if count and not is_available():
        notify(f"no videos: PyAV is not installed: {INSTALL}")
    return count > 0 and is_available()


def require(what: str) -> None:
    """InputError, which begins with `what`, where PyAV is not installed."""
    if not is_available():
        raise InputError(f"{what}: expected PyAV, which is not installed: {INSTALL}")


def middle_frame(path: Path) -> Image | None:
    """(H, W, 3) a frame near the middle of a video; None if it cannot be read."""
    if not is_available():
        return None
    try:
        with av.open(str(path)) as container:
            container.seek((container.duration or 0) // 2)
            frame = next(container.decode(video=0), None)
    except av.error.FFmpegError:
        return None
    return None if frame is None else np.asarray(frame.to_ndarray(format="rgb24"), np.uint8)


class Writer:
    """Writes frames as H.264 at true speed; a context manager that commits the file when it closes.

    A full disk raises at close, so that the recorded episode goes on; a former file is kept. Browsers need yuv420p and
    an index at the front (faststart). The format has even sides only, so an odd last row or column is dropped.
    """

    def __init__(
        self, path: Path | str, size: tuple[int, int], rate_hz: float, crf: int = 20, gop: int | None = None
    ) -> None:
        """`size` is (width, height) px; `crf` is x264's quality: a higher value gives a smaller, worse video.

        `gop` is the number of frames from one key frame to the next, few for random access; None is x264's.
        """
        require(f"video '{path}'")
        self.path = Path(path)
        if self.path.suffix.lower() != ".mp4":
            raise InputError(f"video '{path}': expected a file name that ends in .mp4")
        self._width, self._height = (side - side % 2 for side in size)
        try:
            self._draft = Draft(self.path)
            self._container = av.open(str(self._draft.file), "w", format="mp4", options={"movflags": "+faststart"})
        except OSError as error:
            raise InputError(f"video '{path}': expected a file that can be written, got: {error.strerror}") from None
        rate = Fraction(rate_hz).limit_denominator(1001)
        options = {"crf": str(crf), "preset": "veryfast", **({} if gop is None else {"g": str(gop), "bf": "0"})}
        self._stream = self._container.add_stream("libx264", rate=rate, options=options)
        self._stream.width, self._stream.height = self._width, self._height
        self._stream.pix_fmt = "yuv420p"
        self._stream.codec_context.thread_count = 1
        self._fault: OSError | None = None

    def write(self, frame_rgb: Image) -> None:
        """Append an (H, W, 3) frame."""
        cut = np.ascontiguousarray(frame_rgb[: self._height, : self._width])
        if cut.shape != (self._height, self._width, 3):
            expected = f"({self._height}, {self._width}, 3)"
            raise ValueError(f"frame: expected at least {expected}, got {frame_rgb.shape}")
        if self._fault is None:
            with self._keeping_first_fault():
                self._container.mux(self._stream.encode(av.VideoFrame.from_ndarray(cut, format="rgb24")))

    def close(self) -> None:
        """Flush the encoder and write the index; OSError if the video could not be written."""
        if self._fault is None:
            with self._keeping_first_fault():
                self._container.mux(self._stream.encode())
        with self._keeping_first_fault():
            self._container.close()
        if self._fault is not None:
            self._draft.discard()
            raise self._fault
        self._draft.commit()

    def discard(self) -> None:
        """Remove the incomplete video."""
        with self._keeping_first_fault():
            self._container.close()
        self._draft.discard()

    @contextmanager
    def _keeping_first_fault(self) -> Iterator[None]:
        """Store the first write error instead of raising it."""
        try:
            yield
        except (OSError, av.error.FFmpegError) as error:
            self._fault = self._fault or self._draft.fault(error)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
        else:
            self.discard()
