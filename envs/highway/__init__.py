"""highway-env's own roads and traffic: the world, the route through the lane network, and what is true of it."""
