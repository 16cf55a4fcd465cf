"""A pytest plugin with the fixture `drive`, for tests of your own driver.

    def test_my_driver(drive):
        record = drive("town04", driver="my_package:MyDriver", weather="rain", seed=3)
        assert record["status"] == "success"

pytest loads this file at every start, so imports happen at the first drive.
"""

import sys
from typing import Any, Protocol

import pytest


class Drive(Protocol):
    """The fixture's type, for annotations."""

    def __call__(
        self, scenario: str, *, driver: str = "vpf", weather: str = "clear", seed: int = 0
    ) -> dict[str, Any]: ...


@pytest.fixture
def drive(pytestconfig: pytest.Config) -> Drive:
    """A function that drives one episode and returns its record, as `vpf-sim drive --json` prints it.

    Drivers are also found in the project's root. An unsuccessful episode prints the command that repeats it, and the
    traceback of a driver's exception.
    """

    def run(scenario: str, *, driver: str = "vpf", weather: str = "clear", seed: int = 0) -> dict[str, Any]:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(sys, "path", [*sys.path, str(pytestconfig.rootpath)])
            return _run(scenario, weather, driver, seed)

    return run


def _run(scenario: str, weather: str, driver: str, seed: int) -> dict[str, Any]:
    """Drive one episode on one thread, as the command line does."""
    import cv2

    from vpf_sim.evaluation.episode import episode
    from vpf_sim.evaluation.gate.cells import Cell
    from vpf_sim.evaluation.gate.checks import drive_command
    from vpf_sim.evaluation.processes.threads import limit_opencv

    threads = cv2.getNumThreads()
    limit_opencv()
    try:
        result = episode.run(scenario, weather, driver, seed)
    finally:
        cv2.setNumThreads(threads)
    status = result.record["status"]
    if status != "success":
        lines = [
            result.timing.get("traceback", ""),
            f"{status}; again: {drive_command(Cell(scenario, weather, driver), [seed])}",
        ]
        print("\n".join(lines), file=sys.stderr)
    return result.record
