"""Videos are readable, at true speed, in a format that browsers play."""

from pathlib import Path

import av
import numpy as np
import pytest

from vpf_sim.errors import InputError
from vpf_sim.reporting.video import Writer


def test_frames_come_back_in_order_and_at_their_speed(tmp_path: Path) -> None:
    path = tmp_path / "new" / "drive.mp4"
    with Writer(path, (64, 48), 60.0) as video:
        for level in range(0, 240, 20):
            video.write(np.full((48, 64, 3), level, np.uint8))
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert (stream.codec_context.name, stream.codec_context.pix_fmt) == ("h264", "yuv420p")
        assert stream.average_rate == 60
        frames = list(container.decode(video=0))
    assert [float(frame.time) for frame in frames] == pytest.approx([i / 60.0 for i in range(12)], abs=1e-3)
    levels = [float(frame.to_ndarray(format="rgb24").mean()) for frame in frames]
    assert levels == pytest.approx(range(0, 240, 20), abs=6.0)


def test_the_index_comes_first_so_that_a_browser_can_start(tmp_path: Path) -> None:
    path = tmp_path / "drive.mp4"
    with Writer(path, (64, 48), 9.97) as video:
        for _ in range(3):
            video.write(np.zeros((48, 64, 3), np.uint8))
    content = path.read_bytes()
    assert content.index(b"moov") < content.index(b"mdat")


def test_odd_sides_lose_one_row_and_column(tmp_path: Path) -> None:
    path = tmp_path / "drive.mp4"
    with Writer(path, (65, 49), 10.0) as video:
        video.write(np.zeros((49, 65, 3), np.uint8))
    with av.open(str(path)) as container:
        assert (container.streams.video[0].width, container.streams.video[0].height) == (64, 48)


def test_an_unwritable_path_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "folder.mp4").mkdir()
    for path in (tmp_path / "folder.mp4", tmp_path / "file" / "drive.mp4"):
        with pytest.raises(InputError) as caught:
            Writer(path, (64, 48), 10.0)
        assert str(caught.value).startswith(f"video '{path}': expected a file that can be written, got: ")


def test_wrong_frames_and_names_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"expected a file name that ends in \.mp4"):
        Writer(tmp_path / "drive.avi", (64, 48), 10.0)
    with Writer(tmp_path / "drive.mp4", (64, 48), 10.0) as video:
        video.write(np.zeros((48, 64, 3), np.uint8))
        with pytest.raises(ValueError, match=r"expected at least \(48, 64, 3\), got \(40, 64, 3\)"):
            video.write(np.zeros((40, 64, 3), np.uint8))
