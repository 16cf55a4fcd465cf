"""Perception alone: stored drives seen again, and what a driver perceives at each frame scored against truth."""
