"""Verification of stored runs: whether what a run folder says follows from its steps, and from driving again."""
