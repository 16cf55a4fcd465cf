"""The command line `vpf-sim`; a command imports what it needs when it runs."""

import os
import sys
from collections.abc import Callable, Sequence
from typing import Annotated, Any

import typer

from vpf_sim import __version__, system
from vpf_sim.cli import (
    check,
    drive,
    drivers,
    export,
    machine,
    output,
    perception,
    play,
    replay,
    runs,
    scenarios,
    sweep,
    verify,
    video,
    weathers,
)
from vpf_sim.cli.options import Command
from vpf_sim.errors import InputError, on_command_line

SIMULATING = (
    "drive",
    "play",
    "sweep",
    "benchmark",
    "reproduce",
    "replay",
    "gallery",
    "doctor",
    "video",
    "export",
    "report",
    "perception",
    "verify",
)
STOPPED = 130  # exit code after Ctrl-C
STORES_AT_END = {"drive", "play"}
TELL_HOW_TO_GO_ON = {"sweep", "benchmark", "reproduce", "replay"}  # where they are stopped
UsageError: type[Exception] = typer.BadParameter.__bases__[0]  # click's; its module depends on typer's release

app = typer.Typer(
    name="vpf-sim",
    help="Drive a car by one camera, in closed loop; sweep, score and compare drivers.",
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _print_version(requested: bool) -> None:
    if requested:
        print(f"vpf-sim {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", help="Show the version and exit.", callback=_print_version, is_eager=True)
    ] = False,
) -> None:
    """The options of the program itself, beside those of its commands."""


COMMANDS: tuple[Callable[..., None], ...] = (
    drive.drive,
    play.play,
    sweep.sweep,
    sweep.benchmark,
    replay.replay,
    runs.score,
    runs.report,
    runs.results,
    sweep.reproduce,
    video.video,
    export.export,
    check.check,
    verify.verify,
    perception.perception,
    machine.doctor,
)
for one in COMMANDS:
    app.command(one.__name__, cls=Command)(one)
app.add_typer(scenarios.app, name="scenarios")
app.add_typer(weathers.app, name="weathers")
app.add_typer(drivers.app, name="drivers")


def main() -> None:
    """Entry point of the console script and of `python -m vpf_sim.cli`."""
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    arguments = sys.argv[1:]
    if not set(arguments[:2]).isdisjoint(SIMULATING) and not {"-h", "--help"} & set(arguments):
        _limit_threads(arguments)
    sys.path.append(os.getcwd())  # for a user's own drivers
    output.reserve_stdout()
    code = run(arguments)
    try:
        sys.stdout.flush()
    except OSError as error:
        code = _refuse(f"standard output: {error.strerror}")
    sys.exit(code)


def run(arguments: Sequence[str]) -> int:
    """Run one command and return its exit code; errors of the user print one line each and return 2."""
    for argument in arguments:
        if not argument.isascii() and argument != argument.encode("utf-8", "replace").decode():
            return _refuse(f"expected names in UTF-8, got {argument!a}; rename the file or folder")
    try:
        with on_command_line():
            code = app(list(arguments), prog_name="vpf-sim", standalone_mode=False)
    except InputError as error:
        return _refuse(str(error))
    except OSError as error:
        return _refuse(f"{error.filename}: {error.strerror}" if error.filename else str(error))
    except (KeyboardInterrupt, typer.Abort):
        code = STOPPED  # typer's own answer, in some of its releases
    except UsageError as error:
        return _usage(error)
    if code == STOPPED and not set(arguments[:1]) & TELL_HOW_TO_GO_ON:
        how = "stopped" if arguments[0] == "play" else "stopped by Ctrl-C"
        _refuse(f"{how}{'; the drive is not stored' if arguments[0] in STORES_AT_END else ''}")
    return code if isinstance(code, int) else 0


def _usage(error: Any) -> int:
    """Print a wrong option or command in one line; a missing command prints the help."""
    if error.message == error.ctx.get_help():
        print(error.message)
        return 2
    return _refuse(error.format_message())


def _refuse(message: str) -> int:
    for line in message.splitlines():
        print(f"vpf-sim: {line}", file=sys.stderr)
    return 2


def _limit_threads(arguments: Sequence[str]) -> None:
    """Restart with one thread per numeric library, since they read their limits when numpy is imported."""
    if not system.are_limited():
        own = [sys.executable, "-P", "-m", "vpf_sim.cli"]  # -P: the working directory comes last in sys.path
        system.replace_process([*own, *arguments], {**os.environ, **system.LIMITS})
