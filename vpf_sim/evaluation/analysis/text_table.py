"""Tables of numbers as aligned text."""

from collections.abc import Mapping, Sequence

NAME_WIDTH = 22
LEAST_WIDTH = 8  # of a column
GAP = 2


def text_table(rows: Sequence[Mapping[str, float | str]], header: bool = True) -> str:
    """One line per row with three digits per number; the first column is the row's name.

    >>> print(text_table([{"drive": "A", "speed_mps": 5.5512}]))
    drive                   speed_mps
    A                            5.55
    """
    keys = list(rows[0])
    shown = [keys] * header + [[_cell(value) for value in row.values()] for row in rows]
    return "\n".join(_line(keys, cells) for cells in shown)


def _line(keys: Sequence[str], cells: Sequence[str]) -> str:
    numbers = (f"{cell:>{max(len(key), LEAST_WIDTH) + GAP}}" for key, cell in zip(keys[1:], cells[1:], strict=True))
    return f"{cells[0]:<{NAME_WIDTH}}" + "".join(numbers)


def _cell(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.3g}"
