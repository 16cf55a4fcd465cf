"""Kinds of objects on a road, and their sizes."""

from typing import Literal, NamedTuple

from vpf_sim.types import VehicleModel

ObjectKind = Literal["car", "van", "truck", "cone", "pallet", "barrier", "pedestrian", "cyclist", "deer", "door"]


class Size(NamedTuple):
    """An object's box: along its heading, across it, above the road."""

    length_m: float
    width_m: float
    height_m: float


SIZES: dict[ObjectKind, Size] = {
    "car": Size(5.0, 2.0, 1.5),
    "van": Size(5.5, 2.1, 2.3),
    "truck": Size(8.5, 2.5, 3.4),
    "cone": Size(0.4, 0.4, 0.75),
    "pallet": Size(1.2, 0.8, 0.15),  # EUR pallet, flat on the road
    "barrier": Size(0.5, 3.0, 1.0),  # across the road
    "pedestrian": Size(0.4, 0.5, 1.75),
    "cyclist": Size(1.8, 0.6, 1.75),
    "deer": Size(1.5, 0.45, 1.3),
    "door": Size(1.0, 0.12, 1.3),  # of a parked car: along its side, and across the road once it opens
}

MOVING: frozenset[ObjectKind] = frozenset(
    {"car", "van", "truck", "pedestrian", "cyclist", "deer", "door"}
)  # may have a speed

EGO_SIZE = Size(VehicleModel().length_m, VehicleModel().width_m, 1.5)
