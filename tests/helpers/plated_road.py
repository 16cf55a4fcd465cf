"""Drawn frames of an asphalt road with a plate on, in or under it."""

from functools import cache, lru_cache

import cv2
import numpy as np

from vpf_sim.geometry import ground_from_pixels
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image

CAMERA = Camera()
PLATE_M = np.array([[30.0, -0.2], [31.2, 0.6]])  # its near left and far right corner in the world
GRAIN = stream(31, "asphalt").normal(0.0, 100.0, (1200, 320))
ROAD = (95.0 + cv2.GaussianBlur(GRAIN, (0, 0), 3.0, sigmaY=14.0)).astype(np.float32)  # a cell is 5 cm
TOP_ROW, BOTTOM_ROW = 250, 340  # of the part of the frame that is drawn: the road from 43 to 4.5 m before the camera
SHARP = 4  # rows and columns drawn for one of the frame, and averaged as a pixel does


@cache
def _ground() -> tuple[Floats, Floats]:
    """(rows, columns) m forward and right, the places on the road of the pixels drawn, in the axes of the vehicle."""
    rows_px = TOP_ROW + (np.arange(SHARP * (BOTTOM_ROW - TOP_ROW)) + 0.5) / SHARP - 0.5
    columns_px = (np.arange(SHARP * CAMERA.width_px) + 0.5) / SHARP - 0.5
    columns, rows = np.meshgrid(columns_px, rows_px)
    ground = ground_from_pixels(CAMERA, np.stack([columns, rows], axis=-1).astype(float))
    return np.ascontiguousarray(ground[..., 0]), np.ascontiguousarray(ground[..., 1])


@lru_cache(maxsize=512)
def frame(
    forward_m: float,
    height_m: float,
    aside_m: float = 0.0,
    yaw_rad: float = 0.0,
    plate_level: float = 160.0,
    dash_m: float = 0.0,
) -> Image:
    """What the camera of a car at (`forward_m`, `aside_m`) sees: asphalt, and a plate at `height_m`; with a painted
    dash so long that ends beneath it."""
    cosine, sine = np.cos(yaw_rad), np.sin(yaw_rad)

    def in_world(ahead: Floats, right: Floats) -> tuple[Floats, Floats]:
        return forward_m + cosine * ahead - sine * right, aside_m + sine * ahead + cosine * right

    ahead, right = _ground()
    x, y = in_world(ahead, right)
    columns, rows = ((y + 8.0) / 0.05).astype(np.float32), (x / 0.05).astype(np.float32)
    road = cv2.remap(ROAD, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    if dash_m > 0.0:
        painted = (np.abs(y - PLATE_M[:, 1].mean()) < 0.08) & (np.abs(PLATE_M[0, 0] - x) < dash_m)
        road = np.where(painted, 215.0, road)
    nearer = (CAMERA.height_m - height_m) / CAMERA.height_m  # the plate than the road behind it
    x, y = in_world(CAMERA.forward_m + nearer * (ahead - CAMERA.forward_m), nearer * right)
    (near_m, left_m), (far_m, right_m) = PLATE_M
    inside = (x > near_m) & (x < far_m) & (y > left_m) & (y < right_m)
    image = np.full((CAMERA.height_px, CAMERA.width_px), 100, np.uint8)
    drawn = np.where(inside, plate_level, road).reshape(BOTTOM_ROW - TOP_ROW, SHARP, -1, SHARP).mean(axis=(1, 3))
    noise = stream(32, f"noise {forward_m}").normal(0.0, 1.5, drawn.shape)
    image[TOP_ROW:BOTTOM_ROW] = np.clip(drawn + noise, 0, 255)
    return image
