"""The simulated world: roads, objects, the ego car, its camera, and the environment around them."""
