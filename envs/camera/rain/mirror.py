"""Reflections on flat water: faces and billboards mirrored about the road."""

from dataclasses import dataclass
from typing import TypeGuard

import cv2
import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.night.glow import Glow
from vpf_sim.envs.camera.painter import SHIFT, Drawing, Sprite
from vpf_sim.envs.camera.truth import Drawn
from vpf_sim.envs.camera.view import View
from vpf_sim.geometry import horizon_px, road_row_px
from vpf_sim.types import Floats, Image

REFINEMENT = 2  # image pixels per pixel of the reflection, each way
FACES, SPRITES = 18, 5  # most faces and sprites that are mirrored
FADED = 64.0  # of 255; more transparent faces are not mirrored
BODIES_FIRST = 4.0  # weight of the area of an object's face over scenery
LARGE_PX = 150  # least area of a mirrored item's bounding box
SMALLEST_PX = 20.0  # least area of a mirrored face
SPRITE_TALL_PX = 30
FOOT_M = 0.4  # height of an object's foot
FOOT_SHARE = 0.3  # share of the way from the foot to the horizon that the object covers for sure
WATER_INDEX = 1.333


@dataclass(frozen=True, slots=True)
class MirroredFaces:
    """Mirrored faces in painter's order."""

    points_px: Floats  # (n, 2) vertices, face by face
    corners: list[int]  # vertices per face
    colours: list[list[float]]


NO_FACES = MirroredFaces(np.empty((0, 2)), [], [])


def reflectance(sine: Floats) -> Floats:
    """Fresnel reflectance of water for unpolarised light, by the sine of the grazing angle."""
    refracted = np.sqrt(1.0 - (1.0 - sine**2) / WATER_INDEX**2)  # cosine of the angle of refraction
    across = (sine - WATER_INDEX * refracted) / (sine + WATER_INDEX * refracted)
    along = (WATER_INDEX * sine - refracted) / (WATER_INDEX * sine + refracted)
    return np.asarray(0.5 * (across**2 + along**2))


def mirrored_points(view: View, points_px: Floats, planes: Floats) -> tuple[Floats, Floats]:
    """(n, 2) px, mirror images of points (n, 2) px, and (n,) m, heights of the points above the road.

    `planes` (n, 3) give the inverse depths w = plane . ray. The point is ray / w in camera axes; mirrored
    about the road it is ray / w - 2 z up, where z = camera height + ray . up / w is its height.
    """
    camera, up = view.camera, view.axes[:, 2].tolist()
    right, down = (points_px[:, 0] - camera.cx_px) / camera.fx_px, (points_px[:, 1] - camera.cy_px) / camera.fy_px
    inverse_depth = planes[:, 0] * right + planes[:, 1] * down + planes[:, 2]
    lift = camera.height_m * inverse_depth + up[0] * right + up[1] * down + up[2]  # z w
    depth = 1.0 - 2.0 * up[2] * lift
    image = np.empty_like(points_px)
    image[:, 0] = camera.cx_px + camera.fx_px * (right - 2.0 * up[0] * lift) / depth
    image[:, 1] = camera.cy_px + camera.fy_px * (down - 2.0 * up[1] * lift) / depth
    return image, lift / inverse_depth


