"""The live window: shows the frame, and reports a missing display."""

import numpy as np
import pygame
import pytest

from vpf_sim.envs.four_lane import FourLane
from vpf_sim.errors import InputError
from vpf_sim.window import Window, require_display


@pytest.mark.parametrize("driver", ["dummy", "offscreen"])
def test_no_display_is_one_clear_line(driver: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", driver)
    with pytest.raises(InputError) as caught:
        require_display()
    expected = f"no display: expected one that a window can be seen on, got SDL's driver '{driver}'"
    assert str(caught.value) == expected


def test_the_window_shows_the_frame_upright_in_its_colours(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    frame = np.random.default_rng(0).integers(0, 256, (48, 64, 3), dtype=np.uint8)
    window = Window(64, 48, 60.0)
    window.show(frame)
    shown = pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1)
    window.close()
    assert (shown == frame).all()
    assert not pygame.display.get_init()


def test_the_human_mode_draws_every_frame_and_closes_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env = FourLane("straight", render_mode="human")
    env.reset(seed=0)
    observed, *_ = env.step(np.zeros(2, np.float32))
    shown = pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1)
    assert (shown == observed["image"]).all()
    assert env.render() is None
    env.close()
    env.close()
    assert not pygame.display.get_init()
