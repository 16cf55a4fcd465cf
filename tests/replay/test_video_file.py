"""Videos as frames with their own times: variable rates, damage, missing ends, phones upside down."""

from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
import recorded_layouts as layouts

from vpf_sim.errors import InputError
from vpf_sim.replay import readers, video_file
from vpf_sim.types import Image

FRAMES = 18


def shade(index: int) -> Image:
    """A frame whose brightness encodes its number, brighter above than below."""
    image = np.full((64, 96, 3), 20 + 12 * index, np.uint8)
    image[32:] //= 2
    return image


def encode(
    target: Any, *streams: list[Image], form: str | None = None, pixel: Fraction | None = None, **options: str
) -> None:
    """Write a video stream for each list of frames, ten a second; `options` are those of x264 and of the container."""
    given = {"movflags": options.pop("movflags")} if "movflags" in options else {}
    with av.open(target, "w", format=form, options=given) as container:
        added = []
        for frames in streams:
            stream = container.add_stream("libx264", rate=10, options={"crf": "10", **options})
            stream.width, stream.height, stream.pix_fmt = frames[0].shape[1], frames[0].shape[0], "yuv420p"
            if pixel is not None:
                stream.codec_context.sample_aspect_ratio = pixel
            added.append(stream)
        for stream, frames in zip(added, streams, strict=True):
            for image in frames:
                container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
            container.mux(stream.encode())


SHADES = [shade(k) for k in range(FRAMES)]


def plain(width: int, height: int, count: int) -> list[Image]:
    """Frames of one colour each, as bright as the upper half of `shade`."""
    return [np.full((height, width, 3), shade(k)[0, 0, 0], np.uint8) for k in range(count)]


@pytest.fixture(scope="module")
def video_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("videos") / "even.mp4"
    layouts.video(path, [shade(k) for k in range(FRAMES)])
    return path


def numbers(video: video_file.Video) -> list[int | None]:
    """Which shade each frame has; None for a gap."""
    frames = list(video.frames())
    assert [frame.index for frame in frames] == list(range(len(video.times_s)))
    return [None if frame.image is None else round((float(frame.image[:16].mean()) - 20.0) / 12.0) for frame in frames]


def test_plain_video_has_its_frames_and_times(video_path: Path) -> None:
    video = video_file.read(video_path)
    assert (video.width_px, video.height_px, video.notes) == (96, 64, ())
    assert video.times_s == pytest.approx(np.arange(FRAMES) / 10.0)
    assert numbers(video) == list(range(FRAMES))


def test_frames_keep_their_own_times(tmp_path: Path) -> None:
    """A phone's rate varies and it drops frames."""
    stamps = [0, 33, 67, 100, 300, 340, 353, 400]
    layouts.video(tmp_path / "phone.mp4", [shade(k) for k in range(8)], stamps=stamps)
    video = video_file.read(tmp_path / "phone.mp4")
    assert video.times_s == pytest.approx(np.array(stamps) / 1000.0, abs=1e-3)
    assert numbers(video) == list(range(8))


def test_stream_without_times_uses_recorded_times(tmp_path: Path) -> None:
    path = tmp_path / "video.hevc"
    layouts.video(path, [shade(k) for k in range(8)])
    with pytest.raises(InputError, match=r"video\.hevc: expected a video with times of its frames"):
        video_file.read(path)
    times = 5.0 + 0.05 * np.arange(6)
    video = video_file.read(path, times)
    assert video.times_s == pytest.approx(times - 5.0)
    assert video.notes == ("video.hevc: 8 frames, 6 times; 6 are used",)
    assert numbers(video) == list(range(6))


def test_truncated_video_is_read_to_its_end_with_a_note(tmp_path: Path) -> None:
    """With the index in front, the remaining frames can be read."""
    whole, cut = tmp_path / "whole.mp4", tmp_path / "cut.mp4"
    encode(str(whole), [layouts.picture(k) for k in range(FRAMES)], movflags="+faststart", g="3")
    content = whole.read_bytes()
    cut.write_bytes(content[: int(0.6 * len(content))])
    video = video_file.read(cut)
    frames = list(video.frames())
    assert 5 < len(frames) < FRAMES
    assert any("truncated" in note and f"of {FRAMES} frames are there" in note for note in video.notes)
    assert sum(frame.image is not None for frame in frames) >= len(frames) - 2


