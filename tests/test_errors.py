"""What a user is told about a name that does not exist, and a value that is wrong."""

from vpf_sim.errors import unknown_name, wrong_value


def test_the_nearest_name_is_suggested() -> None:
    assert str(unknown_name("driver", "vfp", ["vpf", "pid"])) == "unknown driver 'vfp': did you mean 'vpf'?"


def test_without_a_near_name_all_are_listed() -> None:
    assert str(unknown_name("driver", "qqq", ["vpf", "pid"])) == "unknown driver 'qqq': known: pid, vpf"


def test_a_wrong_value_is_told_in_our_words() -> None:
    assert wrong_value("Input should be a valid number", "far") == "expected a valid number, got 'far'"
    assert wrong_value("List should have at least 1 item", []) == "expected: List should have at least 1 item, got []"


def test_a_long_value_is_cut() -> None:
    told = wrong_value("Input should be a valid number", "x" * 1000)
    assert told.endswith("xxx...")
    assert len(told) < 100
