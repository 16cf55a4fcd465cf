"""All checks of `vpf-sim doctor`."""

from collections.abc import Callable, Iterator, Mapping

from vpf_sim.machine import installation
from vpf_sim.machine.installation import BROKEN, Check


def examine() -> Iterator[Check]:
    """Yield each check when it is done; driving checks come last, since they depend on the others."""
    yield from _run(installation.checks())
    try:
        from vpf_sim.machine import driving_checks
    except Exception as error:  # an installed library that cannot be imported
        yield _failed("driving", error)
        return
    yield from _run(driving_checks.checks())


def _run(checks: Mapping[str, Callable[[], Check]]) -> Iterator[Check]:
    """Run checks; a check that raises has failed."""
    for name, check in checks.items():
        try:
            yield check()
        except Exception as error:
            yield _failed(name, error)


def _failed(name: str, error: Exception) -> Check:
    return Check(name, False, f"{type(error).__name__}: {error}".splitlines()[0], BROKEN)