def test_damage_in_the_middle_is_a_gap(tmp_path: Path) -> None:
    path = tmp_path / "damaged.mp4"
    layouts.video(path, [layouts.picture(k) for k in range(FRAMES)])
    content = bytearray(path.read_bytes())
    start = content.index(b"mdat") + 4
    first, last = start + int(0.45 * (len(content) - start)), start + int(0.5 * (len(content) - start))
    content[first:last] = bytes(last - first)
    path.write_bytes(bytes(content))
    frames = list(video_file.read(path).frames())
    assert [frame.index for frame in frames] == list(range(FRAMES))
    gaps = [frame for frame in frames if frame.image is None]
    assert 1 <= len(gaps) <= 7  # to the next key frame
    assert gaps[0].fault == f"frame {gaps[0].index} of the video cannot be decoded"
    assert frames[0].image is not None
    assert frames[-1].image is not None


def test_frames_of_another_size_are_gaps(tmp_path: Path) -> None:
    """Two streams in one file, as some recorders write after a change of settings."""
    parts = [tmp_path / "large.hevc", tmp_path / "small.hevc"]
    layouts.video(parts[0], [shade(k) for k in range(8)])
    layouts.video(parts[1], [np.ascontiguousarray(shade(k)[:48, :80]) for k in range(8, 12)])
    path = tmp_path / "joined.hevc"
    path.write_bytes(b"".join(part.read_bytes() for part in parts))
    frames = list(video_file.read(path, 0.1 * np.arange(12)).frames())
    assert [frame.image is None for frame in frames] == [False] * 8 + [True] * 4
    assert frames[8].fault == "frame 8 of the video has 80 x 48 px, unlike the first"


def turned(video_path: Path, matrix: tuple[int, ...], path: Path) -> Path:
    """The video with the upper left of its track's matrix, ISO 14496-12, 8.3.2, in 16.16 fixed point."""
    content = bytearray(video_path.read_bytes())
    place = content.index(b"tkhd") + 44
    for k, value in zip((0, 4, 12, 16), matrix, strict=True):
        content[place + k : place + k + 4] = (value * 0x10000 & 0xFFFFFFFF).to_bytes(4, "big")
    path.write_bytes(bytes(content))
    return path


@pytest.mark.parametrize(
    ("matrix", "size", "brighter"),
    [
        ((0, 1, -1, 0), (64, 96), np.s_[:, -16:]),
        ((0, -1, 1, 0), (64, 96), np.s_[:, :16]),
        ((-1, 0, 0, -1), (96, 64), np.s_[-16:]),
    ],
)
def test_turned_video_is_upright(
    matrix: tuple[int, ...], size: tuple[int, int], brighter: tuple[slice, ...], video_path: Path, tmp_path: Path
) -> None:
    """The standard maps (x, y) to (a x + c y, b x + d y): the stored top becomes a side, or the bottom."""
    video = video_file.read(turned(video_path, matrix, tmp_path / "upright.mp4"))
    assert (video.width_px, video.height_px) == size
    image = next(video.frames()).image
    assert image is not None
    assert image.shape == (*reversed(size), 3)
    assert float(image[brighter].mean()) > float(image.mean()) + 2.0


@pytest.mark.parametrize("still", [(48, 32), (192, 128)])
@pytest.mark.parametrize("first", [True, False])
def test_still_image_stream_is_ignored(still: tuple[int, int], first: bool, tmp_path: Path) -> None:
    """A thumbnail or cover, before or after the video, may be larger than it."""
    streams = [plain(*still, 1), plain(96, 64, 8)]
    encode(str(tmp_path / "drive.mp4"), *(streams if first else streams[::-1]), bf="0")
    video = video_file.read(tmp_path / "drive.mp4")
    assert (video.width_px, video.height_px, video.notes) == (96, 64, ())
    assert numbers(video) == list(range(8))


def test_larger_of_two_streams_is_used_with_a_note(tmp_path: Path) -> None:
    encode(str(tmp_path / "drive.mp4"), plain(48, 32, 8), plain(96, 64, 8), bf="0")
    video = video_file.read(tmp_path / "drive.mp4")
    assert (video.width_px, video.height_px) == (96, 64)
    assert video.notes == ("drive.mp4: 2 video streams; the one of 96 x 64 px is used",)
    assert numbers(video) == list(range(8))


