"""From `literal` to `paper` one repair at a time, and `paper` without one of them."""

import pytest

from vpf_sim import configuration, drivers
from vpf_sim.evaluation.analysis import ablation
from vpf_sim.planning import variant
from vpf_sim.planning.variant import PACKAGE
from vpf_sim.planning.variants.repair_steps import REPAIRS

LITERAL, PAPER = variant.load("literal"), variant.load("paper")
MADE, WITHOUT = variant.ablation("paper"), variant.ablation("without")


def test_the_repairs_lead_from_literal_to_paper() -> None:
    """A key of paper that no repair takes over shows here: give it one in planning/variants/repair_steps.py."""
    assert variant.load([*MADE][-1]) == PAPER


def test_a_repair_that_is_taken_back_leaves_the_others() -> None:
    assert len(WITHOUT) == len(MADE)
    for name in WITHOUT:
        assert variant.load(name) not in (PAPER, LITERAL)


def test_each_repair_takes_keys_of_its_own() -> None:
    taken = [path for repair in REPAIRS for path in repair.takes]
    assert len(set(taken)) == len(taken)
    assert not any(one != other and f"{one}.".startswith(f"{other}.") for one in taken for other in taken)


def test_steps_of_all_chains_have_names_of_their_own_and_are_drivers() -> None:
    names = [name for chain in ("robust", "paper", "without") for name in variant.ablation(chain)]
    assert len(set(names)) == len(names)
    for name, summary in (MADE | WITHOUT).items():
        assert drivers.description(f"vpf@{name}").summary == summary


@pytest.mark.parametrize(
    ("chain", "first", "last"), [("robust", "vpf@full-frame", "vpf"), ("paper", "vpf-literal", "vpf-paper")]
)
def test_a_chain_goes_from_its_first_driver_to_its_last(chain: variant.Chain, first: str, last: str) -> None:
    told = [*ablation.ablation_steps(chain)]
    assert (told[0], told[-1]) == (first, last)
    assert ablation.plan(None, [], [], chain).driver == tuple(told)


def test_what_is_taken_back_is_held_against_the_whole() -> None:
    plan = ablation.plan("0:1", ["town04"], ["clear"], "without")
    rows = ablation.table(plan.jobs(), [], [])["rows"]
    assert rows[0]["driver"] == "vpf-paper"
    assert rows[0]["difference"] is None
    assert all(row["difference"] is not None for row in rows[1:])


def test_every_file_of_a_variant_says_what_it_is() -> None:
    for name in variant.names():
        assert configuration.read(PACKAGE, f"{name}.toml")
