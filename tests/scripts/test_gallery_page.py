"""The gallery's page shows everything that there is, in small moving pictures, and its script draws one."""

import sys
from pathlib import Path

import numpy as np
from PIL import Image as Picture
from short_scenario import write_short

from vpf_sim import drivers, scenarios
from vpf_sim.envs.camera import weather

sys.path.append(str(Path(__file__).parents[2] / "scripts" / "figures"))
import gallery as draw
import gallery_page as page

MOST_BYTES = 12_000_000
SHOWN = tuple(page.everything())


def frames_of(path: Path) -> list[np.ndarray]:
    """The frames of a moving picture."""
    with Picture.open(path) as moving:
        found = []
        for number in range(getattr(moving, "n_frames", 1)):
            moving.seek(number)
            found.append(np.asarray(moving.convert("RGB")).astype(int))
    return found


def test_the_page_is_that_of_its_drives() -> None:
    assert page.PAGE.read_text("utf-8") == page.text(page.stored(draw.DRIVES))


def test_everything_that_there_is_is_shown() -> None:
    assert {shown.weather for shown in SHOWN} >= set(weather.PRESETS)
    assert {one.name for one in drivers.describe()} <= {name for shown in SHOWN for name in shown.drivers} | {
        *page.NOT_DRIVING
    }
    known = {name: scenarios.load(name) for name in scenarios.names()}
    roads = {one.highway_env.id for one in known.values() if isinstance(one, scenarios.HighwayScenario)}
    ours = {name for name, one in known.items() if not isinstance(one, scenarios.HighwayScenario)}
    shown = {one.scenario for one in SHOWN}
    assert ours <= shown
    assert {road.rpartition("-")[0] for road in roads} == {name.rpartition("-")[0] for name in shown & roads}


def test_the_pictures_are_small_and_move() -> None:
    pictures = sorted(draw.FOLDER.glob("*.webp"))
    assert {path.name for path in pictures} == {shown.file for shown in SHOWN}
    assert sum(path.stat().st_size for path in pictures) < MOST_BYTES
    for path in pictures:
        with Picture.open(path) as moving:
            assert getattr(moving, "n_frames", 1) >= 10, path.name


def test_a_drive_is_drawn_about_its_moment_and_repeats(tmp_path: Path) -> None:
    shown = page.Shown("short", str(write_short(tmp_path)), "clear", ("neutral", "pid"))
    done = draw.draw(shown, tmp_path / "short.webp", draw.Moving())
    assert done.status == "success"
    first, *_, last = frames_of(tmp_path / "short.webp")
    assert first.shape == (draw.CAMERA_PX[1], draw.CAMERA_PX[0] + draw.ABOVE_PX[0], 3)
    assert np.abs(last - first).mean() > 2.0
    again = tmp_path / "again.webp"
    draw.draw(shown, again, draw.Moving())
    assert again.read_bytes() == (tmp_path / "short.webp").read_bytes()
    assert page.command(shown, done).endswith(f"--seed {done.seed} --video short.mp4")
