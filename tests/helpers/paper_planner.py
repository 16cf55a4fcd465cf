"""The settings of the paper's planner in the variant `paper`."""

from driver_settings import unwrap

from vpf_sim.planning import variant

PAPER = unwrap(variant.load("paper").paper_planner)
