"""The variants: all load, hold what the documents say of them, and refuse nonsense."""

from dataclasses import replace

import pytest

from vpf_sim.planning import variant
from vpf_sim.planning.variant import Variant


def test_all_variants_load() -> None:
    assert {"full-frame", "literal", "paper", "robust", "super-twisting"} <= {*variant.names()}
    for name in variant.names():
        assert isinstance(variant.load(name), Variant)


@pytest.mark.parametrize("name", ["full-frame", "paper"])
def test_literal_is_printed_throughout_and_the_others_repaired(name: str) -> None:
    literal, paper = (variant.load(one).paper_planner for one in ("literal", name))
    assert literal is not None
    assert paper is not None
    assert (literal.target_field.direction, paper.target_field.direction) == ("printed", "repaired")
    assert (literal.obstacle_field.terms, paper.obstacle_field.terms) == ("printed", "lateral")
    assert (literal.road_field.shape, paper.road_field.shape) == ("printed", "repaired")
    assert (literal.total_field.axes, paper.total_field.axes) == ("printed", "mapped")
    assert (literal.total_field.rotation, paper.total_field.rotation) == ("printed", "repaired")
    assert (literal.reference.heading, paper.reference.heading) == ("printed", "repaired")
    # Table I of the paper.
    for line in (literal, paper):
        road = line.road_field
        assert (road.depth, road.b_per_m) == (0.5, 1.0)
        assert (road.c2_straight, road.c2_curved_per_m, road.x_offset_m) == (0.005, 5e-6, 1e-10)


def test_the_papers_flow_and_smoothing() -> None:
    for name in ("literal", "full-frame"):
        stages = variant.load(name)
        assert (stages.flow.window_px, stages.flow.max_level, stages.flow.epsilon_px) == (25, 2, 0.03)
        assert stages.obstacle_map.sigma_px == 320.0


def test_one_way_through_the_field_and_what_it_needs() -> None:
    robust, paper = variant.load("robust"), variant.load("paper")
    with pytest.raises(ValueError, match="exactly one of"):
        replace(robust, paper_planner=paper.paper_planner)
    with pytest.raises(ValueError, match="exactly one of"):
        replace(robust, scene=None)
    with pytest.raises(ValueError, match="\\[scene\\] needs \\[visibility\\]"):
        replace(robust, visibility=None)
    with pytest.raises(ValueError, match="needs \\[static_obstacles\\]"):
        replace(robust, static_obstacles=None)
