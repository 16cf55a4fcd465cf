"""What is under test: planner and controller together, or a baseline; and the registry that knows them by name.

Naming the drivers loads none of them: planners and controllers are imported when a driver is created.
"""

from vpf_sim.drivers.baselines import IdmDriver, NeutralDriver, RouteDriver
from vpf_sim.drivers.own import DriverLike, OwnDriver, admit, is_importable, name_of
from vpf_sim.drivers.protocol import command_of, needs_next_frame, perception_of, trace_of, uncertainty_of, uses_images
from vpf_sim.drivers.registry import (
    KEYBOARD,
    MODEL_PREFIX,
    VARIANT_PREFIX,
    Description,
    create,
    describe,
    description,
    has_name,
    model_of,
    names,
)
from vpf_sim.drivers.vision_driver import VisionDriver

__all__ = [
    "KEYBOARD",
    "MODEL_PREFIX",
    "VARIANT_PREFIX",
    "Description",
    "DriverLike",
    "IdmDriver",
    "NeutralDriver",
    "OwnDriver",
    "RouteDriver",
    "VisionDriver",
    "admit",
    "command_of",
    "create",
    "describe",
    "description",
    "has_name",
    "is_importable",
    "model_of",
    "name_of",
    "names",
    "needs_next_frame",
    "perception_of",
    "trace_of",
    "uncertainty_of",
    "uses_images",
]
