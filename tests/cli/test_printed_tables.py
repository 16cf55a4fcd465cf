"""Tables on a terminal."""

import pytest

from vpf_sim.cli.output import print_table


def test_a_row_is_one_line_for_any_name(capsys: pytest.CaptureFixture[str]) -> None:
    print_table(("drive", "frames"), [("a\nb\x1b[31m", "3"), ("Köln", "5")])
    lines = capsys.readouterr().out.splitlines()
    assert [line.split() for line in lines[2:]] == [["a\\nb\\x1b[31m", "3"], ["Köln", "5"]]
