"""Knock-outs: each leaves out one mechanism of `robust`, and only that."""

from dataclasses import fields, is_dataclass
from typing import Any

import pytest

from vpf_sim.planning import variant

KNOCKOUTS = list(variant.ablation("mechanisms"))


def differences(one: Any, other: Any, path: tuple[str, ...] = ()) -> list[tuple[tuple[str, ...], Any]]:
    """The paths at which two configurations differ, and what the second has there."""
    if not (is_dataclass(one) and is_dataclass(other)):
        return [] if one == other else [(path, other)]
    return [
        difference
        for field in fields(one)
        for difference in differences(getattr(one, field.name), getattr(other, field.name), (*path, field.name))
    ]


@pytest.mark.parametrize("name", KNOCKOUTS)
def test_a_knockout_switches_off_one_section_and_nothing_else(name: str) -> None:
    ((path, value),) = differences(variant.load("robust"), variant.load(name))
    assert value is None
    assert name == "no-" + "-".join(path).replace("_", "-")


@pytest.mark.parametrize("name", KNOCKOUTS)
def test_a_knockout_says_what_the_mechanism_does(name: str) -> None:
    _, meaning = variant.ablation("mechanisms")[name].split("]: ", maxsplit=1)
    assert meaning


def test_there_are_knockouts() -> None:
    assert {"no-camera-pitch", "no-moving-obstacles"} <= set(KNOCKOUTS)
