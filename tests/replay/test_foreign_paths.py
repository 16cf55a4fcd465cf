"""Tables with paths of the recording machine; the images are beside the table."""

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import recorded_layouts as layouts

from vpf_sim.errors import InputError
from vpf_sim.replay import image_files, readers

WRITTEN: dict[str, Callable[[str], str]] = {
    "relative": lambda path: path,
    "dotted": lambda path: f"./{path}",
    "backslashes": lambda path: path.replace("/", "\\"),
    "another system": lambda path: "C:\\Users\\me\\drive\\" + path.replace("/", "\\"),
    "another machine": lambda path: f"/elsewhere/drive/{path}",
    "a share": lambda path: "\\\\server\\drives\\" + path.replace("/", "\\"),
    "a folder beside": lambda path: f"../drive/{path}",
}
STAMPS = [1479424215880976321 + 50_000_000 * k for k in range(6)]


def table(names: list[str], column: str) -> str:
    header = f"index,timestamp,width,height,frame_id,{column},angle,torque,speed,lat,long"
    rows = [
        f"{k},{stamp},96,64,center_camera,{name},0.01,0,8.0,48,11.{k}"
        for k, (stamp, name) in enumerate(zip(STAMPS, names, strict=True))
    ]
    return "\n".join([header, *rows])


@pytest.mark.parametrize("written", WRITTEN)
def test_paths_are_resolved_relative_to_the_table(written: str, tmp_path: Path) -> None:
    paths = [f"center/{stamp}.jpg" for stamp in STAMPS]
    layouts.pictures(tmp_path / "center", [Path(path).name for path in paths])
    found = image_files.resolve_all(tmp_path, [WRITTEN[written](path) for path in paths], [".jpg"])
    assert [file.resolve() for file in found] == [(tmp_path / path).resolve() for path in paths]


def test_image_in_another_folder_is_found_by_unique_name(tmp_path: Path) -> None:
    layouts.pictures(tmp_path / "moved" / "here", ["1.jpg", "2.jpg"])
    layouts.pictures(tmp_path / "copies", ["2.jpg"])
    found = image_files.resolve_all(tmp_path, ["/elsewhere/center/1.jpg", "/elsewhere/center/2.jpg"], [".jpg"])
    assert found == [tmp_path / "moved/here/1.jpg", tmp_path / "center/2.jpg"]


@pytest.mark.parametrize("path", ["", "/", "\\", "..", "../..", "C:", "\x00", "a" * 300, "x/../../../etc/hostname"])
def test_odd_paths_in_a_table_do_not_raise(path: str, tmp_path: Path) -> None:
    image_files.resolve(tmp_path, path)
    assert image_files.resolve_all(tmp_path, [path], [".jpg"])


def test_missing_images_are_reported_and_signals_read(tmp_path: Path) -> None:
    names = [f"/elsewhere/center/{stamp}.jpg" for stamp in STAMPS]
    (tmp_path / "interpolated.csv").write_text(table(names, "filename").replace(",lat,long", ",a,b"))
    recording = readers.read(tmp_path)
    assert f"6 of 6 images are missing, the first is center/{STAMPS[0]}.jpg" in recording.no_images
    assert recording.speed_mps == pytest.approx(np.full(6, 8.0))


def test_images_of_a_general_table_match_by_file_name(tmp_path: Path) -> None:
    names = [f"f{k}.png" for k in range(6)]
    layouts.pictures(tmp_path / "frames", names)
    (tmp_path / "drive.toml").write_text(
        'schema = 1\nframes = "D:\\\\drive\\\\frames"\n[camera]\nheight_m = 1.4\npitch_deg = 0\nyaw_deg = 0\n'
        '[signals]\nfile = "C:\\\\logs\\\\signals.csv"\n'
    )
    rows = [f"C:\\data\\frames\\{name},{0.05 * k:.2f},{8 + k},0.0" for k, name in enumerate(names)]
    text = "\n".join(["file,time_s,speed_mps,yaw_rate_radps", *rows])
    (tmp_path / "signals.csv").write_text(text)
    assert readers.read(tmp_path).speed_mps == pytest.approx(8.0 + np.arange(6))
    (tmp_path / "signals.csv").write_text(text + "\nE:\\other\\f3.png,0.4,1,0.0")
    with pytest.raises(InputError, match=r"expected one row for f3\.png, found lines 5 and 8"):
        readers.read(tmp_path)
    (tmp_path / "signals.csv").write_text(text + "\nC:\\data\\frames\\f6.png,0.3,14,0.0")
    assert "signals.csv: 1 of 7 images are missing, the first is f6.png" in readers.read(tmp_path).notes
    shutil.rmtree(tmp_path / "frames")
    with pytest.raises(InputError, match="expected a video or a folder of images, found no"):
        readers.read(tmp_path)
