"""The world: roads, bodies, the ego car, its camera, and the environment around them."""
