"""What the road's objects are: kinds and sizes."""

from highway_env.vehicle.objects import Obstacle, RoadObject

from vpf_sim.envs.camera.scenery.object_meshes import HEIGHTS_M


def kind_of(obj: RoadObject) -> str:
    """The kind of an object: its own, or that of its class."""
    return str(getattr(obj, "kind", "barrier" if isinstance(obj, Obstacle) else "car"))


def object_size(obj: RoadObject) -> tuple[float, float, float]:
    """(length, width, height) m."""
    height = getattr(obj, "HEIGHT", None)
    return (float(obj.LENGTH), float(obj.WIDTH), float(HEIGHTS_M[kind_of(obj)] if height is None else height))
