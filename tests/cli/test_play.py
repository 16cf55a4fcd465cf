"""`vpf-sim play`, and the driver `keyboard` in drives and sweeps, with posted keys in SDL's dummy window."""

import json
from pathlib import Path

import numpy as np
import pygame
import pytest
from key_events import Person, key
from short_scenario import SHORT, write_short

import vpf_sim
from vpf_sim import cli
from vpf_sim.drivers.keyboard import KeyboardDriver
from vpf_sim.reporting import overlay, play_view
from vpf_sim.types import Image

REFUSED = "vpf-sim: no display: expected one that a window can be seen on, got SDL's driver 'dummy'\n"


@pytest.fixture
def scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    return str(write_short(tmp_path))


def coast(look: int) -> list[pygame.event.Event]:
    """The first key, and one after the end; the car rolls to the goal."""
    return [key("q")] if look == 0 or look > 60 else []


@pytest.mark.parametrize("command", ["play", "drive", "sweep"])
def test_without_a_display_one_line_and_nothing_written(
    command: str, scenario: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    driver = [] if command == "play" else ["--driver", "keyboard"]
    what = ["--scenario", scenario] if command == "sweep" else [scenario]
    assert cli.run([command, *what, *driver, "--out", str(tmp_path / "run")]) == 2
    assert capsys.readouterr().err == REFUSED
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("option", [["--workers", "2"], ["--timeout", "9"], ["--cluster", "tcp://127.0.0.1:1"]])
def test_a_person_has_no_workers(option: list[str], scenario: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["sweep", "--scenario", scenario, "--driver", "pid", "--driver", "keyboard", *option]) == 2
    expected = f"vpf-sim: {option[0]}: driver 'keyboard': a person drives one car, in this process\n"
    assert capsys.readouterr().err == expected


def test_a_played_episode_is_a_run_like_any(
    scenario: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    Person(monkeypatch, coast)
    assert cli.run(["play", scenario, "--weather", "rain", "--seed", "2", "--out", "run", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert (record["driver"], record["status"], record["id"]) == ("keyboard", "success", record["id"])
    run = vpf_sim.Run("run")
    table = run.steps(run.records["id"][0])
    assert (table["throttle"].dropna() == 0.0).all()
    assert table["time_s"].diff().dropna().to_numpy() == pytest.approx(1.0 / 60.0)

    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    monkeypatch.setattr(KeyboardDriver, "reset", lambda *_: pytest.fail("it is not driven again"))
    assert cli.run(["results", "run"]) == 0
    assert "| keyboard |" in capsys.readouterr().out
    assert cli.run(["video", "run", "--id", record["id"]]) == 0
    assert capsys.readouterr().err.count("vpf-sim") == 0
    assert cli.run(["export", "run", "--format", "lerobot", "--out", "set"]) == 0


def test_overlay_and_ghost_are_drawn_on_their_keys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The player brakes, so that the ghost is ahead; it is lilac, the road's edges of the overlay are cyan."""
    pictures: list[Image] = []
    presses = {0: "s", 100: "g", 104: "g", 108: "o", 122: "o", 126: "escape"}

    def script(look: int) -> list[pygame.event.Event]:
        shown = pygame.surfarray.array3d(pygame.display.get_surface()) if look > 90 else np.zeros((0, 0, 3))
        pictures.append(shown.swapaxes(0, 1).astype(int))
        return [key(presses[look])] if look in presses else []

    Person(monkeypatch, script)
    scenario = tmp_path / "road.toml"
    scenario.write_text(SHORT.replace("s_m = 11.0", "s_m = 30.0"))
    assert cli.run(["play", str(scenario), "--ghost", "pid"]) == 130
    lilac = [int(((one[..., 0] - one[..., 1] > 8) & (one[..., 2] - one[..., 1] > 25)).sum()) for one in pictures]
    assert max(lilac[101:105]) < 100 < 2000 < min([*lilac[95:101], *lilac[105:109]])
    edges = [int((np.abs(one - overlay.EDGE).max(axis=2) < 30).sum()) if one.size else 0 for one in pictures]
    assert max([*edges[:109], *edges[123:]]) < 50 < 200 < min(edges[115:123])


def test_escape_stores_nothing(
    scenario: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    Person(monkeypatch, lambda look: [key("escape")] if look == 7 else coast(look))
    assert cli.run(["play", scenario, "--out", str(tmp_path / "run")]) == 130
    assert capsys.readouterr().err == "vpf-sim: stopped; the drive is not stored\n"
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("option", "driver", "message"),
    [
        ("--ghost", "nobody", "unknown driver 'nobody'"),
        ("--overlay", "expert", "--overlay: expected a driver that sees by camera, got 'expert'"),
    ],
)
def test_other_drivers_that_cannot_help_are_refused(
    option: str,
    driver: str,
    message: str,
    scenario: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    Person(monkeypatch, coast)
    assert cli.run(["play", scenario, option, driver]) == 2
    assert message in capsys.readouterr().err


def test_a_sweep_drives_by_hand_beside_others(scenario: str, monkeypatch: pytest.MonkeyPatch) -> None:
    starts = []
    reset = KeyboardDriver.reset
    monkeypatch.setattr(KeyboardDriver, "reset", lambda self, setup: (starts.append(setup.seed), reset(self, setup)))
    Person(monkeypatch, lambda _: [key("q")])
    words = ["sweep", "--scenario", scenario, "--driver", "pid", "--driver", "keyboard", "--seeds", "0:2"]
    assert cli.run([*words, "--out", "run"]) == 0
    assert starts == [0, 1]
    assert not pygame.display.get_init()
    assert sorted(vpf_sim.Run("run").records["driver"]) == ["keyboard", "keyboard", "pid", "pid"]


def test_the_ghost_is_where_its_drive_was(scenario: str) -> None:
    """Beside a car that turned by 90 deg to the right, what was ahead is at its left."""
    episode = vpf_sim.drive(scenario, driver="pid")
    ghost = play_view.Ghost("pid", episode.result.steps)
    row = episode.steps.iloc[20]
    seen = vpf_sim.Observation(
        np.zeros((0, 0, 3), np.uint8), row.time_s, row.x_m - 10.0, row.y_m, np.pi / 2, 5.0, 0.0, (0.0, 0.0)
    )
    outline = ghost.from_ego(seen)
    assert outline is not None
    assert (outline.x_m, outline.y_m) == pytest.approx((0.0, -10.0), abs=1e-9)
    assert outline.heading_rad == pytest.approx(row.yaw_rad - np.pi / 2)
    late = vpf_sim.Observation(seen.image, 1e3, 0.0, 0.0, 0.0, 5.0, 0.0, (0.0, 0.0))
    assert ghost.from_ego(late) is None
