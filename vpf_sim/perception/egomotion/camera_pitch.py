"""Compensation of the camera's mount pitch in flow and frames."""

from dataclasses import replace

import cv2
import numpy as np

from vpf_sim.perception.egomotion.config import PitchConfig
from vpf_sim.perception.egomotion.mount_pitch import MountPitch
from vpf_sim.types import Camera, Floats, Flow, Image


class PitchEstimator:
    """Estimates the camera's mount pitch by the road's lines and compensates it. Without pitch nothing changes."""

    def __init__(self, camera: Camera, config: PitchConfig) -> None:
        self._camera = camera
        self._mounting = MountPitch(config)

    def update_mount_pitch(self, pitch_rad: float, sigma_rad: float, time_s: float) -> None:
        """Add a pitch that the road's lines show."""
        self._mounting.update(pitch_rad, sigma_rad, time_s)

    @property
    def mounted_rad(self) -> float:
        """Mount pitch to compensate, + looks down."""
        return self._mounting.pitch_rad

    def flow(self, flow: Flow) -> Flow:
        """The flow of a camera without pitch."""
        if self.mounted_rad == 0.0:
            return flow
        now = self._steady(flow.points_px)
        past = self._steady(flow.points_px - flow.displacement_px)
        return replace(flow, points_px=now, displacement_px=now - past, first_px=self._steady(flow.first_px))

    def frame(self, image: Image) -> Image:
        """(H, W) or (H, W, 3) the frame of a camera without pitch, its rim repeated."""
        if self.mounted_rad == 0.0:
            return image
        camera, (c, s) = self._camera, (np.cos(self.mounted_rad), np.sin(self.mounted_rad))
        matrix = np.array([[camera.fx_px, 0.0, camera.cx_px], [0.0, camera.fy_px, camera.cy_px], [0.0, 0.0, 1.0]])
        turn = np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])
        size = (image.shape[1], image.shape[0])
        steady: Image = cv2.warpPerspective(
            image, matrix @ turn @ np.linalg.inv(matrix), size, borderMode=cv2.BORDER_REPLICATE
        ).astype(np.uint8, copy=False)
        return steady

    def _steady(self, points_px: Floats) -> Floats:
        """(N, 2) px without the pitch, which moves points by -f (x y, 1 + y^2) (Longuet-Higgins and Prazdny 1980)."""
        camera = self._camera
        x = (points_px[:, 0] - camera.cx_px) / camera.fx_px
        y = (points_px[:, 1] - camera.cy_px) / camera.fy_px
        motion = np.stack([-camera.fx_px * x * y, -camera.fy_px * (1.0 + y * y)], axis=1)
        steady: Floats = points_px - self.mounted_rad * motion
        return steady
