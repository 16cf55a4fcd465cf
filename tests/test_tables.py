"""Configuration from TOML tables: what is wrong is said in one line."""

from dataclasses import dataclass
from typing import Any, Literal

import pytest

from vpf_sim.errors import InputError
from vpf_sim.tables import build


@dataclass(frozen=True)
class Inner:
    gain: float

    def __post_init__(self) -> None:
        if self.gain < 0.0:
            raise ValueError(f"gain: expected >= 0, got {self.gain}")


@dataclass(frozen=True)
class Outer:
    count: int
    kind: Literal["a", "b"]
    inner: Inner
    pair: tuple[float, float] = (0.0, 1.0)
    level: int | None = 2


GOOD: dict[str, Any] = {"count": 3, "kind": "b", "inner": {"gain": 1}, "pair": [1, 2.5], "level": "none"}


def test_every_kind_of_value_is_read() -> None:
    assert build(Outer, GOOD, "f.toml") == Outer(3, "b", Inner(1.0), (1.0, 2.5), None)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"cuont": 1}, "f.toml: unknown key 'cuont': did you mean 'count'?"),
        ({"count": 1.5}, "f.toml: count: expected int, got 1.5"),
        ({"count": True}, "f.toml: count: expected int, got True"),
        ({"kind": "c"}, "f.toml: kind: expected one of a, b, got 'c'"),
        ({"inner": 3}, "f.toml: inner: expected a table, got 3"),
        ({"inner": {"gain": "x"}}, "f.toml: inner: gain: expected float, got 'x'"),
        ({"inner": {"gain": -1}}, "f.toml: inner: gain: expected >= 0, got -1.0"),
        ({"inner": {}}, "f.toml: inner: key 'gain' is missing"),
        ({"pair": [1]}, "f.toml: pair: expected 2 values, got 1"),
    ],
)
def test_a_fault_is_told_with_its_place(change: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        build(Outer, {**GOOD, **change}, "f.toml")
    assert str(caught.value) == message
