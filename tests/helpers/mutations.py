"""Strategies of hypothesis that spoil valid inputs: keys, types, numbers, rows, columns, bytes."""

import copy
import json
from typing import Any

from hypothesis import strategies as st

Rows = list[list[str]]
NUMBERS = st.one_of(
    st.sampled_from([0, -1, 1, 2, 1000, 10**9, -(10**9), 10**30, 0.0, -0.0, 1e-9, 1e300, -1e300]),
    st.floats(width=32),
    st.sampled_from([float("nan"), float("inf"), float("-inf")]),
    st.integers(-10, 400),
)
WORDS = st.one_of(
    st.sampled_from(["", "none", "../x", "/etc/passwd", "a\nb", "C:\\x", "4", "\x7f", "é" * 300]), st.text(max_size=8)
)
VALUES = st.recursive(
    st.one_of(NUMBERS, WORDS, st.booleans()),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(WORDS, inner, max_size=3)),
    max_leaves=6,
)
CELLS = st.one_of(
    st.sampled_from(
        ["", "nan", "inf", "-inf", "1e400", "1,5", "0x10", "1_0", "None", '"', "'", ";", "²", "\x00", "9" * 5000]
    ),
    st.text(max_size=6),
    NUMBERS.map(str),
)
FACTORS = st.sampled_from([0.0, -1.0, 1e-9, 1e-3, 3.6, 57.3, 1e3, 1e9, 1e308])
JUNK = [
    b"\xff\xfe",
    b"\x00",
    b"\xef\xbb\xbf",
    b"\r",
    b"\n\n",
    b'"',
    b",",
    b"=",
    b"[" * 9000,
    b"\xe2\x80\xa8",
    b"\x89PNG\r\n\x1a\n",
]


def toml(table: dict[str, Any]) -> str:
    """The TOML text of a table, its sections in one line each."""
    return "".join(f"{json.dumps(key)} = {_toml(value)}\n" for key, value in table.items()).replace("\x7f", "\\u007f")


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {_toml(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, bool | str):
        return json.dumps(value)
    return "none" if value is None else repr(value)


def csv(rows: Rows) -> str:
    return "".join(",".join(row) + "\n" for row in rows)


@st.composite
def spoiled_table(draw: st.DrawFn, table: dict[str, Any]) -> bytes:
    """A TOML file with some keys lost, renamed or given another value; and sometimes with other bytes."""
    table = copy.deepcopy(table)
    for _ in range(draw(st.integers(0, 3))):
        place = draw(st.sampled_from(_places(table)))
        key = draw(st.sampled_from(sorted(place) if isinstance(place, dict) else range(len(place))))
        kind = draw(st.sampled_from(["drop", "rename", "number", "value"]))
        if kind in ("number", "value"):
            place[key] = draw(NUMBERS if kind == "number" else VALUES)
        else:
            value = place.pop(key)
            if kind == "rename" and isinstance(place, dict):
                place[draw(st.sampled_from([f"{key}x", "", key.upper(), key[1:]]))] = value
        if not _places(table):
            break
    return draw(torn(toml(table).encode()))


def _places(value: Any) -> list[Any]:
    """The tables and lists within a table, those that are not empty."""
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return [*([value] if inner else []), *(place for part in inner for place in _places(part))]


@st.composite
def spoiled_rows(draw: st.DrawFn, rows: Rows) -> bytes:
    """A CSV file with rows, columns and cells that are lost, doubled, moved or changed; and sometimes other bytes."""
    rows = [list(row) for row in rows]
    for _ in range(draw(st.integers(0, 3))):
        if not rows or not all(rows):
            break
        row, column = draw(st.integers(0, len(rows) - 1)), draw(st.integers(0, min(map(len, rows)) - 1))
        kind = draw(
            st.sampled_from(["cell", "cell", "header", "scale", "shift", "drop", "twice", "swap", "narrow", "wide"])
        )
        if kind == "cell":
            rows[row][column] = draw(CELLS)
        elif kind == "header":
            rows[0][column] = draw(st.one_of(WORDS.map(_one_line), st.sampled_from(rows[0])))
        elif kind in ("scale", "shift"):
            factor, offset = (draw(FACTORS), 0.0) if kind == "scale" else (1.0, draw(FACTORS))
            for cells in rows[1:]:
                cells[column] = _changed(cells[column], factor, offset)
        elif kind == "drop":
            del rows[row]
        elif kind == "twice":
            rows.insert(row, list(rows[row]))
        elif kind == "swap":
            rows[row], rows[-1] = rows[-1], rows[row]
        else:
            for cells in rows:
                if kind == "narrow":
                    del cells[column]
                else:
                    cells.insert(column, cells[column])
            if not rows[0]:
                break
    return draw(torn(csv(rows).encode()))


def _one_line(text: str) -> str:
    return " ".join(text.split())


def _changed(cell: str, factor: float, offset: float) -> str:
    try:
        return repr(float(cell) * factor + offset)
    except ValueError:
        return cell


@st.composite
def torn(draw: st.DrawFn, content: bytes) -> bytes:
    """The bytes as they are, or cut off, with a line lost or doubled, or with others among them."""
    kind = draw(st.sampled_from(["whole", "whole", "whole", "cut", "junk", "bytes", "line", "lines", "crlf", "empty"]))
    place = draw(st.integers(0, max(0, len(content) - 1)))
    if kind == "cut":
        return content[:place]
    if kind in ("junk", "bytes"):
        other = draw(st.sampled_from(JUNK) if kind == "junk" else st.binary(max_size=6))
        return content[:place] + other + content[place + draw(st.integers(0, 4)) :]
    if kind in ("line", "lines"):
        lines = content.splitlines(keepends=True) or [b""]
        row = place % len(lines)
        return b"".join(lines[:row] + (lines[row : row + 1] * 2 if kind == "lines" else []) + lines[row + 1 :])
    return {"crlf": content.replace(b"\n", b"\r\n"), "empty": b""}.get(kind, content)
