"""Drives episodes, scores them, and compares runs. Start reading at `episode/episode.py`, the closed loop.

Modules here are shared by all packages: `job` (an episode to drive), `environment` (what is used of an environment),
`steps` (the step table and ending of an episode), `score_keys` (scores by dotted key), `pool` (workers with timeouts
and retries).
Each package imports only packages above it:

- metrics: the scores of an episode, the registry of all metrics, and the record that holds the scores
- truth: ground truth from renderer and road, hidden from drivers
- episode: the closed loop, its step log and stage timing
- sweeps: many episodes, and their run folder
- analysis: statistics, comparisons and tables of a run's records
- perception: open-loop evaluation of perception on the poses of stored drives
- gate: pass/fail rules for a run, for CI
- verification: whether a stored run is what it says
"""
