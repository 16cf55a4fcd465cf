"""What is under test: planner and controller together, or a baseline; and the registry that knows them by name.

Naming the drivers loads none of them: planners and controllers are imported when a driver is created.
"""

from vpf_sim.drivers.idm import IdmDriver
from vpf_sim.drivers.neutral import NeutralDriver
from vpf_sim.drivers.potential_field import FieldDriver
from vpf_sim.drivers.protocol import command_of, needs_next_frame, perception_of, trace_of, uses_images
from vpf_sim.drivers.registry import FIELD, Description, create, describe, description, names
from vpf_sim.drivers.route_followers import RouteDriver

__all__ = [
    "FIELD",
    "Description",
    "FieldDriver",
    "IdmDriver",
    "NeutralDriver",
    "RouteDriver",
    "command_of",
    "create",
    "describe",
    "description",
    "names",
    "needs_next_frame",
    "perception_of",
    "trace_of",
    "uses_images",
]
