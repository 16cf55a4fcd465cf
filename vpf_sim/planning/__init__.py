"""From perception to a reference heading and speed.

- planner: the planner of a variant
- variant, variants: its configuration
- paper: the potential fields, as printed and repaired
- scene_planner, spacetime: candidate motions in a field over space and time
"""
