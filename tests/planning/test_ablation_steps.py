"""From `full-frame` to `robust` one change at a time: the steps, and variants of one's own laid over them."""

from dataclasses import replace
from pathlib import Path

import pytest

from vpf_sim import drivers
from vpf_sim.errors import InputError
from vpf_sim.planning import variant
from vpf_sim.planning.variant import Variant
from vpf_sim.planning.variants.ablation_steps import CHANGES, Change, Table, steps

PAPER, ROBUST = (variant.table(name) for name in ("full-frame", "robust"))
STEPS = steps(PAPER, ROBUST)


def leaves(table: Table, path: str = "") -> dict[str, object]:
    """Value by dotted key."""
    found: dict[str, object] = {}
    for key, value in table.items():
        where = f"{path}{key}"
        found |= leaves(value, f"{where}.") if isinstance(value, dict) and value else {where: value}
    return found


def test_the_changes_lead_from_full_frame_to_robust() -> None:
    """A key of robust that no change takes over shows here: give it a change in planning/variants/ablation_steps.py."""
    last = [*STEPS.values()][-1][1]
    assert leaves(last) == leaves(ROBUST)
    assert variant.load([*STEPS][-1]) == variant.load("robust")


def test_each_step_changes_what_it_names_and_nothing_else() -> None:
    by_name: dict[str, Change] = {change.name: change for change in CHANGES}
    before = leaves(PAPER)
    for name, (_, table) in STEPS.items():
        after, change = leaves(table), by_name[name]
        moved = {key for key in before.keys() | after.keys() if before.get(key) != after.get(key)}
        assert moved
        assert all(any(f"{key}.".startswith(f"{path}.") for path in change.takes) for key in moved)
        before = after


def test_each_step_can_be_built_and_is_a_driver() -> None:
    assert [*variant.ablation()] == [*STEPS]
    for name in STEPS:
        assert isinstance(variant.load(name), Variant)
        assert drivers.create(f"vpf@{name}").privileged == "none"
        assert drivers.description(f"vpf@{name}").summary == STEPS[name][0]


def test_the_super_twisting_variant_is_robust_with_other_gains() -> None:
    twisting, robust = variant.load("super-twisting"), variant.load("robust")
    assert (twisting.gains, robust.gains) == ("super-twisting", "robust")
    assert replace(twisting, gains="robust") == robust


def test_a_change_that_changes_nothing_is_no_step() -> None:
    assert "flow" in STEPS
    assert "flow" not in steps(PAPER, ROBUST | {"flow": PAPER["flow"]})


def test_the_tables_that_steps_are_made_of_stay_as_they_are() -> None:
    again = (variant.table(name) for name in ("full-frame", "robust"))
    steps(PAPER, ROBUST)
    assert tuple(again) == (PAPER, ROBUST)


def written(folder: Path, text: str) -> str:
    path = folder / "mine.toml"
    path.write_text(text)
    return str(path)


def test_a_variant_of_ones_own_says_what_it_starts_from_and_what_it_changes(tmp_path: Path) -> None:
    own = variant.load(written(tmp_path, "[road_edges]\nlanes = 3\n[lane_planner.clearance]\nwanted_m = 0.7\n"))
    robust = variant.load("robust")
    assert own.road_edges.lanes == 3
    assert own.lane_planner is not None
    assert robust.lane_planner is not None
    assert own.lane_planner.clearance.wanted_m == 0.7
    assert own.lane_planner.path == robust.lane_planner.path
    assert own.flow == robust.flow
    assert variant.load(written(tmp_path, 'base = "lane_planner"')) == variant.load("lane_planner")
    assert drivers.create(f"vpf@{tmp_path / 'mine.toml'}").privileged == "none"


def test_a_section_by_a_variants_name_is_taken_whole_from_it(tmp_path: Path) -> None:
    own = variant.load(written(tmp_path, 'base = "paper"\nflow = "literal"\n[obstacle_map]\nsigma_px = 200.0\n'))
    paper, literal = variant.load("paper"), variant.load("literal")
    assert own.flow == literal.flow != paper.flow
    assert own == replace(paper, flow=literal.flow, obstacle_map=replace(paper.obstacle_map, sigma_px=200.0))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('base = "robus"', "unknown variant 'robus': did you mean 'robust'?"),
        ("base = 3", "mine.toml: base: expected the name of a variant, got 3"),
        ("[flow]\nwindow = 3", "mine.toml: flow.window: unknown key, did you mean 'window_s'?"),
        ('road_edges = "robus"', "mine.toml: road_edges: unknown variant 'robus': did you mean 'robust'?"),
        ('odometry = "paper"', "mine.toml: odometry: expected a variant with [odometry], got 'paper'"),
        ('flow = "other.toml"', "mine.toml: flow: expected the name of a variant, got 'other.toml'"),
        ("flow = 3", "mine.toml: flow: expected a table, got 3"),
        ('gains = "robus"', "unknown gains 'robus': did you mean 'robust'?"),
        ('static_obstacles = "none"', "mine.toml: [lane_planner] needs [static_obstacles]"),
    ],
)
def test_a_wrong_variant_of_ones_own_is_one_clear_line(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        drivers.create(f"vpf@{written(tmp_path, text)}")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
