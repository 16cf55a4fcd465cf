"""Videos as frames with their own times: variable rates, damage, missing ends, phones upside down."""

from pathlib import Path

import numpy as np
import pytest
import recorded_layouts as layouts

from vpf_sim.errors import InputError
from vpf_sim.replay import video_file
from vpf_sim.types import Image

FRAMES = 18


def shade(index: int) -> Image:
    """A frame that tells its number by its brightness, brighter above than below."""
    image = np.full((64, 96, 3), 20 + 12 * index, np.uint8)
    image[32:] //= 2
    return image


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("films") / "even.mp4"
    layouts.video(path, [shade(k) for k in range(FRAMES)])
    return path


def numbers(video: video_file.Video) -> list[int | None]:
    """Which shade each frame has; None for a gap."""
    frames = list(video.frames())
    assert [frame.index for frame in frames] == list(range(len(video.times_s)))
    return [None if frame.image is None else round((float(frame.image[:16].mean()) - 20.0) / 12.0) for frame in frames]


def test_a_plain_video_has_its_frames_and_times(film: Path) -> None:
    video = video_file.read(film)
    assert (video.width_px, video.height_px, video.notes) == (96, 64, ())
    assert video.times_s == pytest.approx(np.arange(FRAMES) / 10.0)
    assert numbers(video) == list(range(FRAMES))


def test_frames_keep_the_times_they_were_taken_at(tmp_path: Path) -> None:
    """A phone's rate varies and it drops frames."""
    stamps = [0, 33, 67, 100, 300, 340, 353, 400]
    layouts.video(tmp_path / "phone.mp4", [shade(k) for k in range(8)], stamps=stamps)
    video = video_file.read(tmp_path / "phone.mp4")
    assert video.times_s == pytest.approx(np.array(stamps) / 1000.0, abs=1e-3)
    assert numbers(video) == list(range(8))


def test_a_stream_without_times_takes_those_recorded_beside_it(tmp_path: Path) -> None:
    path = tmp_path / "video.hevc"
    layouts.video(path, [shade(k) for k in range(8)])
    with pytest.raises(InputError, match=r"video\.hevc: expected a video that knows when its frames were taken"):
        video_file.read(path)
    times = 5.0 + 0.05 * np.arange(6)
    video = video_file.read(path, times)
    assert video.times_s == pytest.approx(times - 5.0)
    assert video.notes == ("video.hevc: 8 frames, 6 times; 6 are used",)
    assert numbers(video) == list(range(6))


def test_a_video_that_is_cut_off_goes_as_far_as_it_goes_and_says_so(tmp_path: Path) -> None:
    """With the index in front the rest can be read."""
    whole, cut = tmp_path / "whole.mp4", tmp_path / "cut.mp4"
    import av

    with av.open(str(whole), "w", options={"movflags": "+faststart"}) as container:
        stream = container.add_stream("libx264", rate=10, options={"g": "3", "crf": "10"})
        stream.width, stream.height, stream.pix_fmt = 96, 64, "yuv420p"
        for k in range(FRAMES):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(layouts.picture(k), format="rgb24")))
        container.mux(stream.encode())
    content = whole.read_bytes()
    cut.write_bytes(content[: int(0.6 * len(content))])
    video = video_file.read(cut)
    frames = list(video.frames())
    assert 5 < len(frames) < FRAMES
    assert any("cut off" in note and f"of {FRAMES} frames are there" in note for note in video.notes)
    assert sum(frame.image is not None for frame in frames) >= len(frames) - 2


def test_damage_in_the_middle_is_a_gap_and_the_rest_is_there(tmp_path: Path) -> None:
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
    assert 1 <= len(gaps) <= 7  # to the next frame that is coded on its own
    assert gaps[0].fault == f"frame {gaps[0].index} of the video cannot be decoded"
    assert frames[0].image is not None
    assert frames[-1].image is not None


def test_pictures_of_another_size_are_gaps_that_say_so(tmp_path: Path) -> None:
    """Two streams in one file, as some recorders go on after a change of their settings."""
    parts = [tmp_path / "large.hevc", tmp_path / "small.hevc"]
    layouts.video(parts[0], [shade(k) for k in range(8)])
    layouts.video(parts[1], [np.ascontiguousarray(shade(k)[:48, :80]) for k in range(8, 12)])
    path = tmp_path / "joined.hevc"
    path.write_bytes(b"".join(part.read_bytes() for part in parts))
    frames = list(video_file.read(path, 0.1 * np.arange(12)).frames())
    assert [frame.image is None for frame in frames] == [False] * 8 + [True] * 4
    assert frames[8].fault == "frame 8 of the video has 80 x 48 px, unlike the first"


def test_a_phone_that_was_mounted_upside_down_is_turned(film: Path, tmp_path: Path) -> None:
    content = bytearray(film.read_bytes())
    matrix = content.index(b"tkhd") + 44  # of the track's header, ISO 14496-12, 8.3.2
    for place in (matrix, matrix + 16):
        content[place : place + 4] = (0xFFFF0000).to_bytes(4, "big")
    (tmp_path / "turned.mp4").write_bytes(bytes(content))
    frame = next(video_file.read(tmp_path / "turned.mp4").frames())
    assert frame.image is not None
    assert float(frame.image[:16].mean()) < float(frame.image[-16:].mean())


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "expected a video, cannot be opened"),
        (b"no video at all", "expected a video, cannot be opened"),
        (None, "expected a video, cannot be opened: No such file"),
    ],
)
def test_what_is_no_video_is_one_clear_line(content: bytes | None, sentence: str, tmp_path: Path) -> None:
    path = tmp_path / "drive.mp4"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        video_file.read(path)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_recording_that_was_not_finished_is_one_clear_line(film: Path, tmp_path: Path) -> None:
    """The index of an .mp4 is written last."""
    content = film.read_bytes()
    (tmp_path / "drive.mp4").write_bytes(content[: content.index(b"moov") - 4])
    with pytest.raises(InputError, match=r"drive\.mp4: expected a video, cannot be opened: Invalid data"):
        video_file.read(tmp_path / "drive.mp4")
