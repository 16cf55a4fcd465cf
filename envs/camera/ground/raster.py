"""A raster of the ground and its mapping to the world."""

from dataclasses import dataclass

import numpy as np

from vpf_sim.types import Floats


@dataclass(frozen=True, slots=True)
class Raster:
    """Texels mapped to the ground by a homography."""

    rows: int
    columns: int
    from_world: Floats  # (3, 3) from points (x, y, 1) m to homogeneous (column, row) of texel centres
    across_m: float  # size of the smallest texel, as along_m
    along_m: float

    def finer(self, fine_x: float, fine_y: float) -> Floats:
        """(3, 3) `from_world` for a finer raster."""
        scale = np.array([[fine_x, 0.0, 0.5 * fine_x - 0.5], [0.0, fine_y, 0.5 * fine_y - 0.5], [0.0, 0.0, 1.0]])
        return np.asarray(scale @ self.from_world)

    def lengths(self) -> Floats:
        """(rows, 1) m, length of each row's middle texel."""
        rows = np.arange(-1.0, self.rows + 1.0)
        texels = np.stack([np.full(len(rows), 0.5 * self.columns), rows, np.ones(len(rows))], axis=1)
        world = _flat(texels @ np.linalg.inv(self.from_world).T)
        return np.asarray(0.5 * np.hypot(*(world[2:] - world[:-2]).T)[:, None])

    def outline(self) -> Floats:
        """(4, 2) m, corners in the world, in order around the raster."""
        columns, rows = np.array([-0.5, self.columns - 0.5]), np.array([-0.5, self.rows - 0.5])
        corners = np.stack([columns[[0, 0, 1, 1]], rows[[0, 1, 1, 0]], np.ones(4)], axis=1)
        return _flat(corners @ np.linalg.inv(self.from_world).T)


def _flat(points: Floats) -> Floats:
    return np.asarray(points[:, :2] / points[:, 2:])
