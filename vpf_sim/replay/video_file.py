"""Reads a video as frames with their own times, as players show them.

That is the main stream, upright, with square pixels and edit lists applied. Variable rates, damage and missing ends
are handled and noted.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, cast

import cv2
import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.replay.image_files import Frame
from vpf_sim.reporting.video import require
from vpf_sim.types import Floats, Image

try:
    import av
except ImportError:  # the extra `video` is not installed
    av = None  # type: ignore[assignment]

if TYPE_CHECKING:
    from av.packet import Packet as AnyPacket
    from av.video.stream import VideoStream

    Packet = AnyPacket[VideoStream]

CONTAINERS = (".mp4", ".mov", ".mkv", ".avi", ".webm", ".m4v", ".ts", ".mts", ".m2ts", ".mpg", ".mpeg", ".3gp", ".wmv")
BARE = (".hevc", ".h264", ".h265", ".264", ".265")  # raw streams without times
SUFFIXES = CONTAINERS + BARE
TURNS = {90: cv2.ROTATE_90_COUNTERCLOCKWISE, 180: cv2.ROTATE_180, 270: cv2.ROTATE_90_CLOCKWISE}
MOST_STRETCHED = 4  # largest plausible pixel aspect ratio
NO_TIMES = (
    "expected a video with times of its frames, found none: "
    "set rate_hz in drive.toml, or convert it: ffmpeg -framerate RATE -i FILE -c copy drive.mp4"
)


@dataclass(frozen=True, slots=True)
class Video:
    """A video's index; only its first frame is decoded."""

    path: Path
    stream: int  # index of the video stream
    width_px: int
    height_px: int
    stamps: tuple[int, ...]  # of the N frames, ascending; empty if it has none
    times_s: Floats  # (N,) from the first frame
    notes: tuple[str, ...]

    def frames(self) -> Iterator[Frame]:
        """N frames; damaged or missing ones are gaps."""
        place = {stamp: index for index, stamp in enumerate(self.stamps)}
        expected = 0
        for stamp, image in _decoded(self.path, self.stream):
            index = place.get(stamp, expected) if stamp is not None and place else expected
            if index < expected or index >= len(self.times_s):
                continue  # a repeated stamp, or a frame that is not in the index
            yield from (_gap(missing) for missing in range(expected, index))
            yield self._frame(index, image)
            expected = index + 1
        yield from (_gap(missing) for missing in range(expected, len(self.times_s)))

    def _frame(self, index: int, image: Image | None) -> Frame:
        """The frame, a gap if its size differs from the first one's."""
        if image is None:
            return _gap(index)
        height, width = image.shape[:2]
        if (width, height) == (self.width_px, self.height_px):
            return Frame(index, image)
        return Frame(index, None, f"frame {index} of the video has {width} x {height} px, unlike the first")


def _gap(index: int) -> Frame:
    return Frame(index, None, f"frame {index} of the video cannot be decoded")


def read(path: Path, times_s: Floats | None = None, rate_hz: float | None = None) -> Video:
    """The video's index.

    `times_s` (N,) or `rate_hz` replace missing or wrong times of the stream.
    """
    require(str(path))
    try:
        index = _index(path)
    except (av.error.FFmpegError, OSError) as error:
        raise InputError(f"{path}: expected a video, cannot be opened: {_reason(error)}") from None
    first = next((image for _, image in _decoded(path, index.stream) if image is not None), None)
    if first is None or index.packets < 2:
        raise InputError(f"{path}: expected a video of two frames or more, found {index.packets} that decode")
    height, width = first.shape[:2]
    notes = tuple(f"{path.name}: {note}" for note in index.notes())
    stamps = tuple(sorted(set(index.stamps)))
    if rate_hz is not None:
        times_s = np.arange(index.packets) / rate_hz
    if times_s is not None:
        count = min(len(times_s), index.packets)
        if len(times_s) != index.packets:
            notes = (*notes, f"{path.name}: {index.packets} frames, {len(times_s)} times; {count} are used")
        stamps = stamps[:count] if len(stamps) == index.packets else ()
        return Video(path, index.stream, width, height, stamps, times_s[:count] - times_s[0], notes)
    if len(stamps) < 2:
        raise InputError(f"{path}: {NO_TIMES}")
    own_s = (np.array(stamps, float) - stamps[0]) * index.base_s
    return Video(path, index.stream, width, height, stamps, own_s, notes)


