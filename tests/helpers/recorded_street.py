"""A drive in KITTI's layout whose motion is known: a street of textured planes, seen ray by ray."""

from pathlib import Path

import cv2
import numpy as np

from vpf_sim.seeding import stream
from vpf_sim.types import Floats, Image

WIDTH, HEIGHT, FOCAL = 400, 240, 300.0
CENTRE = (203.0, 110.0)
CAMERA_HEIGHT_M, WALL_M = 1.65, 7.0
RATE_HZ = 10.0


def poses(count: int, speed_mps: float, yaw_rate_radps: float, pitch_rad: float, nod_rad: float) -> Floats:
    """(count, 3, 4) camera to world, KITTI's axes: an arc, by a camera that looks `pitch_rad` down and nods."""
    result, place = [], np.zeros(3)
    for k in range(count):
        yaw = yaw_rate_radps * k / RATE_HZ
        pitch = -pitch_rad + nod_rad * np.sin(1.3 * k)
        turn = _about(1, yaw) @ _about(0, pitch)
        result.append(np.column_stack([turn, place]))
        course = yaw + 0.5 * yaw_rate_radps / RATE_HZ  # the chord to the next place
        place = place + speed_mps / RATE_HZ * np.array([np.sin(course), 0.0, np.cos(course)])
    return np.array(result)


def write(folder: Path, camera_to_world: Floats, images: int) -> None:
    """The drive as files; there may be an image more than poses, as in KITTI's own excerpt."""
    (folder / "image_0").mkdir(parents=True)
    beyond = [camera_to_world[-1]] * (images - len(camera_to_world))
    for k, pose in enumerate([*camera_to_world, *beyond]):
        cv2.imwrite(str(folder / "image_0" / f"{k:06d}.png"), draw(pose))
    projection = [FOCAL, 0, CENTRE[0], 0, 0, FOCAL, CENTRE[1], 0, 0, 0, 1, 0]
    (folder / "calib.txt").write_text("P0: " + " ".join(str(value) for value in projection) + "\n")
    np.savetxt(folder / "poses.txt", camera_to_world.reshape(len(camera_to_world), 12))


def draw(pose: Floats) -> Image:
    """(H, W) grey: the road 1.65 m below the camera, and a wall on each side."""
    columns, rows = np.meshgrid(np.arange(WIDTH, dtype=float), np.arange(HEIGHT, dtype=float))
    rays = np.stack([(columns - CENTRE[0]) / FOCAL, (rows - CENTRE[1]) / FOCAL, np.ones_like(rows)], axis=-1)
    rays = rays @ pose[:, :3].T
    # Axis across the plane, where it lies, and the two axes along it.
    planes = ((1, CAMERA_HEIGHT_M, (0, 2)), (0, -WALL_M, (1, 2)), (0, WALL_M, (1, 2)))
    nearest, frame = np.full(rays.shape[:2], np.inf), np.full(rays.shape[:2], 200.0)
    for index, (axis, place, along) in enumerate(planes):
        with np.errstate(divide="ignore"):
            reach = (place - pose[axis, 3]) / rays[..., axis]
        closer = (reach > 0.0) & (reach < nearest)
        spot = pose[:, 3] + np.where(closer, reach, 0.0)[..., None] * rays
        fade = np.clip(12.0 / np.where(closer, reach, 1.0), 0.0, 1.0)
        texture = _texture(index, spot[..., along[0]], spot[..., along[1]])
        frame = np.where(closer, 110.0 + fade * (texture - 128.0), frame)
        nearest = np.where(closer, reach, nearest)
    return np.clip(frame, 0.0, 255.0).astype(np.uint8)


def _texture(index: int, first_m: Floats, second_m: Floats) -> Floats:
    noise = stream(index, "street").normal(0.0, 1.0, (512, 512)).astype(np.float32)
    smooth = cv2.GaussianBlur(noise, (0, 0), 2.0, borderType=cv2.BORDER_REFLECT)
    tile = 128.0 + 40.0 * smooth / smooth.std()
    texel = [np.mod(values / 0.12, 511.0).astype(np.float32) for values in (first_m, second_m)]
    return np.asarray(cv2.remap(tile, texel[0], texel[1], cv2.INTER_LINEAR), float)


def _about(axis: int, angle: float) -> Floats:
    turn, _ = cv2.Rodrigues(np.eye(3)[axis] * angle)
    return np.asarray(turn, float)
