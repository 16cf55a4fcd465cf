"""A pytest plugin with the fixture `drive`, for tests of your own driver.

    def test_my_driver(drive):
        record = drive("town04", driver="my_package:MyDriver", weather="rain", seed=3)
        assert record["status"] == "success"

pytest loads this file at every start, so imports happen at the first drive.
"""

import sys
from typing import TYPE_CHECKING, Any, Protocol

import pytest

if TYPE_CHECKING:
    from vpf_sim.api.arguments import StrPath
    from vpf_sim.api.drive import Episode
    from vpf_sim.drivers import DriverLike


class Drive(Protocol):
    """The fixture's type, for annotations."""

    def __call__(
        self, scenario: "StrPath", *, driver: "DriverLike" = "vpf", weather: "StrPath" = "clear", seed: int = 0
    ) -> dict[str, Any]: ...


@pytest.fixture(scope="session")
def drive(pytestconfig: pytest.Config) -> Drive:
    """A function that drives one episode, as `vpf_sim.drive` does, and returns its record.

    Fixtures of any scope may use it, so that several tests check one drive. Drivers are also found in the project's
    root. An unsuccessful episode prints the command that repeats it, and the traceback of a driver's exception.
    """

    def run(
        scenario: "StrPath", *, driver: "DriverLike" = "vpf", weather: "StrPath" = "clear", seed: int = 0
    ) -> dict[str, Any]:
        import vpf_sim

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(sys, "path", [*sys.path, str(pytestconfig.rootpath)])
            episode = vpf_sim.drive(scenario, driver=driver, weather=weather, seed=seed)
        if episode.status != "success":
            print(_how_it_ended(episode), file=sys.stderr)
        return episode.record

    return run


def _how_it_ended(episode: "Episode") -> str:
    """The traceback, if there is one, the status, and the command that drives the episode again."""
    from vpf_sim.evaluation.analysis.rows import Cell
    from vpf_sim.evaluation.gate.checks import drive_command

    record = episode.result.record
    again = drive_command(Cell(*record.cell), [record.seed])
    return f"{episode.error}\n{episode.status}; again: {again}"
