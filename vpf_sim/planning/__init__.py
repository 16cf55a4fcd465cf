"""From perception to a reference heading and speed.

- planner: the planner of a variant
- variant, variants: its configuration
- paper: the potential fields, as printed and repaired
- lane: the lateral cost, the path to its minimum, and the speed
"""
