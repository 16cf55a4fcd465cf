"""Drive one episode, look at its scores and plot what happened.

`vpf_sim.drive` returns the record (scores), the steps (a pandas data frame with a row a frame) and the times. Prints

    success after 34.8 s
    path MSE 0.3 m2, least clearance 0.6 m
    speed 5.0 to 5.5 m/s

and shows plots over the distance driven, and the first frame. Nothing is stored; `out=True` would make a run folder.
"""

# %% Drive
# Town04 is the paper's road, with two parked cars in the way.
import gymnasium
import matplotlib.pyplot as plt
import numpy as np

import vpf_sim

episode = vpf_sim.drive("town04", seed=3)
record, steps = episode.record, episode.steps
print(f"{episode.status} after {steps['time_s'].iloc[-1]:.1f} s")
print(f"path MSE {record['path_mse_m2']:.1f} m2, least clearance {record['min_clearance_m']:.1f} m")
print(f"speed {steps['speed_mps'].min():.1f} to {steps['speed_mps'].max():.1f} m/s")

# %% What happened
# The car leaves the middle of its lane twice, once for each parked car.
figure, axes = plt.subplots(3, 1, sharex=True, figsize=(8, 5), layout="constrained")
for axis, column, label in zip(
    axes,
    ("lane_offset_m", "speed_mps", "steering"),
    ("right of the lane's middle, m", "speed, m/s", "steering, share of 40 deg"),
    strict=True,
):
    axis.plot(steps["route_m"], steps[column])
    axis.set_ylabel(label, fontsize="small")
axes[-1].set_xlabel("distance along the route, m")
plt.show()

# %% What the driver saw
# The environment of the same road and seed draws the same frames.
environment = gymnasium.make("vpf_sim/FourLane-v0", scenario="town04")
observation, _ = environment.reset(seed=3)
figure, frame = plt.subplots(figsize=(6, 4.5), layout="constrained")
frame.imshow(np.asarray(observation["image"]))
frame.set_axis_off()
plt.show()
