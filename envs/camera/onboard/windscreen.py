"""Dirt on the windscreen, and the dashboard's reflection in it: both stay where they are in the picture."""

import cv2
import numpy as np

from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.rig import Rig
from vpf_sim.envs.camera.texture import noise
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Image

TEXELS = (240, 320)  # of the noise, rows and columns over the picture
STAIN_TEXELS, SOFT = 7.0, 0.35  # size of stains, and softness of their edges in standard deviations
OPAQUE = 0.75  # opacity of a stain's middle
DIRT = np.array([0.62, 0.58, 0.5])  # of the horizon's light
VENTS = 7  # bright bands of a dashboard


class Windscreen:
    """Stains that cover a share `dirt` of the picture, and light of the dashboard, `reflection` of full brightness."""

    def __init__(self, rig: Rig, light: Light, seed: int) -> None:
        size = (rig.camera.width_px, rig.camera.height_px)
        rng = stream(seed, "windscreen")
        alpha = np.rint(255.0 * cv2.resize(_stains(rig.dirt, rng), size)).astype(np.uint8)
        self._alpha = cv2.cvtColor(alpha, cv2.COLOR_GRAY2RGB)
        self._through = cv2.bitwise_not(self._alpha)
        dirt = np.broadcast_to(np.clip(DIRT * light.horizon, 0.0, 255.0), self._alpha.shape).astype(np.uint8)
        self._dirt = cv2.multiply(dirt, self._alpha, scale=1 / 255) if rig.dirt > 0.0 else None
        glare = cv2.resize(_dashboard(rng), size) * rig.reflection * float(light.horizon.mean())
        light_added = np.rint(glare).astype(np.uint8)
        self._glare = cv2.cvtColor(light_added, cv2.COLOR_GRAY2RGB) if rig.reflection > 0.0 else None

    def draw(self, frame: Image) -> None:
        """Draw both over the frame, in place."""
        if self._dirt is not None:
            cv2.multiply(frame, self._through, frame, scale=1 / 255)
            cv2.add(frame, self._dirt, frame)
        if self._glare is not None:
            cv2.add(frame, self._glare, frame)

    def hidden(self) -> Bools:
        """(H, W) where dirt hides more than half of the scene."""
        return np.asarray(self._alpha)[..., 0] > 127


def _stains(share: float, rng: np.random.Generator) -> Image:
    """TEXELS opacity 0 to 1: soft stains that cover a share of the picture."""
    field = noise(TEXELS, rng, STAIN_TEXELS, 0.6)
    level = float(np.quantile(field, 1.0 - share)) if share > 0.0 else np.inf
    return np.asarray(OPAQUE * np.clip((field - level) / SOFT + 0.5, 0.0, 1.0), np.float32)


def _dashboard(rng: np.random.Generator) -> Image:
    """TEXELS brightness 0 to 1: a ledge with vents in the lower half, out of focus."""
    rows, columns = np.mgrid[0 : TEXELS[0], 0 : TEXELS[1]] / np.array(TEXELS)[:, None, None]
    ledge = np.clip((rows - 0.5) / 0.25, 0.0, 1.0)
    places = rng.uniform(0.0, 1.0, VENTS)
    vents = sum(np.exp(-(((columns - place) / 0.03) ** 2) - ((rows - 0.72) / 0.05) ** 2) for place in places)
    cloth = 0.15 * noise(TEXELS, rng, 5.0, 1.0)
    return np.asarray(np.clip(ledge * (0.55 + cloth) + 0.6 * vents, 0.0, 1.0), np.float32)
