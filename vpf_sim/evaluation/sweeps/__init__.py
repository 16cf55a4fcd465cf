"""Sweeps: the plan, local and cluster workers, and a run folder that can be resumed."""
