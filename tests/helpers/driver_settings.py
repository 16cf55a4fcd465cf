"""Settings of the installed variants, for tests of single stages."""

from dataclasses import replace

from vpf_sim.perception.egomotion.config import ExpansionConfig, FocusFitConfig
from vpf_sim.planning.variant import load

ROBUST, FULL_FRAME = load("robust"), load("full-frame")


def focus_fit() -> FocusFitConfig:
    """Settings of the robust focus of expansion."""
    assert ROBUST.focus_of_expansion.fit is not None
    return ROBUST.focus_of_expansion.fit


def expansion(method: str) -> ExpansionConfig:
    """The robust variant's focus of expansion with another method."""
    return replace(ROBUST.focus_of_expansion, method=method)
