"""A video as frames with their own times: variable rates, damaged parts and ends that are missing are told."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import av
import cv2
import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.replay.recording import Frame
from vpf_sim.types import Floats, Image

if TYPE_CHECKING:
    from av.packet import Packet as AnyPacket
    from av.video.stream import VideoStream

    Packet = AnyPacket[VideoStream]

SUFFIXES = (".mp4", ".mov", ".mkv", ".avi", ".webm", ".m4v", ".hevc", ".h264", ".ts")
TURNS = {90: cv2.ROTATE_90_COUNTERCLOCKWISE, 180: cv2.ROTATE_180, 270: cv2.ROTATE_90_CLOCKWISE}


@dataclass(frozen=True, slots=True)
class Video:
    """What a video's index says; nothing is decoded but its first frame."""

    path: Path
    width_px: int
    height_px: int
    stamps: tuple[int, ...]  # of the N frames, in the order of the picture, ascending; empty where it has none
    times_s: Floats  # (N,) from the first frame
    notes: tuple[str, ...]

    def frames(self) -> Iterator[Frame]:
        """N frames; those that are damaged or missing are gaps."""
        place = {stamp: index for index, stamp in enumerate(self.stamps)}
        expected = 0
        for stamp, image in _decoded(self.path):
            index = place.get(stamp, expected) if stamp is not None and place else expected
            if index < expected or index >= len(self.times_s):
                continue  # a stamp for the second time, or a frame that the index does not know
            yield from (_gap(missing) for missing in range(expected, index))
            yield self._frame(index, image)
            expected = index + 1
        yield from (_gap(missing) for missing in range(expected, len(self.times_s)))

    def _frame(self, index: int, image: Image | None) -> Frame:
        """A picture of the first one's size; another is a gap."""
        if image is None:
            return _gap(index)
        height, width = image.shape[:2]
        if (width, height) == (self.width_px, self.height_px):
            return Frame(index, image)
        return Frame(index, None, f"frame {index} of the video has {width} x {height} px, unlike the first")


def _gap(index: int) -> Frame:
    return Frame(index, None, f"frame {index} of the video cannot be decoded")


def read(path: Path, times_s: Floats | None = None) -> Video:
    """The video's index. `times_s` (N,) are those recorded beside it, for a stream that has none of its own."""
    try:
        with av.open(str(path)) as container:
            if not container.streams.video:
                raise InputError(f"{path}: expected a video, found no picture in it")
            stream = container.streams.video[0]
            packets = [packet.pts for packet in _packets(container)]
            claimed, base = stream.frames, float(stream.time_base or 0)
    except (av.error.FFmpegError, OSError) as error:
        raise InputError(f"{path}: expected a video, cannot be opened: {_reason(error)}") from None
    first = next((image for _, image in _decoded(path) if image is not None), None)
    if first is None or len(packets) < 2:
        raise InputError(f"{path}: expected a video of two frames or more, found {len(packets)} that decode")
    stamps = tuple(sorted({pts for pts in packets if pts is not None}))
    notes = _notes(path, len(packets), len(stamps), claimed)
    height, width = first.shape[:2]
    if times_s is not None:
        count = min(len(times_s), len(packets))
        if len(times_s) != len(packets):
            notes = (*notes, f"{path.name}: {len(packets)} frames, {len(times_s)} times; {count} are used")
        stamps = stamps[:count] if len(stamps) == len(packets) else ()
        return Video(path, width, height, stamps, times_s[:count] - times_s[0], notes)
    if len(stamps) < 2:
        raise InputError(f"{path}: expected a video that knows when its frames were taken; give their times in a table")
    return Video(path, width, height, stamps, (np.array(stamps, float) - stamps[0]) * base, notes)


def evenly(path: Path, rate_hz: float) -> Floats:
    """(N,) s, the times of a video's frames if they were taken at this rate."""
    try:
        with av.open(str(path)) as container:
            return np.arange(sum(1 for _ in _packets(container))) / rate_hz
    except (av.error.FFmpegError, OSError, IndexError) as error:
        raise InputError(f"{path}: expected a video, cannot be opened: {_reason(error)}") from None


def _notes(path: Path, packets: int, stamps: int, claimed: int) -> tuple[str, ...]:
    notes = []
    if packets < claimed:
        notes.append(f"{path.name}: cut off: {packets} of {claimed} frames are there")
    if 0 < stamps < packets:
        notes.append(f"{path.name}: {packets - stamps} frames with the time of another or none are left out")
    return tuple(notes)


def _packets(container: av.container.InputContainer) -> "Iterator[Packet]":
    """The packets that hold a frame, as far as the file goes."""
    packets = container.demux(container.streams.video[0])
    while True:
        try:
            packet = next(packets)
        except (StopIteration, av.error.FFmpegError):
            return
        if packet.size:
            yield packet


def _decoded(path: Path) -> Iterator[tuple[int | None, Image | None]]:
    """(stamp, (H, W, 3) RGB) in the order of the picture; no image where the decoder says that it is damaged."""
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        stream.codec_context.thread_count = 1
        for packet in _with_end(container):
            try:
                decoded = stream.codec_context.decode(packet)
            except av.error.FFmpegError:
                continue  # the frame is a gap
            for frame in decoded:
                yield frame.pts, None if frame.is_corrupt else _image(frame)


def _with_end(container: av.container.InputContainer) -> "Iterator[Packet | None]":
    """The packets, then what makes the decoder give what it still holds."""
    yield from _packets(container)
    yield None


def _image(frame: av.VideoFrame) -> Image:
    image = frame.to_ndarray(format="rgb24").astype(np.uint8, copy=False)
    turn = TURNS.get(frame.rotation % 360)
    return image if turn is None else cv2.rotate(image, turn).astype(np.uint8, copy=False)


def _reason(error: Exception) -> str:
    return str(getattr(error, "strerror", None) or error).split("\n")[0]
