"""A first drive: one episode, its scores, and what the driver saw.

`vpf_sim.drive` returns the record (scores) and the steps (a pandas data frame with a row a frame). Prints

    success after 34.8 s
    path MSE 0.5 m2, least clearance 0.6 m
    speed 4.7 to 5.5 m/s

Nothing is stored; `out=True` would make a run folder.
"""

# %% Drive
# Town04 is the paper's road, with two parked cars in the way. The driver `vpf` finds them in the camera's frames.
import vpf_sim

episode = vpf_sim.drive("town04", seed=3)
record, steps = episode.record, episode.steps
print(f"{episode.status} after {steps['time_s'].iloc[-1]:.1f} s")
print(f"path MSE {record['path_mse_m2']:.1f} m2, least clearance {record['min_clearance_m']:.1f} m")
print(f"speed {steps['speed_mps'].min():.1f} to {steps['speed_mps'].max():.1f} m/s")

# %% What the driver saw
# The frame beside the first parked car, with what the driver makes of it: flow, obstacles, road edges, planned path.
first_half = steps[steps["route_m"] < steps["route_m"].max() / 2]
nearest_s = first_half.loc[first_half["clearance_m"].idxmin(), "time_s"]
episode.picture(time_s=nearest_s - 2.0)

# %% What happened
# The path over the road, throttle and steering, and all scores. `episode.video()` makes the whole drive a video.
episode.plot()
