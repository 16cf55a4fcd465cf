"""The simulated world: roads, objects, the ego car, its camera, and the environment around them."""

from vpf_sim.envs import import_highway_env as import_highway_env
