"""The balance strategy: turn away from the side with more optical flow.

K. Souhila and A. Karim, Optical Flow Based Robot Obstacle Avoidance, Int. J. of Advanced Robotic Systems 4(1), 2007,
doi:10.5772/5715. Nearer things move faster in the image, so with the sums F_L and F_R of the flow's magnitude in the
left and the right half of the image

    steering = K (F_L - F_R) / (F_L + F_R)

keeps the car in the middle between what is textured on both sides, and away from obstacles. Here the flow is dense
inverse search (Kroeger et al. 2016) in place of Horn and Schunck, and the car's measured rotation is taken out of it,
since it moves near and far points alike. The robot of the source turns on the spot; K is ours, found on development
seeds.
"""

import cv2
import numpy as np

from vpf_sim.controllers.pid import SpeedPid, load_gains
from vpf_sim.types import Camera, Command, Driver, DriverSetup, Floats, Image, Observation

SCALE = 4  # pixels of the frame per pixel of the flow's image
FRAME_HZ = 20.0
GAIN = 1.5  # K, steering per unit of balance
SMOOTHING = 0.3  # weight of the newest balance


class FlowBalanceDriver(Driver):
    """Steers by the balance of left and right optical flow, at the reference speed."""

    def reset(self, setup: DriverSetup) -> None:
        self._camera = setup.camera
        self._speed = SpeedPid(load_gains(), setup.speed_reference_mps, setup.rate_hz)
        self._flow = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_FAST)
        self._last: tuple[float, float, Image] | None = None  # time s, yaw rad, small grey image
        self._steering = 0.0

    def act(self, observation: Observation) -> Command:
        last = self._last
        if last is None or observation.frame_time_s - last[0] > 0.9 / FRAME_HZ:
            small = _small(observation.image)
            if last is not None:
                turned_rad = observation.yaw_rad - last[1]
                flow_px = self._flow.calc(last[2], small, None) - rotational_flow(self._camera, small, turned_rad)
                self._steering += SMOOTHING * (GAIN * balance(flow_px) - self._steering)
            self._last = observation.frame_time_s, observation.yaw_rad, small
        return Command(self._speed.throttle(observation.speed_mps), float(np.clip(self._steering, -1.0, 1.0)))


def balance(flow_px: Floats) -> float:
    """-1 to 1: the share of the flow's magnitude (H, W, 2) in the left half, less that of the right one."""
    magnitude = np.hypot(flow_px[..., 0], flow_px[..., 1])
    half = magnitude.shape[1] // 2
    left, right = float(magnitude[:, :half].sum()), float(magnitude[:, -half:].sum())
    return (left - right) / (left + right) if left + right > 0.0 else 0.0


def rotational_flow(camera: Camera, image: Image, turned_rad: float) -> Floats:
    """(H, W, 2) the flow of a camera that yaws to the right by an angle, in pixels of the (smaller) image."""
    height, width = image.shape[:2]
    focal_px = camera.fx_px * width / camera.width_px
    x = np.arange(width) - 0.5 * (width - 1)
    y = (np.arange(height) - 0.5 * (height - 1))[:, None]
    across, down = focal_px + x**2 / focal_px, x * y / focal_px
    return -turned_rad * np.stack([np.broadcast_to(across, down.shape), down], axis=-1)


def _small(image: Image) -> Image:
    """The lower part of a frame in grey, from the horizon down, without most of the sky."""
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    size = grey.shape[1] // SCALE, grey.shape[0] // SCALE
    return cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
