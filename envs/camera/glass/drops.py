"""The record of a drop on the windscreen, and its drawing on the planes."""

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.glass.impacts import FOOTPRINT, SMALLEST_MM
from vpf_sim.envs.camera.glass.pane import Pane
from vpf_sim.envs.camera.glass.planes import ROWS, Box, Planes
from vpf_sim.envs.camera.glass.stamps import stamp
from vpf_sim.types import Image

SIZE_STEP = 1.08  # ratio between drawn sizes
BAND_PX = 16  # rows per band; drops are drawn as in its middle

Drops = NDArray[np.void]
PLACE = ["column", "row"]
EXTENTS = ["width", "height", "blur", "blur_y"]
DRAWN = [*PLACE, *EXTENTS, "variant"]
DROP = np.dtype(
    [
        *((name, "f8") for name in ("x", "y")),  # px
        ("size", "f8"),  # mm, diameter of a sphere of equal volume
        ("dies", "f8"),  # s
        ("turns", "f8"),  # s, next start or stop
        ("run", "f8"),  # m/s, 0 at rest
        *((name, "i4") for name in (*DRAWN, "rx", "ry")),  # on the planes: px; stamps in 1/8 px; half extents
    ]
)


class DropPicture:
    """Draws drops on planes."""

    def __init__(self, pane: Pane, planes: Planes) -> None:
        self.planes = planes
        self._pane = pane
        self.drawing = True  # False: suspended
        middles = np.minimum(np.arange(BAND_PX // 2, len(pane.across) + BAND_PX // 2, BAND_PX), len(pane.across) - 1)
        extents = [pane.across, pane.along / ROWS, pane.blur_px, pane.blur_px / ROWS]
        self._bands = 8.0 * np.array(extents)[:, middles]  # extents of 1 mm and of the blur disc, 1/8 px of the planes

    def shape(self, drops: Drops) -> None:
        """Set how drops are drawn: their centre on the planes and their stamp."""
        bands = self._bands[:, self._pane.row(drops["y"]) // BAND_PX]
        steps = np.rint(np.log(drops["size"] / SMALLEST_MM) / np.log(SIZE_STEP))
        bands[:2] *= FOOTPRINT * SMALLEST_MM * SIZE_STEP**steps
        drops["column"], drops["row"] = np.rint(drops["x"]), np.rint((drops["y"] - (ROWS - 1) / 2) / ROWS)
        for name, extent in zip(EXTENTS, np.maximum(np.rint(bands), 1), strict=True):
            drops[name] = extent
        drops["rx"] = (drops["width"] + drops["blur"]) // 16 + 2
        drops["ry"] = (drops["height"] + drops["blur_y"]) // 16 + 2

    def put(self, drops: Drops, box: Box | None = None) -> None:
        """Draw drops, clipped to a box."""
        if not self.drawing:
            return
        box = box or self.planes.whole
        for column, row, width, height, blur, blur_y, variant in drops[DRAWN].tolist():
            outline = variant if width > 2 * blur else 0
            image = stamp((width, height), (blur, blur_y), outline, self.planes.scene, self.planes.stride)
            self.planes.put(image, column, row, box)

    def wipe(self, mask: Image) -> None:
        """Clear water where a mask of the planes is 255."""
        if self.drawing:
            self.planes.wipe(mask)

    def replace(self, gone: Drops, drops: Drops) -> None:
        """Erase the drops `gone` and draw those of `drops` that overlap them again."""
        if not self.drawing:
            return
        for drop in gone:
            box = self._box(drop)
            self.planes.clear(box)
            beside = (drops["column"] + drops["rx"] < box[0]) | (drops["column"] - drops["rx"] > box[2])
            beyond = (drops["row"] + drops["ry"] < box[1]) | (drops["row"] - drops["ry"] > box[3])
            self.put(drops[~(beside | beyond)], box)

    def _box(self, drop: np.void) -> Box:
        """The bounding box of a drop on the planes."""
        column, row, rx, ry = (int(drop[name]) for name in (*PLACE, "rx", "ry"))
        height, width = self.planes.shape
        x0, x1, y0, y1 = column - rx, column + rx + 1, row - ry, row + ry + 1
        return max(x0, 0), max(y0, 0), max(min(x1, width), 0), max(min(y1, height), 0)
