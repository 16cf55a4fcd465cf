"""Everything at infinity: sky, clouds and hills, on a cylinder that turns with the yaw."""

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.grain import ground_top
from vpf_sim.envs.camera.texture import noise
from vpf_sim.envs.camera.view import View
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image

COLUMNS = 2560  # of the panorama, one turn
HILL_TOP = 0.10  # tangent of the elevation that no hill reaches
ZENITH_SLOPE = 1.2  # tangent of the elevation above which the sky keeps its colour
CLOUD_COLUMNS = 1024
COARSE = 4  # clouds are soft: they are drawn on every fourth pixel
ZENITH, HORIZON = np.array([92.0, 136.0, 198.0]), np.array([206.0, 219.0, 231.0])
HILLS = (  # (tangent of the height, share of haze, RGB near), from far to near
    (0.060, 0.72, (84, 100, 110)),
    (0.036, 0.45, (74, 92, 72)),
    (0.020, 0.15, (52, 70, 38)),
)


class Sky:
    """Paints every row above the horizon."""

    def __init__(self, camera: Camera, seed: int) -> None:
        self._top = ground_top(camera)
        self._camera = camera
        rng = stream(seed, "sky")
        rays = _rays(camera, self._top)
        turn, slope = np.arctan2(rays[..., 0], rays[..., 2]), rays[..., 1] / np.hypot(rays[..., 0], rays[..., 2])
        self._band = int(np.argmax((slope < HILL_TOP).any(axis=1))) if self._top else 0
        tall = float(slope[self._band :].max()) if self._top else HILL_TOP
        self._hills = _hills(rng, tall)
        per_rad = COLUMNS / (2.0 * np.pi)
        rows = len(self._hills) - 1
        self._column = (turn[self._band :] * per_rad).astype(np.float32)
        self._row = np.clip(rows * (1.0 - slope[self._band :] / tall), 0, rows).astype(np.float32)
        self._clouds = _clouds(rng, tall)
        coarse = slice(None, None, COARSE)
        self._cloud_column = (turn[coarse, coarse] * CLOUD_COLUMNS / (2.0 * np.pi)).astype(np.float32)
        cloud_rows = len(self._clouds) - 1
        self._cloud_row = np.clip(cloud_rows * (1.0 - slope[coarse, coarse] / ZENITH_SLOPE), 0, cloud_rows).astype(
            np.float32
        )

    def draw(self, view: View, frame: Image) -> None:
        """Paint the sky into the picture."""
        if self._top == 0:
            return
        yaw = float(np.mod(view.yaw_rad, 2.0 * np.pi)) / (2.0 * np.pi)
        coarse = cv2.remap(
            self._clouds,
            self._cloud_column + np.float32(yaw * CLOUD_COLUMNS + 0.5 * CLOUD_COLUMNS),
            self._cloud_row,
            cv2.INTER_LINEAR,
        )
        cv2.resize(coarse, (self._camera.width_px, self._top), frame[: self._top])
        cv2.remap(
            self._hills,
            self._column + np.float32(yaw * COLUMNS + 0.5 * COLUMNS),
            self._row,
            cv2.INTER_LINEAR,
            frame[self._band : self._top],
        )


def _rays(camera: Camera, rows: int) -> Floats:
    """(rows, W, 3) right, up, forward of each pixel's ray, levelled."""
    x = (np.arange(camera.width_px) - camera.cx_px) / camera.fx_px
    y = (np.arange(rows) - camera.cy_px) / camera.fy_px
    right, down = np.meshgrid(x, y)
    c, s = np.cos(camera.pitch_rad), np.sin(camera.pitch_rad)
    return np.stack([right, -(c * down + s), c - s * down], axis=-1)


def _gradient(slope: Floats) -> Floats:
    """(..., 3) colour of the clear sky at tangents of elevation."""
    share = np.clip(slope, 0.0, ZENITH_SLOPE)[..., None] / ZENITH_SLOPE
    return np.asarray(HORIZON + (ZENITH - HORIZON) * share**0.7)


def _doubled(panorama: Floats) -> NDArray[np.uint8]:
    """One turn, with one more turn behind it for what lies across the seam."""
    turn = np.clip(np.rint(panorama), 0, 255).astype(np.uint8)
    return np.ascontiguousarray(np.concatenate([turn, turn, turn[:, : turn.shape[1] // 4]], axis=1))


def _clouds(rng: np.random.Generator, low: float) -> NDArray[np.uint8]:
    """The sky with a few thin clouds above the tangent of elevation `low`, from ZENITH_SLOPE down to 0."""
    rows = 192
    slope = np.linspace(ZENITH_SLOPE, 0.0, rows)[:, None] * np.ones((1, CLOUD_COLUMNS))
    field = noise((256, CLOUD_COLUMNS), rng, 6.0, 1.5)[:rows]
    cover = (np.clip((field - 1.0) / 2.5, 0.0, 0.7) * np.clip((slope - low) / 0.3, 0.0, 1.0))[..., None]
    sky = _gradient(slope)
    return _doubled(sky + (np.array([246.0, 248.0, 250.0]) - sky) * cover)


def _hills(rng: np.random.Generator, tall: float) -> NDArray[np.uint8]:
    """Ranges of hills before the sky, from the tangent of elevation `tall` down to 0."""
    rows = int(tall * 400)
    slope = np.linspace(tall, 0.0, rows)[:, None] * np.ones((1, COLUMNS))
    picture = _gradient(slope)
    for index, (height, haze, colour) in enumerate(HILLS):
        outline = noise((1, COLUMNS), rng, 10.0 if index < 2 else 3.0, 1.6 if index < 2 else 1.0)[0]
        top = height * np.clip(0.65 + 0.22 * outline, 0.15, 1.4)
        cover = np.clip((top[None, :] - slope) / (tall / rows), 0.0, 1.0)[..., None]
        texture = noise((128, COLUMNS), rng, 3.0, 0.5)[:rows, :, None] * (1.0 - haze) * 16.0
        tone = np.array(colour, float) + texture
        picture += cover * (tone + haze * (HORIZON - 12.0 - tone) - picture)
    return _doubled(picture)
