"""The doctor on simulated broken cameras, versions and machines."""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from vpf_sim import cli
from vpf_sim.envs.camera import Renderer
from vpf_sim.machine import doctor, driving_checks, installation
from vpf_sim.machine.driving_checks import Run
from vpf_sim.machine.installation import Check
from vpf_sim.types import Image

SHAPE = (120, 160, 3)
GOOD = [np.random.default_rng(number).integers(0, 256, SHAPE, np.uint8) for number in range(4)]


@pytest.mark.parametrize(
    ("frames", "found"),
    [
        ([np.zeros_like(GOOD[0])] * 3, "frame 0 is black (3 of 3 frames are wrong)"),
        ([*GOOD, np.full(SHAPE, 90, np.uint8)], "frame 4 is constant (1 of 5 frames are wrong)"),
        ([*GOOD, GOOD[-1]], "frame 4 is stale (1 of 5 frames are wrong)"),
        ([GOOD[0], GOOD[1][1:]], "frame 1 is wrong shape (1 of 2 frames are wrong)"),
    ],
    ids=["black", "constant", "stale", "shape"],
)
def test_a_bad_camera_is_found(frames: list[Image], found: str) -> None:
    check = driving_checks.frames(frames, SHAPE)
    assert (check.ok, check.found, check.remedy) == (False, found, installation.BROKEN)


def test_a_good_camera_passes() -> None:
    assert driving_checks.frames(GOOD, SHAPE).ok


def squares(count: int) -> Image:
    """A grey picture with so many bright squares, four corners each."""
    frame = np.full((480, 640, 3), 60, np.uint8)
    for number in range(count):
        row, column = 20 + 40 * (number // 14), 20 + 44 * (number % 14)
        frame[row : row + 20, column : column + 20] = 200
    return frame


def test_a_frame_needs_corners() -> None:
    assert driving_checks.corners(squares(30)) == Check("corners", True, "120 to track")
    few = driving_checks.corners(squares(5))
    assert (few.ok, few.found) == (False, "20, expected at least 100")
    assert driving_checks.corners(squares(0)).found == "0, expected at least 100"


RUN = Run("timeout", "a" * 64, "b" * 64, 90, 1.5)


def test_speed_is_reported_and_a_slow_machine_fails() -> None:
    assert driving_checks.speed(RUN) == Check("speed", True, "60 steps a second in hard rain; the camera takes 60")
    assert not driving_checks.speed(replace(RUN, wall_s=60.0)).ok


def test_the_same_run_is_the_same_however_long_it_took() -> None:
    check = driving_checks.same("same again", RUN, replace(RUN, wall_s=9.0))
    assert (check.ok, check.found) == (True, "90 steps, states aaaaaaaaaaaa, frames bbbbbbbbbbbb")


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"frames_sha256": "c"}, "frames of the short episode differ"),
        ({"states_sha256": "c", "frames_sha256": "d"}, "states and frames of the short episode differ"),
        ({"status": "collision"}, "status of the short episode differ"),
        ({"status": "error"}, "the short episode ended by error"),
        ({"status": "invalid_frame"}, "the short episode ended by invalid_frame"),
    ],
)
def test_a_different_outcome_fails(change: dict[str, str], found: str) -> None:
    other = replace(RUN, **change)  # type: ignore[arg-type]
    for first, again in ((RUN, other), (other, RUN)):
        check = driving_checks.same("same again", first, again)
        assert (check.ok, check.found) == (False, found)
        assert check.remedy


def test_versions_are_compared_with_the_required_ones() -> None:
    requested = installation.lower_bounds()
    assert requested.keys() >= {"numpy", "highway-env", "pygame-ce", "gymnasium"}
    assert "pytest" not in requested, "extras are not required"
    assert installation.versions(requested).ok
    bad = installation.versions({"numpy": "999.1", "no-such-package": "1.0"})
    assert not bad.ok
    assert bad.found == (
        f"numpy {np.__version__}, expected 999.1 or later; no-such-package is missing, expected 1.0 or later"
    )


@pytest.mark.parametrize(
    ("is_ce", "distributions", "found"),
    [
        (False, ["pygame"], "expected pygame-ce alone, got pygame"),
        (True, ["pygame", "pygame-ce"], "expected pygame-ce alone, got pygame over pygame-ce"),
        (False, ["pygame-ce", "pygame"], "expected pygame-ce alone, got pygame over pygame-ce"),
    ],
)
def test_the_other_pygame_is_found(is_ce: bool, distributions: list[str], found: str) -> None:
    check = installation.pygame_in_use(is_ce, distributions)
    assert (check.ok, check.found) == (False, found)
    assert "pip install pygame-ce" in check.remedy
    assert installation.pygame_in_use(True, ["pygame-ce"]).ok


