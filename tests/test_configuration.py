"""Configuration classes and their reader: every fault is one line with its place."""

import pickle
from dataclasses import FrozenInstanceError, dataclass, replace
from typing import Any, Literal

import pytest

from vpf_sim.configuration import build, setting, settings
from vpf_sim.errors import InputError


@settings
class Inner:
    gain: float = setting("of the loop", ge=0.0)
    least: float = setting("its least", default=0.0)

    def __post_init__(self) -> None:
        if self.gain < self.least:
            raise ValueError(f"gain: expected at least {self.least:g}, got {self.gain:g}")


@dataclass(frozen=True)
class Plain:
    gain: float


@settings
class Outer:
    count: int = setting("of them", gt=0)
    kind: Literal["a", "b"]
    inner: Inner
    pair: tuple[float, float] = (0.0, 1.0)
    level: int | None = setting("none: as many as needed", default=2, ge=0)
    parts: tuple[Inner, ...] = ()
    plain: Plain | None = None


GOOD: dict[str, Any] = {"count": 3, "kind": "b", "inner": {"gain": 1}, "pair": [1, 2.5], "level": "none"}


def test_every_kind_of_value_is_read() -> None:
    table = {**GOOD, "parts": [{"gain": 2, "least": 1.5}], "plain": {"gain": 1}}
    expected = Outer(3, "b", Inner(1.0), (1.0, 2.5), None, (Inner(2.0, 1.5),), Plain(1.0))
    assert build(Outer, table, "f.toml") == expected


def test_an_integer_becomes_the_float_that_a_field_asks_for() -> None:
    assert isinstance(build(Inner, {"gain": 1}, "f.toml").gain, float)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"cuont": 1}, "f.toml: cuont: unknown key, did you mean 'count'?"),
        ({"inner": {"gian": 1}}, "f.toml: inner.gian: unknown key, did you mean 'gain'?"),
        ({"inner": {"gain": 1, "x": 1}}, "f.toml: inner.x: unknown key, known: gain, least"),
        ({"plain": {"gain": 1, "x": 1}}, "f.toml: plain.x: unknown key, known: gain"),
        ({"a\nb": 1}, 'f.toml: "a\\nb": unknown key, known: count, kind, inner, pair, level, parts, plain'),
        ({"count": 1.5}, "f.toml: count: expected an integer, got 1.5"),
        ({"count": True}, "f.toml: count: expected an integer, got True"),
        ({"count": 0}, "f.toml: count: expected > 0, got 0"),
        ({"kind": "c"}, "f.toml: kind: expected one of a, b, got 'c'"),
        ({"kind": "none"}, "f.toml: kind: expected one of a, b, got 'none'"),
        ({"level": "nine"}, "f.toml: level: expected an integer, got 'nine'"),
        ({"inner": 3}, "f.toml: inner: expected a table, got 3"),
        ({"inner": {"gain": "x"}}, "f.toml: inner.gain: expected a number, got 'x'"),
        ({"inner": {"gain": True}}, "f.toml: inner.gain: expected a number, got True"),
        ({"inner": {"gain": -1}}, "f.toml: inner.gain: expected >= 0, got -1"),
        ({"inner": {"gain": 1, "least": 2}}, "f.toml: inner.gain: expected at least 2, got 1"),
        ({"inner": {}}, "f.toml: inner.gain: expected a value, got none"),
        ({"parts": [{"gain": 1}, {"gain": "x"}]}, "f.toml: parts[1].gain: expected a number, got 'x'"),
        ({"plain": {"gain": "x"}}, "f.toml: plain.gain: expected a number, got 'x'"),
        ({"pair": [1]}, "f.toml: pair[1]: expected a value, got none"),
        ({"pair": [1, 2, 3]}, "f.toml: pair: expected at most 2 values, got 3"),
        ({"pair": 3}, "f.toml: pair: expected a list, got 3"),
        ({"pair": [1, float("nan")]}, "f.toml: pair[1]: expected a number up to 1e+15, got nan"),
        ({"pair": [1, 2e15]}, "f.toml: pair[1]: expected a number up to 1e+15, got 2000000000000000.0"),
        ({"count": 10**18}, "f.toml: count: expected a number up to 1e+15, got 1000000000000000000"),
    ],
)
def test_a_fault_is_one_line_with_its_place(change: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        build(Outer, {**GOOD, **change}, "f.toml")
    assert str(caught.value) == message


def test_each_fault_has_a_line_and_a_misspelt_key_is_not_missing_too() -> None:
    table = {"cuont": 1, "kind": "b", "inner": {"gain": -1}}
    with pytest.raises(InputError) as caught:
        build(Outer, table, "f.toml")
    assert sorted(str(caught.value).split("\n")) == [
        "f.toml: cuont: unknown key, did you mean 'count'?",
        "f.toml: inner.gain: expected >= 0, got -1",
    ]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"gain": -1.0}, "gain: expected >= 0, got -1.0"),
        ({"gain": 1.0, "least": 2.0}, "gain: expected at least 2, got 1"),
    ],
)
def test_a_class_refuses_the_same_values_in_code(arguments: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError) as by_name:  # noqa: PT011
        Inner(**arguments)
    with pytest.raises(ValueError) as by_place:  # noqa: PT011
        Inner(*arguments.values())
    with pytest.raises(ValueError) as changed:  # noqa: PT011
        replace(Inner(3.0), **arguments)
    assert [str(one.value) for one in (by_name, by_place, changed)] == [message] * 3


def test_settings_are_frozen_and_can_be_pickled() -> None:
    inner = Inner(1.0)
    assert pickle.loads(pickle.dumps(inner)) == inner
    with pytest.raises(FrozenInstanceError):
        inner.gain = 2.0  # type: ignore[misc]
