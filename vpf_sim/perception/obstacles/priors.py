"""What is known of objects by their class; `road` needs the sizes too, so their class is in a neighbouring module."""

from vpf_sim.perception.object_sizes import ObjectSizes

__all__ = ["ObjectSizes"]
