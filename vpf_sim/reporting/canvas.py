"""Drawing on a frame: anti-aliased strokes, fills, text, and projection of points on the road."""

from dataclasses import dataclass

import cv2
import numpy as np

from vpf_sim.geometry import distort, project
from vpf_sim.types import Camera, Floats, Image

Colour = tuple[int, int, int]  # RGB

SHIFT = 4  # fractional bits of OpenCV's coordinates
FAR_PX = 20000.0
FONT = cv2.FONT_HERSHEY_DUPLEX
INK: Colour = (255, 255, 255)
SHADE: Colour = (16, 20, 24)


@dataclass(slots=True)
class Canvas:
    """Draws on a frame in place; `unit` scales strokes and text, and is 1 for a width of 640 px."""

    frame: Image  # (H, W, 3) RGB
    camera: Camera

    @property
    def unit(self) -> float:
        return float(np.clip(min(self.frame.shape[1] / 640.0, self.frame.shape[0] / 480.0), 0.6, 3.0))

    def stroke_px(self, width: float) -> int:
        """Stroke width in whole pixels, for a `width` on a frame of 640 px."""
        return max(1, round(width * self.unit))

    def lines(self, chains_px: list[Floats], colour: Colour, width: float, closed: bool = False) -> None:
        """Draw (M, 2) polylines; those with points that are not finite are skipped."""
        whole = [_fixed(chain) for chain in chains_px if len(chain) > 1 and np.all(np.isfinite(chain))]
        cv2.polylines(self.frame, whole, closed, colour, self.stroke_px(width), cv2.LINE_AA, SHIFT)

    def fill(self, polygons_px: list[Floats], colour: Colour, opacity: float, top_opacity: float | None = None) -> None:
        """Fill translucent (M, 2) polygons, with one opacity or a vertical gradient."""
        whole = [_fixed(polygon) for polygon in polygons_px if len(polygon) > 2 and np.all(np.isfinite(polygon))]
        if not whole:
            return
        corners = np.concatenate(whole) / (1 << SHIFT)
        height, width = self.frame.shape[:2]
        left, top = np.clip(np.floor(corners.min(axis=0)), 0, [width, height]).astype(int)
        right, bottom = np.clip(np.ceil(corners.max(axis=0)) + 1, 0, [width, height]).astype(int)
        if right <= left or bottom <= top:
            return
        part = self.frame[top:bottom, left:right]
        painted = part.copy()
        shifted = [polygon - np.array([left, top], np.int32) * (1 << SHIFT) for polygon in whole]
        for polygon in shifted:
            cv2.fillPoly(painted, [polygon], colour, cv2.LINE_AA, SHIFT)
        if top_opacity is None:
            cv2.addWeighted(painted, opacity, part, 1.0 - opacity, 0.0, dst=part)
            return
        fade = np.linspace(top_opacity, opacity, bottom - top, dtype=np.float32)[:, None, None]
        part[:] = np.rint(part + fade * (painted.astype(np.float32) - part)).astype(np.uint8)

    def disc(self, centre_px: Floats, radius_px: float, colour: Colour, opacity: float = 1.0) -> None:
        """Fill a circle."""
        angle = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
        self.fill([centre_px + radius_px * np.stack([np.cos(angle), np.sin(angle)], axis=1)], colour, opacity)

    def ring(self, centre_px: Floats, radius_px: float, colour: Colour, width: float) -> None:
        """Draw a circle."""
        angle = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
        ring: Floats = centre_px + radius_px * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        self.lines([ring], colour, width, closed=True)

    def text(self, words: str, left_px: float, base_px: float, colour: Colour = INK, size: float = 0.42) -> None:
        """Draw text on a dark background, its lower left corner at (left, base)."""
        scale, margin = size * self.unit, 3.0 * self.unit
        right, top = left_px + self.text_width_px(words, size), base_px - 24.0 * scale
        bottom = base_px + 7.0 * scale
        plate = [(left_px, top), (right, top), (right, bottom), (left_px, bottom)]
        grown = np.array(plate) + margin * np.array([(-1, -0.5), (1, -0.5), (1, 0.5), (-1, 0.5)])
        self.fill([grown], SHADE, 0.6)
        place = (round(left_px), round(base_px))
        cv2.putText(self.frame, words, place, FONT, scale, colour, self.stroke_px(1), cv2.LINE_AA)

    def text_width_px(self, words: str, size: float = 0.42) -> float:
        return float(cv2.getTextSize(words, FONT, size * self.unit, self.stroke_px(1))[0][0])

    def project(self, points_m: Floats) -> Floats:
        """(..., 2) px of (..., 2) points on the road or (..., 3) above it, vehicle axes; nan behind the camera."""
        if points_m.shape[-1] == 2:
            points_m = np.concatenate([points_m, np.zeros_like(points_m[..., :1])], axis=-1)
        return distort(self.camera, project(self.camera, points_m))


def _fixed(points_px: Floats) -> np.ndarray[tuple[int, ...], np.dtype[np.int32]]:
    return np.rint(np.clip(points_px, -FAR_PX, FAR_PX) * (1 << SHIFT)).astype(np.int32)
