"""All that `vpf-sim doctor` checks."""

from collections.abc import Callable, Iterator, Mapping

from vpf_sim.evaluation.machine import installation
from vpf_sim.evaluation.machine.installation import BROKEN, Check


def examine() -> Iterator[Check]:
    """Each check as soon as it is done; those that drive come last, for they need all else."""
    yield from _tried(installation.checks())
    try:
        from vpf_sim.evaluation.machine import driving_checks
    except Exception as error:  # a library that is there and does not load
        yield _failed("driving", error)
        return
    yield from _tried(driving_checks.checks())


def _tried(checks: Mapping[str, Callable[[], Check]]) -> Iterator[Check]:
    """A check that raises has failed."""
    for name, check in checks.items():
        try:
            yield check()
        except Exception as error:
            yield _failed(name, error)


def _failed(name: str, error: Exception) -> Check:
    return Check(name, False, f"{type(error).__name__}: {error}".splitlines()[0], BROKEN)
