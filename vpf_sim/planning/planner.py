"""The planner of a variant: the paper's, or the scene planner."""

from vpf_sim.driver_interface import DriverSetup
from vpf_sim.planning.paper.planner import PaperPlanner
from vpf_sim.planning.planner_interface import Planner
from vpf_sim.planning.variant import Variant
from vpf_sim.planning.visibility import SpeedInSight


def create_planner(setup: DriverSetup, variant: Variant) -> Planner:
    """A new planner for one episode."""
    if variant.paper_planner is not None:
        return PaperPlanner(setup, variant.paper_planner)
    assert variant.scene is not None  # Variant has checked
    assert variant.visibility is not None
    in_sight = SpeedInSight(variant.visibility, setup)
    from vpf_sim.planning.scene_planner import ScenePlanner  # imports scipy.optimize, which others do not need

    return ScenePlanner(setup, variant.scene, in_sight)
