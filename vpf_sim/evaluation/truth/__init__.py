"""What the renderer and the road know and no driver is told: what is around the car, what moved, what stands where."""
