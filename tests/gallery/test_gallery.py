"""The gallery: a self-contained page, and images at the poses of their captions."""

from collections.abc import Callable, Iterator, Sequence
from html.parser import HTMLParser
from itertools import islice
from math import hypot, radians
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import av
import cv2
import numpy as np
import pytest

from vpf_sim import cli
from vpf_sim.envs.camera import weather as weathers
from vpf_sim.errors import InputError
from vpf_sim.gallery import page as gallery
from vpf_sim.gallery.page import Entry, Picture, page
from vpf_sim.gallery.poses import POSES, SUN_HEADING_DEG, Pose, video_drive

VOID = {"meta", "link", "img", "input", "wbr"}


class Reader(HTMLParser):
    """Whether tags are closed in order, and what the page refers to."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.links: list[str] = []
        self.tags: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.links += [value or "" for key, value in attrs if key in ("href", "src", "poster")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def entry(number: int, name: str = "Mine") -> Entry:
    pictures = tuple(Picture(f"place {place}", f"pictures/{number}-{place}.jpg") for place in range(3))
    return Entry(name, ("other",), "wet & cold", (("fog_density", "3", "< 5 km"),), pictures, f"videos/{number}.mp4")


def read(html: str) -> Reader:
    reader = Reader()
    reader.feed(html)
    assert reader.open == []
    return reader


def test_a_page_has_one_row_per_weather_and_one_column_per_pose() -> None:
    reader = read(page([entry(1), entry(2)]))
    assert (reader.tags.count("section"), reader.tags.count("figure"), reader.tags.count("video")) == (2, 6, 2)
    assert "grid-template-columns: repeat(3, " in page([entry(1)])


def test_a_page_refers_only_to_files_beside_it() -> None:
    html = page([entry(1), entry(2)])
    files = {link for link in read(html).links if not link.startswith(("#", "data:"))}
    pictures = {f"pictures/{number}-{place}.jpg" for number in (1, 2) for place in range(3)}
    assert files == {*pictures, "videos/1.mp4", "videos/2.mp4"}
    assert "http" not in html
    assert "url(" not in html
    assert "@import" not in html


def test_names_of_user_files_are_escaped() -> None:
    html = page([entry(1, "<script>alert(1)</script>")])
    assert "<script>alert" not in html
    assert "&lt;script&gt;alert" in html
    assert "wet &amp; cold" in html
    assert "fog_<wbr>density" in html


@pytest.mark.parametrize("pose", POSES, ids=lambda pose: pose.name)
def test_a_pose_has_its_objects_at_their_positions(pose: Pose) -> None:
    drive = pose.drive(2.0, 10.0)
    last = next(islice(drive.shots(weathers.load("clear"), gallery.SEED, 22), 20, None))
    centre = last.renderer._road.network.centre
    s_m, lateral_m = centre.local_at(*last.pose[:2])
    assert (s_m, lateral_m) == pytest.approx((pose.s_m, drive.scenario.road.lane_offset_m(pose.lane)), abs=0.02)
    assert np.cos(last.pose[2] - centre.heading_at(pose.s_m)) > 1.0 - 1e-6
    places = [centre.local_at(*obj.position) for obj in last.renderer.objects]
    for obj in pose.objects:
        wanted = (obj.s_m, drive.scenario.road.lane_offset_m(obj.lane) + obj.lateral_m)
        assert (
            min(hypot(s - wanted[0], lateral - wanted[1]) for s, lateral in places) < 0.5
        )  # in a bend it takes the inside


def test_no_object_blocks_a_pose() -> None:
    for pose in POSES:
        for obj in pose.objects:
            assert obj.lane != pose.lane or obj.s_m - pose.s_m > 10.0


def test_one_pose_faces_the_sun_of_every_preset() -> None:
    assert {preset.sun_azimuth_angle for preset in weathers.PRESETS.values()} == {SUN_HEADING_DEG}
    (pose,) = (pose for pose in POSES if pose.name == "sun")
    *_, last = pose.drive(0.0, 10.0).shots(weathers.load("clear"), 1, 1)
    assert np.cos(last.pose[2] - radians(SUN_HEADING_DEG)) == pytest.approx(1.0, abs=1e-6)


def test_the_videos_drive_passes_the_parked_car_without_touching_it() -> None:
    drive = video_drive(30.0)
    parked = min((obj for obj in drive.scenario.bodies if obj.speed_mps == 0.0), key=lambda obj: obj.s_m)
    lane_m = drive.scenario.road.lane_offset_m(parked.lane)
    for s_m in np.arange(parked.s_m - 5.0, parked.s_m + 5.0, 0.5):
        gap_m = drive.path.offset_m(s_m) - (lane_m + parked.lateral_m) - (1.9 + 2.0) / 2.0
        assert gap_m > 0.3
    assert drive.path.start_m + gallery.VIDEO_S * drive.path.speed_mps > parked.s_m + 5.0


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """One pose, moments of a drive, and no other process."""

    def serial(work: Callable[[Any], Any], tasks: Sequence[Any], workers: int) -> Iterator[Any]:  # noqa: ARG001
        return (SimpleNamespace(task=task, result=work(task)) for task in reversed(tasks))

    monkeypatch.setattr(gallery, "POSES", POSES[:2])
    monkeypatch.setattr(gallery, "LEAD_S", 0.2)
    monkeypatch.setattr(gallery, "VIDEO_S", 0.2)
    monkeypatch.setattr(gallery.pool, "run", serial)


@pytest.mark.usefixtures("small")
def test_a_gallery_folder_is_self_contained(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "gallery"
    mine = tmp_path / "my rain.toml"
    mine.write_text('base = "rain"\n')
    arguments = [
        "weathers",
        "gallery",
        "--out",
        str(out),
        "--weather",
        "clear",
        "--weather",
        str(mine),
        "--weather",
        "ClearNoon",
    ]
    assert cli.run(arguments) == 0
    said = capsys.readouterr()
    assert said.out == f"{out / 'index.html'}\n"
    assert said.err.splitlines() == ["1/2 my rain", "2/2 ClearNoon"], "an alias is no second weather"
    html = (out / "index.html").read_text()
    files = {link for link in read(html).links if not link.startswith(("#", "data:"))}
    assert files == {path.relative_to(out).as_posix() for path in out.rglob("*") if path.suffix in (".jpg", ".mp4")}
    assert html.index("ClearNoon") < html.index("my rain"), "in the order of the options"
    for path in out.glob("pictures/*.jpg"):
        picture = cv2.imread(str(path))
        assert picture is not None
        assert picture.shape == (480, 640, 3)
    for path in out.glob("videos/*.mp4"):
        with av.open(str(path)) as container:
            stream = container.streams.video[0]
            assert (stream.codec_context.name, stream.frames, stream.codec_context.pix_fmt) == ("h264", 6, "yuv420p")


def test_an_image_is_reproducible() -> None:
    pose = POSES[2]
    for name in ("clear", "rain"):
        first, again = (gallery.picture(pose, weathers.load(name)) for _ in range(2))
        assert np.array_equal(first, again)


@pytest.mark.usefixtures("small")
def test_a_gallery_does_not_overwrite_files(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("")
    with pytest.raises(InputError, match="expected a new or empty folder for the gallery"):
        gallery.make(tmp_path, [weathers.load("clear")], 1, print)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


@pytest.mark.usefixtures("small")
def test_a_gallery_that_fails_leaves_nothing_behind(tmp_path: Path) -> None:
    def tell(done: Entry) -> None:
        assert (tmp_path / "out" / done.video).exists()
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        gallery.make(tmp_path / "out", [weathers.load("clear")], 1, tell)
    assert list(tmp_path.iterdir()) == []
