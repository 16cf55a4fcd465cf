"""The steps from `paper` to `robust`, and variants of one's own."""

from dataclasses import fields, replace
from itertools import pairwise
from pathlib import Path

from vpf_sim import drivers
from vpf_sim.evaluation.sweeps.plan import make_plan, read_plan
from vpf_sim.planning import variant
from vpf_sim.planning.variant import Variant

STEPS = make_plan(read_plan("ablation"), "ablation").driver
CHANGES = [
    {"gains"},
    {"odometry"},
    {"camera_pitch"},
    {"verges", "static_obstacles", "visibility", "scene", "paper_planner", "obstacle_map"},
    {"moving_obstacles", "crossing"},
]


def differences(one: Variant, other: Variant) -> set[str]:
    """The sections in which two variants differ."""
    return {field.name for field in fields(Variant) if getattr(one, field.name) != getattr(other, field.name)}


def test_the_ablation_leads_from_the_papers_law_to_ours() -> None:
    """A section that differs in `paper` and `robust` and that no step changes shows here."""
    assert (STEPS[0], STEPS[-1]) == ("vpf-paper", "vpf")
    names = ["paper", *(step.removeprefix("vpf@") for step in STEPS[1:-1]), "robust"]
    variants = [variant.load(name) for name in names]
    assert [differences(one, other) for one, other in pairwise(variants)] == CHANGES


def test_each_step_is_a_driver_without_privilege() -> None:
    assert all(drivers.create(step).privileged == "none" for step in STEPS)


def test_the_super_twisting_variant_is_robust_with_other_gains() -> None:
    twisting, robust = variant.load("super-twisting"), variant.load("robust")
    assert (twisting.gains, robust.gains) == ("super-twisting", "motion")
    assert replace(twisting, gains="motion") == robust


def written(folder: Path, text: str) -> str:
    path = folder / "mine.toml"
    path.write_text(text)
    return str(path)


def test_a_variant_of_ones_own_says_what_it_starts_from_and_what_it_changes(tmp_path: Path) -> None:
    own = variant.load(written(tmp_path, "[road_edges]\nlanes = 3\n[scene.unseen]\npatience_s = 2.0\n"))
    robust = variant.load("robust")
    assert own.road_edges.lanes == 3
    assert own.scene is not None
    assert robust.scene is not None
    assert own.scene.unseen.patience_s == 2.0
    assert own.scene.tracker == robust.scene.tracker
    assert own.flow == robust.flow
    assert variant.load(written(tmp_path, 'base = "static_obstacles"')) == variant.load("static_obstacles")
    assert drivers.create(f"vpf@{tmp_path / 'mine.toml'}").privileged == "none"


def test_a_section_by_a_variants_name_is_taken_whole_from_it(tmp_path: Path) -> None:
    own = variant.load(written(tmp_path, 'base = "paper"\nflow = "literal"\n[obstacle_map]\nsigma_px = 200.0\n'))
    paper, literal = variant.load("paper"), variant.load("literal")
    assert own.flow == literal.flow != paper.flow
    assert own == replace(paper, flow=literal.flow, obstacle_map=replace(paper.obstacle_map, sigma_px=200.0))
