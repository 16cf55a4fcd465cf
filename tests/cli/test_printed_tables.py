"""Tables on a terminal."""

import pytest

from vpf_sim.cli.tables import in_one_line, print_table


def test_a_row_is_a_line_whatever_a_name_holds(capsys: pytest.CaptureFixture[str]) -> None:
    print_table(("drive", "frames"), [("a\nb\x1b[31m", "3"), ("Köln", "5")])
    lines = capsys.readouterr().out.splitlines()
    assert [line.split() for line in lines[2:]] == [["a\\nb\\x1b[31m", "3"], ["Köln", "5"]]


def test_what_can_be_printed_stays() -> None:
    assert in_one_line('say "hi" in Köln') == 'say "hi" in Köln'
