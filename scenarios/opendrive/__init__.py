"""Roads from OpenDRIVE maps, converted to a scenario's `[road]` when its file is loaded.

    map file -> roads, junctions -> route -> lanes that run through it -> the curve of their centre -> segments

OpenDRIVE's y points left, ours right: only `spans.py` changes the sign. Elevation and superelevation are ignored.
"""

from vpf_sim.scenarios.opendrive.convert import road_table

__all__ = ["road_table"]
