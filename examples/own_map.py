"""Your own map: a road of an OpenDRIVE file as a scenario, with a van in the way, driven in the rain.

The map is written here, as short as one can be; any `.xodr` file does, such as CARLA's towns. Prints

    success after 23.4 s, least clearance 0.6 m
"""

# %% A map
# One road: a straight, a bend to the right and a straight, with two lanes to drive on.
import tempfile
from pathlib import Path

import vpf_sim

folder = Path(tempfile.mkdtemp())
lanes = "".join(f'<lane id="-{n}" type="driving"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>' for n in (1, 2))
with open(folder / "map.xodr", "w") as file:
    file.write(f"""<?xml version="1.0"?>
<OpenDRIVE><header revMajor="1" revMinor="4"/><road id="1" length="150" junction="-1"><planView>
<geometry s="0" x="0" y="0" hdg="0" length="60"><line/></geometry>
<geometry s="60" x="60" y="0" hdg="0" length="40"><arc curvature="-0.01"/></geometry>
<geometry s="100" x="98.9418342" y="-7.8939006" hdg="-0.4" length="50"><line/></geometry>
</planView><lanes><laneSection s="0"><center><lane id="0" type="none"/></center><right>{lanes}</right></laneSection>
</lanes></road></OpenDRIVE>""")

# %% A scenario on it
# The road is named by its id; places are metres along the carriageway, and lanes are counted from the right.
scenario = folder / "my_map.toml"
with open(scenario, "w") as file:
    file.write("""schema = 1
road = {opendrive = "map.xodr", route = ["1"], direction = "forward"}
ego = {lane = 1, s_m = 5.0}
goal = {s_m = 120.0}
bodies = [{kind = "van", s_m = 75.0, lane = 1, lateral_m = 0.6}]
""")

# %% Drive
episode = vpf_sim.drive(scenario, weather="rain", seed=0)
time_s, clearance_m = episode.steps["time_s"].iloc[-1], episode.record["min_clearance_m"]
print(f"{episode.status} after {time_s:.1f} s, least clearance {clearance_m:.1f} m")

# %% What the driver saw
# Two seconds before it is beside the van.
nearest = episode.steps.loc[episode.steps["clearance_m"].idxmin()]
episode.picture(time_s=nearest["time_s"] - 2.0)

# %% The path over the road
episode.plot()
