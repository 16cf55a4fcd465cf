"""The planner of a variant: the paper's, or the lane planner."""

from vpf_sim.driver_interface import DriverSetup
from vpf_sim.planning.lane.planner import LanePlanner
from vpf_sim.planning.paper.planner import PaperPlanner
from vpf_sim.planning.variant import Variant
from vpf_sim.planning.visibility import SpeedInSight


def create_planner(setup: DriverSetup, variant: Variant) -> PaperPlanner | LanePlanner:
    """A new planner for one episode."""
    if variant.lane_planner is not None:
        assert variant.visibility is not None  # Variant has checked
        return LanePlanner(setup, variant.lane_planner, SpeedInSight(variant.visibility, setup))
    assert variant.paper_planner is not None  # Variant has checked
    return PaperPlanner(setup, variant.paper_planner)