def test_the_dummy_video_driver_is_found() -> None:
    assert not installation.sdl({"SDL_VIDEODRIVER": "dummy"}).ok
    assert installation.sdl({"SDL_VIDEODRIVER": "offscreen"}) == Check("SDL", True, "SDL_VIDEODRIVER=offscreen")
    assert installation.sdl({}).ok


def test_no_display_is_ok_and_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "offscreen")
    check = installation.display()
    assert check.ok
    assert check.found.startswith("none: --watch")


def test_a_display_that_cannot_be_opened_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "nonsense")
    check = installation.display()
    assert not check.ok
    assert check.found.startswith("SDL cannot open it: nonsense not available")
    assert check.remedy == "unset SDL_VIDEODRIVER, or correct DISPLAY"


class Black(Renderer):
    def render(self, ego: Any, time_s: float) -> Image:
        return np.zeros_like(super().render(ego, time_s))


class Frozen(Renderer):
    """It shows its first frame for ever."""

    first: Image | None = None

    def render(self, ego: Any, time_s: float) -> Image:
        self.first = super().render(ego, time_s) if self.first is None else self.first
        return self.first.copy()


class Restless(Renderer):
    """It takes its random numbers from outside."""

    def render(self, ego: Any, time_s: float) -> Image:
        frame = super().render(ego, time_s)
        frame[:4, :4] = np.random.default_rng().integers(0, 256, (4, 4, 3))
        return frame


def failed(monkeypatch: pytest.MonkeyPatch, camera: type[Renderer]) -> dict[str, str]:
    """What the doctor says is wrong with a camera, with the fresh process played by this one."""
    monkeypatch.setattr("vpf_sim.envs.camera.Renderer", camera)
    monkeypatch.setattr(driving_checks, "EPISODE_S", 0.2)
    monkeypatch.setattr(driving_checks, "in_fresh_process", driving_checks.short_episode)
    done = [check() for check in driving_checks.checks().values()]
    return {check.name: check.found for check in done if not check.ok}


@pytest.mark.parametrize(
    ("camera", "found"),
    [
        (Renderer, {}),
        (Black, {"frames": "frame 0 is black (12 of 12 frames are wrong)", "corners": "0, expected at least 100"}),
        (Frozen, {"frames": "frame 1 is stale (11 of 12 frames are wrong)"}),
        (Restless, {}),
    ],
)
def test_the_installed_camera_is_checked(
    camera: type[Renderer], found: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    said = failed(monkeypatch, camera)
    said.pop("speed", None)
    ends = {Black: "the short episode ended by invalid_frame", Restless: "frames of the short episode differ"}
    ends[Frozen] = ends[Black]
    same = dict.fromkeys(("same again", "same elsewhere"), ends[camera]) if camera in ends else {}
    assert said == {**found, **same}


def test_a_check_that_raises_has_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> Check:
        raise ImportError("libGL.so.1: cannot open shared object file\nand more")

    checks: dict[str, Callable[[], Check]] = {"pygame": broken, "SDL": lambda: installation.sdl({})}
    monkeypatch.setattr(installation, "checks", lambda: checks)
    monkeypatch.setattr(driving_checks, "checks", dict)
    first, second = doctor.examine()
    assert (first.name, first.ok) == ("pygame", False)
    assert first.found == "ImportError: libGL.so.1: cannot open shared object file"
    assert second.ok


@pytest.mark.parametrize(("ok", "code"), [(True, 0), (False, 1)])
def test_the_output_is_one_line_per_check_and_the_exit_code(
    ok: bool, code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    checks = [Check("SDL", True, "fine"), Check("corners", ok, "3", "" if ok else "call us")]
    monkeypatch.setattr(doctor, "examine", lambda: iter(checks))
    assert cli.run(["doctor"]) == code
    last = "ok    corners         3" if ok else "FAIL  corners         3; call us"
    assert capsys.readouterr().out.splitlines() == ["ok    SDL             fine", last]
    assert cli.run(["doctor", "--json"]) == code
    answer = json.loads(capsys.readouterr().out)
    assert answer["ok"] is ok
    assert [check["name"] for check in answer["checks"]] == ["SDL", "corners"]


def test_the_episode_is_the_same_in_a_fresh_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(driving_checks, "EPISODE_S", 1.5)  # what the other process reads
    here, elsewhere = driving_checks.short_episode(3), driving_checks.in_fresh_process(3)
    assert driving_checks.same("same elsewhere", here, elsewhere).ok
    assert here.steps == 90
