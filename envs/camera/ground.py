"""The road and the verge in the picture: what is painted on them, their grain, their colours."""

import cv2

from vpf_sim.envs.camera.grain import Grain, ground_top
from vpf_sim.envs.camera.layout import LaneShape
from vpf_sim.envs.camera.paint import painted
from vpf_sim.envs.camera.palette import ground_table
from vpf_sim.envs.camera.surface import Surface
from vpf_sim.envs.camera.view import View
from vpf_sim.types import Camera, Image


class Ground:
    """Paints every row below the horizon."""

    def __init__(self, camera: Camera, shapes: list[LaneShape], seed: int) -> None:
        self._top = ground_top(camera)
        self._surface = Surface(camera, painted(shapes, seed))
        self._grain = Grain(camera, seed)
        self._table = ground_table()

    def draw(self, view: View, frame: Image) -> None:
        """Paint the ground into the picture."""
        smooth = cv2.subtract(self._surface.draw(view), self._grain.mean)
        cv2.applyColorMap(cv2.add(smooth, self._grain.draw(view)), self._table, frame[self._top :])
