"""Spray behind moving objects on a wet road."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.painter import Sprite
from vpf_sim.envs.camera.rain.mirror import erase
from vpf_sim.envs.camera.scenery.objects import object_size
from vpf_sim.envs.camera.snapshot import Snapshot
from vpf_sim.envs.camera.texture import noise
from vpf_sim.envs.camera.truth import Drawn
from vpf_sim.envs.camera.view import View
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Camera, Floats, Image

SLOWEST_MPS, FULL_MPS = 4.0, 11.0  # speeds at which spray starts and is full, 40 km/h
PUFFS = 3  # per object at a time
LIFE_S = 0.9  # of a puff
OPACITY = 0.95  # of a dense puff in its middle
NEAREST_M, RANGE_M = 2.5, 70.0  # depths between which puffs are drawn
SIZE = 48  # pixels of a puff's image, each way
VARIANTS = 6
LIT_BY_LAMPS = 60.0  # grey levels of puffs in the dark, between the lamps of two vehicles
CYCLES = 1024  # random cycles before they repeat, 15 minutes


@dataclass(frozen=True, slots=True)
class Puff(Sprite):
    """A puff in the image."""


class Spray:
    """Soft puffs behind moving objects.

    Puffs leave the wheels one after the other, move at half the object's speed, widen and fade. The plume is as wide as
    the object and about half as high.
    """

    def __init__(self, camera: Camera, atmosphere: Atmosphere, light: Light, seed: int) -> None:
        self._camera = camera
        self._strength = OPACITY * min(1.0, max(atmosphere.wetness, atmosphere.puddles))
        self._colour = np.maximum(light.horizon, LIT_BY_LAMPS) if light.has_lamps else light.horizon
        self._chances = stream(seed, "spray").random((CYCLES, 4))
        self._drawn: list[Drawn] = []

    def added(self, drawn: list[Drawn], now: Snapshot, before: Snapshot) -> list[Drawn]:
        """The items in painter's order with the puffs inserted."""
        self._drawn = drawn
        gap_s = now.time_s - before.time_s
        if self._strength <= 0.0 or gap_s <= 0.0:
            return drawn
        self._drawn = []
        for item in drawn:
            behind, before_it = self._puffs(item.instance - 1, now, before, gap_s) if item.instance > 0 else ([], [])
            self._drawn += [*behind, item, *before_it]
        return self._drawn

    def hidden(self) -> Bools:
        """(H, W) where spray hides more than half of the scene in the last frame."""
        mask = np.zeros((self._camera.height_px, self._camera.width_px), np.uint8)
        for item in self._drawn:
            drawing = item.drawing
            if isinstance(drawing, Puff):
                height, width = drawing.through.shape[:2]
                mask[drawing.y : drawing.y + height, drawing.x : drawing.x + width] |= drawing.through[..., 0] < 128
            else:
                erase(mask, drawing)
        return mask.astype(bool)

    def _puffs(self, index: int, now: Snapshot, before: Snapshot, gap_s: float) -> tuple[list[Drawn], list[Drawn]]:
        """An object's puffs: those farther than it, and those nearer."""
        obj = now.objects[index]
        pose = now.poses[obj]
        speed = float(np.hypot(*(pose - before.poses.get(obj, pose))[:2])) / gap_s
        strength = self._strength * min(1.0, (speed - SLOWEST_MPS) / (FULL_MPS - SLOWEST_MPS))
        if strength <= 0.0:
            return [], []
        length, width, height = object_size(obj)
        direction = np.array([np.cos(pose[2]), np.sin(pose[2])])
        axis, eye = now.view.axes[2, :2], now.view.centre[:2]
        middle_m = float(axis @ (pose[:2] - eye))
        farther: list[Drawn] = []
        nearer: list[Drawn] = []
        for place in range(PUFFS):
            cycle, age = divmod(now.time_s / LIFE_S + place / PUFFS + 0.37 * index, 1.0)
            chance = self._chances[(int(cycle) * PUFFS + place + 101 * index) % CYCLES]
            foot = pose[:2] - direction * (0.45 * length + 0.5 * speed * LIFE_S * age)
            size = (width * (0.9 + 0.5 * age), (0.5 * height + 0.3) * (0.6 + 0.8 * age) * (0.8 + 0.4 * chance[1]))
            opacity = strength * min(1.0, 6.0 * age) * (1.0 - age) ** 0.7 * (0.7 + 0.6 * chance[2])
            puff = self._puff(now.view, foot, size, opacity, int(chance[3] * VARIANTS))
            if puff is not None:
                (farther if puff.depth_m > middle_m else nearer).append(Drawn(puff, -1))
        farther.sort(key=_nearness)
        nearer.sort(key=_nearness)
        return farther, nearer

    def _puff(self, view: View, foot: Floats, size_m: tuple[float, float], opacity: float, variant: int) -> Puff | None:
        """A puff on the road at a world point (2,); None outside the image."""
        camera = self._camera
        right, down, depth = (view.axes @ (np.array([*foot, 0.0]) - view.centre)).tolist()
        if not NEAREST_M < depth < RANGE_M:
            return None
        wide, tall = camera.fx_px * size_m[0] / depth, camera.fy_px * size_m[1] / depth
        left = camera.cx_px + camera.fx_px * right / depth - 0.5 * wide
        top = camera.cy_px + camera.fy_px * down / depth - tall
        x0, y0 = max(0, int(left)), max(0, int(top))
        x1, y1 = min(camera.width_px, int(left + wide) + 1), min(camera.height_px, int(top + tall) + 1)
        if x0 >= x1 or y0 >= y1:
            return None
        opacity *= min(1.0, (depth - NEAREST_M) / NEAREST_M)
        place = np.array([[wide / SIZE, 0.0, left - x0], [0.0, tall / SIZE, top - y0]])
        alpha = cv2.warpAffine(puff_picture(variant), place, (x1 - x0, y1 - y0))
        colours = [cv2.convertScaleAbs(alpha, alpha=opacity / 255.0 * c) for c in self._colour.tolist()]
        picture = cv2.merge([*colours, cv2.convertScaleAbs(alpha, alpha=-opacity, beta=255.0)])
        return Puff(x0, y0, np.asarray(picture, np.uint8), depth)


def _nearness(item: Drawn) -> float:
    drawing = item.drawing
    return -drawing.depth_m if isinstance(drawing, Sprite) else 0.0


@lru_cache(maxsize=VARIANTS)
def puff_picture(variant: int) -> Image:
    """(SIZE, SIZE) opacity of a puff, 0..255: dense at the foot, soft elsewhere."""
    rng = stream(0, f"puff {variant}")
    y, x = (np.mgrid[0:SIZE, 0:SIZE] + 0.5) / SIZE
    billows = noise((SIZE, SIZE), rng, 5.0, 1.2)
    obj = np.exp(-(((x - 0.5) / 0.24) ** 2) - ((y - 0.78) / 0.32) ** 2 * np.where(y < 0.78, 1.0, 3.0))
    edge = np.clip(8.0 * np.minimum.reduce([x, 1.0 - x, y, 1.0 - y]), 0.0, 1.0)
    return np.asarray(np.clip(255.0 * (1.0 - np.exp(-2.2 * obj * (1.0 + 0.35 * billows))) * edge, 0, 255), np.uint8)
