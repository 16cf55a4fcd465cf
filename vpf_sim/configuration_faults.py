"""Lines of text for what pydantic finds wrong with a table: `section.key: expected X, got Y`."""

import re
from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from typing import Any

from vpf_sim.configuration_fields import keys, sections
from vpf_sim.errors import shown, wrong_value

LARGEST = 1e15  # no quantity in SI units is larger
QUOTES = "'\""
UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")
EXPECTED = {  # by pydantic's name of the fault, filled from its context
    "int_type": "an integer",
    "int_from_float": "an integer",
    "float_type": "a number",
    "finite_number": f"a number up to {LARGEST:g}",
    "string_type": "a string",
    "bool_type": "true or false",
    "tuple_type": "a list",
    "list_type": "a list",
    "dict_type": "a table",
    "dataclass_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "greater_than": "> {gt}",
    "greater_than_equal": ">= {ge}",
    "less_than": "< {lt}",
    "less_than_equal": "<= {le}",
    "too_short": "at least {min_length}",
    "too_long": "at most {max_length} values",
}
Fault = Mapping[str, Any]
Location = tuple[int | str, ...]


def lines(config: type, faults: Sequence[Any], also: Sequence[str] = ()) -> list[str]:
    """A line for each fault that pydantic found in a table of `config`, except for those that follow from others.

    A key is not missing if it is misspelt, and a list not too short if one of its parts is wrong.
    """
    misspelt = set()
    for fault in faults:
        if fault["type"] in UNKNOWN:
            key, known = _place(config, fault["loc"], also)
            misspelt |= {
                f"{key.rpartition('.')[0]}.{near}".removeprefix(".") for near in _near(fault["loc"][-1], known)
            }
    inner = {fault["loc"][:i] for fault in faults for i in range(len(fault["loc"]))}
    return [
        line
        for fault in faults
        for line in _lines(config, fault, also)
        if not (fault["type"] == "missing" and _place(config, fault["loc"], also)[0] in misspelt)
        and not (fault["type"] == "too_short" and fault["loc"] in inner)
    ]


def too_large(table: Any, key: str = "") -> Iterator[str]:
    """A line for each number of a table that is beyond `LARGEST`."""
    if isinstance(table, Mapping):
        for name, value in table.items():
            yield from too_large(value, f"{key}.{name}".removeprefix("."))
    elif isinstance(table, list | tuple):
        for i, value in enumerate(table):
            yield from too_large(value, f"{key}[{i}]")
    elif isinstance(table, int | float) and not abs(table) <= LARGEST:
        yield f"{key}: expected a number up to {LARGEST:g}, got {shown(table)}"


def _lines(config: type, fault: Fault, also: Sequence[str]) -> list[str]:
    key, known = _place(config, fault["loc"], also)
    prefix = f"{key}: " if key else ""
    if fault["type"] == "value_error":
        inner = [
            re.sub(r"^(?=\w+: )", f"{key}." if key else "", line) for line in str(fault["ctx"]["error"]).split("\n")
        ]
        return [line if line.startswith(f"{key}.") else f"{prefix}{line}" for line in inner]
    if fault["type"] in UNKNOWN:
        remedy = _remedy(fault["loc"][-1], known) or f"known: {', '.join(known)}"
        return [f"{prefix}unknown key, {remedy}"]
    if fault["type"].startswith("union_tag"):
        prefix = f"{key}.{fault['ctx']['discriminator'][1:-1]}: "
    return [prefix + _expected(fault)]


def _expected(fault: Fault) -> str:
    """`expected X, got Y`, with the nearest choice."""
    kind, context, got = fault["type"], fault.get("ctx", {}), shown(fault["input"])
    if kind in ("literal_error", "union_tag_invalid"):
        choices = re.findall("'([^']+)'", context["expected" if kind == "literal_error" else "expected_tags"])
        value = fault["input"] if kind == "literal_error" else context["tag"]
        remedy = "".join(f": {remedy}" for remedy in [_remedy(value, choices)] if remedy)
        wanted = f"one of {', '.join(choices)}" if choices else context["expected"]
        return f"expected {wanted}, got {shown(value)}{remedy}"
    if kind in ("missing", "union_tag_not_found"):
        return "expected a value, got none"
    if kind in ("too_short", "too_long"):
        got = str(context["actual_length"] or "none")
    bounds = {name: f"{value:g}" if isinstance(value, float) else value for name, value in context.items()}
    if bounds.get("min_length") == 1:
        bounds["min_length"] = "one"
    if kind in EXPECTED:
        return f"expected {EXPECTED[kind].format(**bounds)}, got {got}"
    return wrong_value(fault["msg"], fault["input"])


def _near(name: object, known: Sequence[str]) -> list[str]:
    return get_close_matches(str(name), known, n=1, cutoff=0.5)


def _remedy(name: object, known: Sequence[str]) -> str:
    return "".join(f"did you mean '{near}'?" for near in _near(name, known))


def _place(config: type, location: Location, also: Sequence[str]) -> tuple[str, list[str]]:
    """A key as the file has it, `bodies[1].lane`, and all keys of its section."""
    key, inside, known = "", [config], list(also)
    for i, step in enumerate(location):
        hints = {name: hint for one in inside for name, hint in keys(one).items()}
        known = [*hints, *(also if i == 0 else ())]
        if isinstance(step, int):
            key += f"[{step}]"
        elif step == "[key]" or (inside and step not in known and i < len(location) - 1):
            continue  # pydantic's names for a key of a table and for the kind of a section
        else:
            key += f".{step}" if re.fullmatch(r"[\w-]{1,60}", step) else f'."{repr(step)[1:61].rstrip(QUOTES)}"'
            inside = sections(hints.get(step)) if i < len(location) - 1 else inside
    return key.removeprefix("."), known