def test_edit_list_hides_frames(tmp_path: Path) -> None:
    """A video trimmed without encoding starts with frames that only its decoder needs."""
    whole, trimmed = tmp_path / "whole.mp4", tmp_path / "trimmed.mp4"
    encode(str(whole), SHADES, bf="0", g="30")
    with av.open(str(whole)) as source, av.open(str(trimmed), "w") as target:
        old = source.streams.video[0]
        new = target.add_stream_from_template(old)
        cut = round(0.5 / float(old.time_base or 0))
        for packet in source.demux(old):
            if packet.dts is not None and packet.pts is not None:
                packet.pts, packet.dts, packet.stream = packet.pts - cut, packet.dts - cut, new
                target.mux(packet)
    video = video_file.read(trimmed)
    assert video.times_s == pytest.approx(np.arange(FRAMES - 5) / 10.0)
    assert video.notes == ()
    assert numbers(video) == list(range(5, FRAMES))
    assert video_file.read(trimmed, rate_hz=20.0).times_s == pytest.approx(np.arange(FRAMES - 5) / 20.0)


@pytest.mark.parametrize(("pixel", "size"), [(Fraction(4, 3), (128, 64)), (Fraction(2, 3), (96, 96))])
def test_non_square_pixels_are_stretched(pixel: Fraction, size: tuple[int, int], tmp_path: Path) -> None:
    """No pixel is lost: the frame gets wider, or higher."""
    path = tmp_path / "drive.mp4"
    images = [shade(k) for k in range(4)]
    for image in images:
        image[:, :48] = 0  # its middle stays the middle
    encode(str(path), images, pixel=pixel)
    video = video_file.read(path)
    assert (video.width_px, video.height_px) == size
    assert f"drive.mp4: its pixels are not square ({pixel.numerator}:{pixel.denominator})" in video.notes[0]
    image = next(video.frames()).image
    assert image is not None
    assert image.shape == (size[1], size[0], 3)
    assert image[: size[1] // 2, : size[0] // 2 - 4].mean() < 3.0
    assert image[: size[1] // 2 - 4, size[0] // 2 + 4 :].mean() > 15.0


class Pipe:
    """A file that cannot seek, like a network stream."""

    def __init__(self) -> None:
        self.content = b""

    def write(self, data: bytes) -> int:
        self.content += bytes(data)
        return len(data)


@pytest.mark.parametrize("ending", ["mkv", "ts"])
def test_video_without_duration_is_read_to_its_end(ending: str, tmp_path: Path) -> None:
    """As in streamed videos, whose length is never written."""
    pipe = Pipe()
    encode(pipe, SHADES, form={"mkv": "matroska", "ts": "mpegts"}[ending], bf="0")
    path = tmp_path / f"video_path.{ending}"
    path.write_bytes(pipe.content)
    video = video_file.read(path)
    assert video.times_s == pytest.approx(np.arange(FRAMES) / 10.0, abs=1e-3)
    assert numbers(video) == list(range(FRAMES))


@pytest.mark.parametrize("ending", ["h264", "264", "hevc"])
def test_bare_stream_error_names_a_working_remedy(ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"drive.{ending}"
    if ending == "hevc":
        layouts.video(path, [shade(k) for k in range(8)])
    else:
        encode(str(path), SHADES[:8], form="h264")
    with pytest.raises(InputError, match=r"set rate_hz in drive\.toml, or convert it: ffmpeg"):
        video_file.read(path)
    video = video_file.read(path, rate_hz=20.0)
    assert video.times_s == pytest.approx(np.arange(8) / 20.0)
    assert numbers(video) == list(range(8))


def test_video_of_any_suffix_is_read_and_other_files_refused(video_path: Path, tmp_path: Path) -> None:
    odd = tmp_path / "clip.dashcam"
    odd.write_bytes(video_path.read_bytes())
    assert len(video_file.read(odd).times_s) == FRAMES
    (tmp_path / "notes.txt").write_text("a text is no video\n" * 20)
    with pytest.raises(InputError, match=r"notes\.txt: expected the folder of a drive, or a video such as \.mp4"):
        readers.read(tmp_path / "notes.txt")


@pytest.mark.parametrize("content", [b"", b"no video at all", None, "unfinished"])
def test_a_file_that_is_no_whole_video_is_one_line(
    content: bytes | str | None, video_path: Path, tmp_path: Path
) -> None:
    """The index of an .mp4 is written last, so an unfinished one lacks it."""
    path, whole = tmp_path / "drive.mp4", video_path.read_bytes()
    if content is not None:
        path.write_bytes(content if isinstance(content, bytes) else whole[: whole.index(b"moov") - 4])
    with pytest.raises(InputError, match=r"^.*drive\.mp4: expected a video, cannot be opened: [^\n]+$"):
        video_file.read(path)
