"""What a user is told about a name that does not exist."""

from vpf_sim.errors import unknown_name


def test_the_nearest_name_is_suggested() -> None:
    assert str(unknown_name("driver", "vfp", ["vpf", "pid"])) == "unknown driver 'vfp': did you mean 'vpf'?"


def test_without_a_near_name_all_are_listed() -> None:
    assert str(unknown_name("driver", "qqq", ["vpf", "pid"])) == "unknown driver 'qqq': known: pid, vpf"
