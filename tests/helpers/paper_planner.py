"""The settings of the paper's planner in the variant `paper`."""

from vpf_sim.planning import variant
from vpf_sim.planning.paper.planner import PaperPlannerConfig


def _paper() -> PaperPlannerConfig:
    found = variant.load("paper").paper_planner
    assert found is not None
    return found


PAPER = _paper()