def mirrored_faces(view: View, drawn: list[Drawn], foot_px: float = 0.0) -> MirroredFaces:
    """The largest faces, mirrored.

    Feet are extended upwards by up to `foot_px`, into the area that the object itself covers. So a blurred reflection
    stays dark at the foot, as on a real road.
    """
    items = [(item.drawing, item.instance) for item in drawn if _large(item.drawing)]
    if not items:
        return NO_FACES
    drawings = [drawing for drawing, _ in items]
    numbers = [len(drawing.planes) for drawing in drawings]
    planes = np.concatenate([drawing.planes for drawing in drawings])
    colours = np.concatenate([drawing.colours for drawing in drawings])
    first = np.concatenate([drawing.polygons_px[:, :3] for drawing in drawings])
    (ax, ay), (bx, by) = (first[:, 1] - first[:, 0]).T, (first[:, 2] - first[:, 0]).T
    area = np.abs(ax * by - ay * bx)  # of the parallelogram of three vertices
    turned_away = 1.0 + 2.0 * view.camera.height_m * (planes @ view.axes[:, 2]) <= 0.0  # from the mirrored camera
    area[turned_away | (colours[:, 3] > FADED)] = 0.0
    area *= np.repeat([BODIES_FIRST if instance > 0 else 1.0 for _, instance in items], numbers)
    shown = np.flatnonzero(area > SMALLEST_PX)
    if len(shown) > FACES:
        shown = np.sort(shown[np.argpartition(-area[shown], FACES)[:FACES]])
    ends = np.cumsum(numbers)
    owners = np.searchsorted(ends, shown, side="right").tolist()
    polygons = [drawings[i].polygons_px[k] for i, k in zip(owners, (shown - ends[owners]).tolist(), strict=True)]
    return _extended(view, polygons, planes[shown], colours[shown].tolist(), foot_px)


def _large(drawing: Drawing | Sprite) -> TypeGuard[Drawing]:
    """Whether a drawing has faces that may be large enough."""
    if isinstance(drawing, Sprite):
        return False
    return any((x1 - x0) * (y1 - y0) > LARGE_PX for x0, y0, x1, y1 in drawing.boxes)


def _extended(
    view: View, polygons: list[Floats], planes: Floats, colours: list[list[float]], foot_px: float
) -> MirroredFaces:
    """Mirrored faces with extended feet."""
    if not polygons:
        return NO_FACES
    corners = [len(polygon) for polygon in polygons]
    image, height = mirrored_points(view, np.concatenate(polygons), np.repeat(planes, corners, axis=0))
    low = height < FOOT_M
    image[low, 1] -= np.minimum(foot_px, FOOT_SHARE * (image[low, 1] - horizon_px(view.camera)))
    return MirroredFaces(image, corners, colours)


def paint_faces(canvas: Image, top: int, faces: MirroredFaces) -> None:
    """Draw mirrored faces on a reduced canvas whose first row is image row `top`."""
    scale = 2.0**SHIFT / REFINEMENT
    corner = np.array([0.5, 0.5 - top]) * scale - 0.5 * 2**SHIFT
    fixed = np.rint(faces.points_px * scale + corner).astype(np.int32)
    start = 0
    for corners, colour in zip(faces.corners, faces.colours, strict=True):
        cv2.fillConvexPoly(canvas, fixed[start : start + corners], colour, cv2.LINE_AA, SHIFT)
        start += corners


def large_sprites(drawn: list[Drawn]) -> list[Sprite]:
    """The largest billboards, in their order; lamps have streaks of their own."""
    sprites = [
        item.drawing for item in drawn if isinstance(item.drawing, Sprite) and not isinstance(item.drawing, Glow)
    ]
    tall = [sprite for sprite in sprites if sprite.picture.shape[0] >= SPRITE_TALL_PX]
    largest = sorted(tall, key=lambda sprite: -sprite.picture.shape[0])[:SPRITES]
    return [sprite for sprite in tall if any(sprite is other for other in largest)]


def paint_sprite(canvas: Image, view: View, top: int, sprite: Sprite) -> None:
    """Draw a billboard upside down below its foot."""
    camera = view.camera
    foot = road_row_px(camera, sprite.depth_m)
    tall, wide = sprite.picture.shape[:2]
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


def erase(mask: Image, drawing: Drawing | Sprite) -> None:
    """Set the pixels of a mask (H, W) that an item covers to 0."""
    if isinstance(drawing, Sprite):
        height, width = drawing.through.shape[:2]
        mask[drawing.y : drawing.y + height, drawing.x : drawing.x + width][drawing.through[..., 0] < 128] = 0
        return
    for polygon in np.rint(drawing.polygons_px * 2**SHIFT).astype(np.int32):
        cv2.fillConvexPoly(mask, polygon, (0,), cv2.LINE_8, SHIFT)
