"""Checks of the installation for `vpf-sim doctor`."""

import os
import platform
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, packages_distributions, requires, version

from vpf_sim.errors import InputError
from vpf_sim.evaluation.sweeps.fingerprint import digest, fingerprint

BROKEN = "vpf_sim is broken here; run its tests (make test), and report what fails"


@dataclass(frozen=True, slots=True)
class Check:
    """One line of the doctor's output; `remedy` says what to do if it is not ok."""

    name: str
    ok: bool
    found: str
    remedy: str = ""


def checks() -> dict[str, Callable[[], Check]]:
    """The checks by name."""
    return {
        "versions": lambda: versions(lower_bounds()),
        "fingerprint": fingerprint_in_use,
        "pygame": installed_pygame,
        "SDL": lambda: sdl(os.environ),
        "display": display,
    }


def lower_bounds() -> dict[str, str]:
    """The required packages with their lowest versions."""
    requested = [re.fullmatch(r"([\w.-]+)>=([\d.]+)", one) for one in requires("vpf_sim") or []]  # extras do not match
    return {match[1]: match[2] for match in requested if match}


def versions(lowest: Mapping[str, str]) -> Check:
    """Whether each package of `lowest` is installed in that version or a later one."""
    found = {name: _version(name) for name in lowest}
    wrong = [
        f"{name} {found[name] or 'is missing'}, expected {least} or later"
        for name, least in lowest.items()
        if not _is_at_least(found[name], least)
    ]
    if wrong:
        return Check("versions", False, "; ".join(wrong), "install vpf_sim again, in an environment of its own")
    ours = f"vpf_sim {_version('vpf_sim')}, Python {platform.python_version()}"
    return Check("versions", True, ", ".join([ours, *(f"{name} {found[name]}" for name in lowest)]))


def fingerprint_in_use() -> Check:
    """The fingerprint of code and machine."""
    found = fingerprint()
    features = found["opencv_cpu_features"]
    return Check("fingerprint", True, f"{digest(found)} (source {found['source'][:12]}, OpenCV on {features})")


def pygame_in_use(is_ce: bool, distributions: Collection[str]) -> Check:
    """Whether pygame-ce is installed alone: the distribution pygame overwrites its files."""
    if is_ce and "pygame" not in distributions:
        return Check("pygame", True, f"pygame-ce {_version('pygame-ce')}")
    found = "pygame over pygame-ce" if "pygame-ce" in distributions else "pygame"
    remedy = "pip uninstall pygame pygame-ce, then pip install pygame-ce"
    return Check("pygame", False, f"expected pygame-ce alone, got {found}", remedy)


def installed_pygame() -> Check:
    """`pygame_in_use` for this environment."""
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    import pygame

    return pygame_in_use(bool(getattr(pygame, "IS_CE", False)), packages_distributions().get("pygame", []))


def sdl(environment: Mapping[str, str]) -> Check:
    """Whether SDL_VIDEODRIVER keeps highway-env's own windows and images from being black.

    The camera of vpf_sim does not use SDL.
    """
    driver = environment.get("SDL_VIDEODRIVER")
    if driver == "dummy":
        found = "SDL_VIDEODRIVER=dummy: highway-env's own rgb_array images are silently black"
        return Check("SDL", False, found, "unset SDL_VIDEODRIVER, or use offscreen")
    return Check("SDL", True, "SDL_VIDEODRIVER is not set" if driver is None else f"SDL_VIDEODRIVER={driver}")


def display() -> Check:
    """Whether a window can be opened; no display is ok, since only windows need one."""
    import pygame

    from vpf_sim.window import require_display

    try:
        require_display()
        pygame.display.init()
        pygame.display.quit()
    except InputError:
        return Check(
            "display",
            True,
            'none: --watch is refused, render_mode "human" has no visible window, nothing else needs one',
        )
    except pygame.error as error:
        return Check("display", False, f"SDL cannot open it: {error}", "unset SDL_VIDEODRIVER, or correct DISPLAY")
    return Check("display", True, "there is one")


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _is_at_least(found: str | None, least: str) -> bool:
    if found is None:
        return False
    wanted = [int(part) for part in least.split(".")]
    return [int(part) for part in re.findall(r"\d+", found)][: len(wanted)] >= wanted
