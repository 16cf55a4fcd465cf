"""The world upside down, as flat water on the road shows it: faces and upright pictures mirrored about the road."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.painter import SHIFT, Drawing, Sprite
from vpf_sim.envs.camera.truth import Drawn
from vpf_sim.envs.camera.view import View
from vpf_sim.types import Camera, Floats, Image

REFINEMENT = 2  # pixels of the picture to a pixel of the mirror image, each way
FACES, SPRITES = 40, 6  # only the largest are mirrored
SMALLEST_PX = 40.0  # area of the smallest face that is mirrored
SPRITE_TALL_PX = 30
FOOT_M = 0.4  # what of a body counts as its foot
WATER_INDEX = 1.333


@dataclass(frozen=True, slots=True)
class Faces:
    """Faces as the water shows them, in painter's order."""

    polygons_px: list[Floats]  # (V, 2) each
    colours: list[list[float]]


def reflectance(sine: Floats) -> Floats:
    """Share of unpolarised light that flat water mirrors by the sine of the angle between ray and surface (Fresnel)."""
    refracted = np.sqrt(1.0 - (1.0 - sine**2) / WATER_INDEX**2)  # cosine of the angle of refraction
    across = (sine - WATER_INDEX * refracted) / (sine + WATER_INDEX * refracted)
    along = (WATER_INDEX * sine - refracted) / (WATER_INDEX * sine + refracted)
    return np.asarray(0.5 * (across**2 + along**2))


def mirrored_points(view: View, points_px: Floats, planes: Floats) -> tuple[Floats, Floats]:
    """(n, 2) px where the mirror images of points (n, 2) px appear, and how high above the road the points lie, m.

    `planes` (n, 3) gives each point's inverse depth w = plane . ray. The point is ray / w in camera axes; mirrored
    about the road it is ray / w - 2 z up, where z = camera height + ray . up / w is its height.
    """
    camera, up = view.camera, view.axes[:, 2]
    x = (points_px[:, 0] - camera.cx_px) / camera.fx_px
    y = (points_px[:, 1] - camera.cy_px) / camera.fy_px
    inverse_depth = planes[:, 0] * x + planes[:, 1] * y + planes[:, 2]
    lift = camera.height_m * inverse_depth + up[0] * x + up[1] * y + up[2]  # z w
    depth = 1.0 - 2.0 * up[2] * lift
    image = np.empty_like(points_px)
    image[:, 0] = camera.fx_px * (x - 2.0 * up[0] * lift) / depth + camera.cx_px
    image[:, 1] = camera.fy_px * (y - 2.0 * up[1] * lift) / depth + camera.cy_px
    return image, lift / inverse_depth


def mirrored_faces(view: View, drawn: list[Drawn], foot_px: float = 0.0) -> Faces:
    """The largest faces of things as water shows them.

    The foot of what stands on the road is drawn out upwards by up to `foot_px`, to where the thing itself will cover
    it: so a mirror image keeps its darkness there when it is blurred, as it does on a road, where a ray that leaves it
    flatter than the foot lies does not reach the sky.
    """
    drawings = [thing.drawing for thing in drawn if isinstance(thing.drawing, Drawing)]
    if not drawings:
        return Faces([], [])
    planes = np.concatenate([drawing.planes for drawing in drawings])
    corners = np.concatenate([np.full(len(d.planes), d.polygons_px.shape[1]) for d in drawings])
    points = np.concatenate([drawing.polygons_px.reshape(-1, 2) for drawing in drawings])
    image, height = mirrored_points(view, points, np.repeat(planes, corners, axis=0))
    camera = view.camera
    starts = np.cumsum(corners) - corners
    inside = np.clip(image, 0.0, (camera.width_px, camera.height_px))
    extent = np.maximum.reduceat(inside, starts) - np.minimum.reduceat(inside, starts)
    area = extent[:, 0] * extent[:, 1]
    area[1.0 + 2.0 * camera.height_m * (planes @ view.axes[:, 2]) <= 0.0] = 0.0  # turned away from the mirrored eye
    shown = np.flatnonzero(area > SMALLEST_PX)
    if len(shown) > FACES:
        shown = np.sort(shown[np.argpartition(-area[shown], FACES)[:FACES]])
    low = height < FOOT_M
    image[low, 1] -= np.minimum(foot_px, 0.25 * (image[low, 1] - horizon_row(camera)))
    colours = np.concatenate([drawing.colours for drawing in drawings])[shown].tolist()
    return Faces([image[a : a + n] for a, n in zip(starts[shown], corners[shown], strict=True)], colours)


def paint_faces(canvas: Image, top: int, faces: Faces) -> None:
    """Draw mirrored faces on a canvas of reduced size whose first row is the picture's row `top`."""
    if not faces.polygons_px:
        return
    scale = 2.0**SHIFT / REFINEMENT
    points = (np.concatenate(faces.polygons_px) + np.array([0.5, 0.5 - top])) * scale - 0.5 * 2**SHIFT
    fixed = np.rint(np.clip(points, -30000.0, 30000.0)).astype(np.int32)
    start = 0
    for polygon, colour in zip(faces.polygons_px, faces.colours, strict=True):
        cv2.fillConvexPoly(canvas, fixed[start : start + len(polygon)], colour, cv2.LINE_8, SHIFT)
        start += len(polygon)


def large_sprites(drawn: list[Drawn]) -> list[Sprite]:
    """The largest upright pictures, in their order."""
    sprites = [thing.drawing for thing in drawn if isinstance(thing.drawing, Sprite)]
    tall = [sprite for sprite in sprites if sprite.through.shape[0] >= SPRITE_TALL_PX]
    largest = sorted(tall, key=lambda sprite: -sprite.through.shape[0])[:SPRITES]
    return [sprite for sprite in tall if any(sprite is other for other in largest)]


def paint_sprite(canvas: Image, view: View, top: int, sprite: Sprite) -> None:
    """Draw an upright picture upside down below its foot."""
    camera = view.camera
    foot = horizon_row(camera) + camera.fy_px * camera.height_m / sprite.depth_m
    tall, wide = sprite.through.shape[:2]
    size = (max(1, wide // REFINEMENT), max(1, tall // REFINEMENT))
    y = round((2.0 * foot - (sprite.y + tall) - top) / REFINEMENT)
    x = sprite.x // REFINEMENT
    first, last = max(0, -y), min(size[1], canvas.shape[0] - y)
    width = min(size[0], canvas.shape[1] - x)
    if first >= last or width <= 0:
        return
    region = canvas[y + first : y + last, x : x + width]
    through, colour = (_upside_down(part, size)[first:last, :width] for part in (sprite.through, sprite.colour))
    cv2.multiply(region, through, region, scale=1 / 255)
    cv2.add(region, colour, region)


def _upside_down(picture: Image, size: tuple[int, int]) -> NDArray[np.uint8]:
    return np.asarray(cv2.flip(cv2.resize(picture, size, interpolation=cv2.INTER_NEAREST), 0), np.uint8)


def horizon_row(camera: Camera) -> float:
    """The row of the horizon in the middle of the picture, px."""
    return float(camera.cy_px - camera.fy_px * np.tan(camera.pitch_rad))
