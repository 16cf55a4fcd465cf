"""Planning in space and time: candidate motions, limits that they must keep, and the least cost in a field.

`planner.py` reads as the method's one page.
"""
