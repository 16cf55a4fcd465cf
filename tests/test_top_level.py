"""The names of `vpf_sim` itself: all are there, none is loaded before it is used."""

import subprocess
import sys

import pytest

import vpf_sim


@pytest.mark.parametrize("name", vpf_sim.__all__)
def test_every_name_is_there_and_documented(name: str) -> None:
    value = getattr(vpf_sim, name)
    assert name in dir(vpf_sim)
    assert name == "__version__" or value.__doc__


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'vpf_sim' has no attribute 'dirve'"):
        vpf_sim.dirve  # noqa: B018


def test_listing_the_names_loads_none_of_them() -> None:
    code = "import sys, vpf_sim; dir(vpf_sim); print([name for name in sys.modules if name.startswith('vpf_sim.')])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_a_function_stays_one_when_packages_are_imported() -> None:
    """A submodule of the same name would take its place."""
    import vpf_sim.cli.runs
    import vpf_sim.reporting.page

    assert all(callable(function) for function in (vpf_sim.drive, vpf_sim.sweep, vpf_sim.report))


def test_the_records_are_those_of_the_drivers_themselves() -> None:
    from vpf_sim import driver_interface

    assert vpf_sim.Driver is driver_interface.Driver
    assert vpf_sim.Observation is driver_interface.Observation


def test_the_interface_of_drivers_is_found_where_it_stood_before() -> None:
    from vpf_sim import driver_interface, types

    assert types.Command is driver_interface.Command
    with pytest.raises(AttributeError, match=r"'vpf_sim\.types' has no attribute 'Comand'"):
        types.Comand  # noqa: B018
