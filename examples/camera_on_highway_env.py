"""The first-person camera on highway-env's own environment `highway-v0`, in four weathers.

`vpf_sim.CameraObservation` adds the frame as `image`. Actions and rewards of highway-env stay as they are, and so does
its observation, as `state`. Prints

    ClearSunset   image (240, 320, 3), state (5, 5)
    FoggyNoon     image (240, 320, 3), state (5, 5)
    WetCloudyNoon image (240, 320, 3), state (5, 5)
    HardRainNoon  image (240, 320, 3), state (5, 5)

and shows the frames after four steps of "faster".
"""

# %% A camera
# Weather and camera are free: 320 x 240 pixels, 90 degrees wide, on the windscreen.
import gymnasium
import highway_env  # noqa: F401 (registers highway-v0)
import matplotlib.pyplot as plt

import vpf_sim

WEATHERS = ("ClearSunset", "FoggyNoon", "WetCloudyNoon", "HardRainNoon")
FASTER = 3
rig = vpf_sim.Rig(vpf_sim.Camera(320, 240))

# %% The same drive in four weathers
# The traffic is drawn from the seed, so only the weather differs.
frames = {}
for weather in WEATHERS:
    environment = vpf_sim.CameraObservation(gymnasium.make("highway-v0"), weather=weather, rig=rig)
    environment.reset(seed=3)
    for _ in range(4):
        observation = environment.step(FASTER)[0]
    frames[weather] = observation["image"]
    print(f"{weather:13} image {observation['image'].shape}, state {observation['state'].shape}")

# %% The frames
figure, axes = plt.subplots(2, 2, figsize=(8, 6), layout="constrained")
for axis, (weather, image) in zip(axes.flat, frames.items(), strict=True):
    axis.imshow(image)
    axis.set_title(weather, fontsize="medium")
    axis.set_axis_off()
plt.show()
