"""The colours of the ground: one ramp from dark grass over gravel and asphalt to white paint."""

import numpy as np
from numpy.typing import NDArray

# (value, red, green, blue)
RAMP = np.array(
    [
        (0, 20, 26, 10),
        (25, 34, 46, 18),
        (45, 86, 100, 48),
        (60, 134, 138, 80),
        (80, 140, 134, 98),
        (98, 128, 121, 103),
        (124, 104, 102, 97),
        (138, 92, 92, 93),
        (150, 106, 106, 107),
        (200, 166, 166, 165),
        (222, 214, 213, 208),
        (240, 244, 243, 238),
        (255, 250, 249, 245),
    ],
    float,
)


def ground_table() -> NDArray[np.uint8]:
    """(256, 1, 3) RGB of each palette value, for cv2.applyColorMap."""
    values = np.arange(256)
    channels = [np.interp(values, RAMP[:, 0], RAMP[:, i]) for i in (1, 2, 3)]
    table: NDArray[np.uint8] = np.rint(np.stack(channels, axis=1)[:, None, :]).astype(np.uint8)
    return table
