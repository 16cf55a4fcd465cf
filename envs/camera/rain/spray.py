"""What puffs of spray behind moving objects look like; the core places and draws them."""

from functools import lru_cache

import numpy as np

from vpf_sim.envs.camera.texture import noise
from vpf_sim.seeding import stream
from vpf_sim.types import Image

OPACITY = 0.95  # of a dense puff in its middle
SIZE = 48  # pixels of a puff's image, each way
VARIANTS = 6
LIT_BY_LAMPS = 60.0  # grey levels of puffs in the dark, between the lamps of two vehicles


@lru_cache(maxsize=VARIANTS)
def puff_picture(variant: int) -> Image:
    """(SIZE, SIZE) opacity of a puff, 0..255: dense at the foot, soft elsewhere."""
    rng = stream(0, f"puff {variant}")
    y, x = (np.mgrid[0:SIZE, 0:SIZE] + 0.5) / SIZE
    billows = noise((SIZE, SIZE), rng, 5.0, 1.2)
    obj = np.exp(-(((x - 0.5) / 0.24) ** 2) - ((y - 0.78) / 0.32) ** 2 * np.where(y < 0.78, 1.0, 3.0))
    edge = np.clip(8.0 * np.minimum.reduce([x, 1.0 - x, y, 1.0 - y]), 0.0, 1.0)
    return np.asarray(np.clip(255.0 * (1.0 - np.exp(-2.2 * obj * (1.0 + 0.35 * billows))) * edge, 0, 255), np.uint8)