@dataclass(slots=True)
class _Index:
    """Index of a video stream by its packets."""

    stream: int  # index of the video stream
    size_px: tuple[int, int]  # as stored
    pixel: Fraction  # width / height
    base_s: float
    claimed: int  # number of frames by the header; 0 if unknown
    stamps: list[int] = field(default_factory=list)  # of the shown packets
    packets: int = 0  # shown
    hidden: int = 0  # by an edit list; the decoder needs them
    others: int = 0  # further streams of two frames or more

    def notes(self) -> list[str]:
        """Notes on the video, one line each."""
        notes = []
        there, known = self.packets + self.hidden, len(set(self.stamps))
        if there < self.claimed:
            notes.append(f"truncated: {there} of {self.claimed} frames are there")
        if 0 < known < self.packets:
            notes.append(f"{self.packets - known} frames with a repeated or missing time are removed")
        if self.others:
            width, height = self.size_px
            notes.append(f"{self.others + 1} video streams; the one of {width} x {height} px is used")
        if self.pixel != 1:
            ratio = f"{self.pixel.numerator}:{self.pixel.denominator}"
            notes.append(f"its pixels are not square ({ratio}): frames are stretched as players do")
        return notes


def _index(path: Path) -> _Index:
    """Index of the stream with the largest images; still images (thumbnails, covers) are ignored."""
    with av.open(str(path)) as container:
        streams = container.streams.video
        if not streams or container.format.name == "tty":  # this format accepts any text
            raise InputError(f"{path}: expected a video, found no images in it")
        found = [
            _Index(k, (one.width, one.height), _pixel(one), float(one.time_base or 0), one.frames)
            for k, one in enumerate(streams)
        ]
        by_stream = {one.index: index for one, index in zip(streams, found, strict=True)}
        for packet in _packets(container, *streams):
            index = by_stream[packet.stream_index]
            index.hidden += packet.is_discard
            index.packets += not packet.is_discard
            if packet.pts is not None and not packet.is_discard:
                index.stamps.append(packet.pts)
    videos = [index for index in found if index.packets > 1] or found
    best = max(videos, key=lambda index: index.size_px[0] * index.size_px[1])
    best.others = len(videos) - 1
    if best.packets + best.hidden < best.claimed:  # truncated, or an edit list hides whole groups
        with av.open(str(path), options={"ignore_editlist": "1"}) as container:
            packets = sum(1 for _ in _packets(container, container.streams.video[best.stream]))
        best.hidden = max(best.hidden, packets - best.packets)
    return best


def _pixel(stream: "VideoStream") -> Fraction:
    """Width / height of a pixel; 1 where missing or implausible."""
    ratio = Fraction(stream.sample_aspect_ratio or 1)
    return ratio if 1 / MOST_STRETCHED <= ratio <= MOST_STRETCHED else Fraction(1)


def _packets(container: "av.container.InputContainer", *streams: "VideoStream") -> "Iterator[Packet]":
    """The packets that hold a frame, as far as the file goes."""
    packets = cast("Iterator[Packet]", container.demux(*streams))
    while True:
        try:
            packet = next(packets)
        except (StopIteration, av.error.FFmpegError):
            return
        if packet.size:
            yield packet


def _decoded(path: Path, number: int) -> Iterator[tuple[int | None, Image | None]]:
    """(stamp, (H, W, 3) RGB) in display order; no image where the decoder reports damage."""
    with av.open(str(path)) as container:
        stream = container.streams.video[number]
        stream.codec_context.thread_count = 1
        shown = _shown(stream)
        for packet in _with_end(container, stream):
            try:
                decoded = stream.codec_context.decode(packet)
            except av.error.FFmpegError:
                continue  # the frame is a gap
            for frame in decoded:
                yield frame.pts, None if frame.is_corrupt else shown(frame)


def _with_end(container: "av.container.InputContainer", stream: "VideoStream") -> "Iterator[Packet | None]":
    """The packets, then the flush that empties the decoder."""
    yield from _packets(container, stream)
    yield None


def _shown(stream: "VideoStream") -> "Callable[[av.VideoFrame], Image]":
    """A function from a frame to its image as players show it: square pixels, then upright."""
    pixel = _pixel(stream)

    def image(frame: "av.VideoFrame") -> Image:
        shown = frame.to_ndarray(format="rgb24").astype(np.uint8, copy=False)
        if pixel != 1:
            one = Fraction(1)
            width, height = round(frame.width * max(pixel, one)), round(frame.height / min(pixel, one))
            shown = cv2.resize(shown, (width, height), interpolation=cv2.INTER_LINEAR).astype(np.uint8, copy=False)
        turn = TURNS.get(frame.rotation % 360)
        return shown if turn is None else cv2.rotate(shown, turn).astype(np.uint8, copy=False)

    return image


def _reason(error: Exception) -> str:
    return str(getattr(error, "strerror", None) or error).split("\n")[0]
