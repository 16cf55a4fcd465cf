"""Your own driver: a class with one method. This one finds the verge by its colour, and keeps its distance from it.

Asphalt and paint are grey, while grass and soil have more red than blue. In the image row that shows the road 10 m
ahead, the first such pixel right of the middle is the verge. Prints how each drive ends and how far the car was from
the middle of its lane at most; the driver knows nothing of parked cars:

    curve-left  success   0.5 m
    town04      collision 0.4 m
"""

# %% One method
# `reset` gets camera, vehicle and speed; `act` gets the frame, pose and speed, and returns throttle and steering.
import numpy as np
from numpy.typing import NDArray

import vpf_sim

AHEAD_M = 10.0  # from the camera, along the road
TO_VERGE_M = 5.5  # from the middle of the second lane: one and a half lanes of 3.5 m, and 0.25 m beside them
YELLOWISH = 20  # red minus blue, in levels of 255; asphalt has less than 10


class ByColour(vpf_sim.Driver):
    """Pure pursuit of a point 10 m ahead, at a fixed distance from the verge."""

    def reset(self, setup: vpf_sim.DriverSetup) -> None:
        self.camera, self.vehicle = setup.camera, setup.vehicle
        self.speed_mps = setup.speed_reference_mps

    def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:
        lateral_m = self.verge_m(observation.image) - TO_VERGE_M
        from_rear_axle_m = AHEAD_M + self.camera.forward_m + self.vehicle.l_r_m
        curvature_per_m = 2.0 * lateral_m / (from_rear_axle_m**2 + lateral_m**2)
        angle_rad = np.arctan(self.vehicle.wheelbase_m * curvature_per_m)
        steering = np.clip(angle_rad / self.vehicle.steering_limit_rad, -1.0, 1.0)
        return vpf_sim.Command(throttle=self.speed_mps - observation.speed_mps, steering=float(steering))

    def verge_m(self, image: NDArray[np.uint8]) -> float:
        """Metres to the right, 10 m ahead, at which the verge begins."""
        camera = self.camera
        row = round(camera.cy_px + camera.fy_px * camera.height_m / AHEAD_M)  # a pinhole camera above a flat road
        right = image[row - 1 : row + 2, round(camera.cx_px) :].astype(float).mean(axis=0)
        column = np.argmax(right[:, 0] - right[:, 2] > YELLOWISH)
        return float(column * AHEAD_M / camera.fx_px)


# %% Drive
for scenario in ("curve-left", "town04"):
    episode = vpf_sim.drive(scenario, driver=ByColour, seed=7)
    farthest_m = episode.steps["lane_offset_m"].abs().max()
    print(f"{scenario:11} {episode.status:9} {farthest_m:.1f} m")

# %% Why did it fail?
# The last frame of the second drive, and its path: a parked car is in the lane.
episode.picture()
