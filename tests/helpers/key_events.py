"""A person at the keys: events that are posted to SDL's dummy window, and a clock that does not wait."""

from collections.abc import Callable

import pygame
import pytest

from vpf_sim import window


def key(name: str, down: bool = True) -> pygame.event.Event:
    """A key that goes down, or up."""
    letter = name if len(name) == 1 else name.upper()
    return pygame.event.Event(pygame.KEYDOWN if down else pygame.KEYUP, key=getattr(pygame, f"K_{letter}"))


def axis(number: int, value: int) -> pygame.event.Event:
    """A gamepad's axis that moves."""
    return pygame.event.Event(pygame.CONTROLLERAXISMOTION, axis=number, value=value)


class Person:
    """Acts before each look at the events; `script` has what it does, by the number of the look."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, script: Callable[[int], list[pygame.event.Event]]) -> None:
        self.looks = 0
        poll = window.Inputs.poll

        def look(inputs: window.Inputs) -> list[str]:
            for event in script(self.looks):
                pygame.event.post(event)
            self.looks += 1
            return poll(inputs)

        monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
        monkeypatch.setattr(window, "INVISIBLE_DRIVERS", frozenset())
        monkeypatch.setattr(window.Inputs, "poll", look)
        monkeypatch.setattr(window, "sleep", lambda _: None)
        monkeypatch.setattr(window, "perf_counter", lambda: 0.0)  # the machine is never late
