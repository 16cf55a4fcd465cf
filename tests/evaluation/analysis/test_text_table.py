"""Tables of numbers as text."""

from vpf_sim.evaluation.analysis.text_table import text_table

ROWS: list[dict[str, str | float]] = [
    {"drive": "A", "speed_of_travel_mps": 5.5512, "n": 3},
    {"drive": "B", "speed_of_travel_mps": float("nan"), "n": "0.5*"},
]


def test_columns_are_aligned_under_their_keys() -> None:
    lines = text_table(ROWS).split("\n")
    assert [line.split() for line in lines] == [
        ["drive", "speed_of_travel_mps", "n"],
        ["A", "5.55", "3"],
        ["B", "nan", "0.5*"],
    ]
    assert len({len(line) for line in lines}) == 1


def test_further_rows_come_without_the_header() -> None:
    assert text_table(ROWS[1:], header=False) == text_table(ROWS).split("\n")[2]
