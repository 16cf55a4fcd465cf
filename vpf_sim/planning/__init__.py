"""From what the camera tells to a reference heading and speed.

- planner: the pipeline, from a frame to a reference
- variant, variants: its configuration
- paper: the potential fields in the picture, as printed and repaired
- lane: the potential across the lane, its minimum, the path there, and the speed
"""
