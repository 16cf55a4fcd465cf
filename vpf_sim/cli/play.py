"""`vpf-sim play`: one episode by keys or gamepad."""

import sys
from contextlib import redirect_stdout
from typing import TYPE_CHECKING, Annotated

import typer

from vpf_sim.cli.drive import SeedOption, VideoOption, print_episode
from vpf_sim.cli.options import (
    DRIVER,
    JsonOption,
    NewOutOption,
    ScenarioArgument,
    WeatherOption,
    prints_on_stderr,
)

if TYPE_CHECKING:
    from vpf_sim.api.drive import Episode
    from vpf_sim.reporting.play_view import Ghost

GhostOption = Annotated[
    str | None, typer.Option("--ghost", help="Driver whose car is shown beside yours; it drives first.", **DRIVER)
]
OverlayOption = Annotated[str, typer.Option("--overlay", help="Driver whose perception the key O shows.", **DRIVER)]


def play(
    scenario: ScenarioArgument,
    weather: WeatherOption = "clear",
    seed: SeedOption = 0,
    ghost: GhostOption = None,
    overlay: OverlayOption = "vpf",
    video: VideoOption = None,
    out: NewOutOption = None,
    json: JsonOption = False,
) -> None:
    """Drive yourself; exit code 1 if you do not arrive.

    Arrows, WASD or a gamepad drive, the first key starts. O shows a driver's perception, G the ghost, P pauses, Esc
    gives up. The episode is stored like that of any driver, under the name keyboard.
    """
    from vpf_sim.api.drive import driven
    from vpf_sim.drivers import KEYBOARD
    from vpf_sim.drivers.keyboard import KeyboardDriver
    from vpf_sim.reporting.play_view import PlayView
    from vpf_sim.window import require_display

    require_display()
    stdout = sys.stdout
    with prints_on_stderr():
        view = PlayView(overlay, None if ghost is None else _driven(scenario, weather, ghost, seed))
        hands = KeyboardDriver(view)
        with (
            driven(
                scenario,
                driver=KEYBOARD,
                weather=weather,
                seed=seed,
                video=video,
                out=True if out is None else out,
                hands=hands,
            ) as episode,
            redirect_stdout(stdout),
        ):
            print_episode(episode, json)
        if len(episode.result.steps):
            hands.close(view.last(_words(episode)))
    raise typer.Exit(0 if episode.status == "success" else 1)


def _driven(scenario: str, weather: str, driver: str, seed: int) -> "Ghost":
    """The ghost, after its drive."""
    from vpf_sim.api.drive import drive
    from vpf_sim.errors import InputError, cause
    from vpf_sim.reporting.play_view import Ghost

    print(f"vpf-sim: {driver} drives first, as the ghost", file=sys.stderr)
    episode = drive(scenario, driver=driver, weather=weather, seed=seed)
    if episode.error:
        raise InputError(f"--ghost: expected a driver that drives, got {cause(episode.error)}")
    print(f"vpf-sim: {driver}: {episode.status} after {episode.result.steps.time_s[-1]:.1f} s", file=sys.stderr)
    return Ghost(driver, episode.result.steps)


def _words(episode: "Episode") -> list[str]:
    """The result for the window."""
    from vpf_sim.cli.output import measured
    from vpf_sim.evaluation.metrics.registry import CLEARANCE, COMPLETION

    record = episode.result.record
    return [
        f"{record.status} after {episode.result.steps.time_s[-1]:.1f} s",
        f"route driven {measured(COMPLETION, record)}",
        f"least clearance {measured(CLEARANCE, record)}",
        "any key ends",
    ]
