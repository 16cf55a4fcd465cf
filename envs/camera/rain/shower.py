"""The distribution of visible raindrops over sizes, depths and image cells."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vpf_sim.types import Camera, Floats

CLASS_MM = np.float32(0.2)  # width of a size class
DIAMETERS_MM = np.arange(0.3, 6.0, 0.2)  # lower bound of each class
CELLS = (16, 12)  # image cells, columns and rows
NEAREST_M = 0.6  # no rain nearer than the windscreen

Singles = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Shower:
    """Strata of drops: one size class in one image cell, out to the visible range of its largest and slowest drop."""

    expected: float  # number of drops over all strata
    strata: NDArray[np.uint16]  # (65536,) stratum indices in proportion to their drops
    diameter_mm: Singles  # (strata,) lower bound of the class
    corners_px: Singles  # (2, strata) corner of the cell
    farthest_m3: Singles  # (strata,) cube of the largest depth


def drops_per_m3_mm(rain_mmph: float, diameter_mm: Floats) -> Floats:
    """N(D) = 8000 exp(-4.1 R^-0.21 D), drops per m3 and mm of diameter (Marshall and Palmer 1948, J. Meteor. 5:165)."""
    return np.asarray(8000.0 * np.exp(-4.1 * rain_mmph**-0.21 * diameter_mm))


def fall_speed_mps(diameter_mm: Singles) -> Singles:
    """v(D) = 9.65 - 10.3 exp(-0.6 D) (Atlas, Srivastava and Sekhon 1973, doi 10.1029/RG011i001p00001)."""
    speed = np.float32(9.65) - np.float32(10.3) * np.exp(np.float32(-0.6) * diameter_mm)
    return np.asarray(np.maximum(speed, np.float32(0.1)), np.float32)


def shower(
    camera: Camera, rain_mmph: float, motion: tuple[Floats, Floats], exposure_s: float, faintest: float
) -> Shower:
    """The drops with an opacity of at least `faintest`.

    `motion` is (drift, down) in camera axes: drops of fall speed v move at drift + v down. A drop of
    diameter D whose image moves by g / z per second is w = f D / z wide and l = g T / z long. Its opacity,
    (pi / 4) w^2 / max(1, l), falls to `faintest` at
    z = min(f D sqrt(pi / 4 / faintest), (pi / 4) f^2 D^2 / (g T faintest)).
    """
    across, down = (np.arange(n) * size / n for n, size in zip(CELLS, (camera.width_px, camera.height_px), strict=True))
    corners = np.stack([a.ravel() for a in np.meshgrid(across, down)])  # (2, cells)
    largest_m = 1e-3 * (DIAMETERS_MM + float(CLASS_MM))[:, None]
    image_speed = _slowest(camera, motion, corners)
    width = camera.fx_px * largest_m  # at a depth of 1 m
    farthest = np.minimum(
        width * np.sqrt(0.25 * np.pi / faintest),
        0.25 * np.pi * width**2 / np.maximum(image_speed * exposure_s * faintest, 1e-9),
    )
    farthest = np.maximum(farthest, NEAREST_M)
    area_px = camera.width_px * camera.height_px / (CELLS[0] * CELLS[1])
    volume_m3 = (farthest**3 - NEAREST_M**3) / 3.0 * area_px / (camera.fx_px * camera.fy_px)
    density = _per_class(rain_mmph)[:, None]
    expected = (density * volume_m3).ravel()
    total = float(expected.sum())
    edges = np.rint(np.cumsum(expected) / max(total, 1e-9) * 65536.0).astype(int)
    strata = np.repeat(np.arange(len(expected)), np.diff(edges, prepend=0))
    classes, cells = np.divmod(np.arange(len(expected)), corners.shape[1])
    return Shower(
        total,
        np.resize(strata, 65536).astype(np.uint16) if total > 0.0 else np.zeros(65536, np.uint16),
        DIAMETERS_MM[classes].astype(np.float32),
        corners[:, cells].astype(np.float32),
        (farthest**3).ravel().astype(np.float32),
    )


def _per_class(rain_mmph: float) -> Floats:
    """(classes,) drops per m3 of each class."""
    middle = DIAMETERS_MM + 0.5 * float(CLASS_MM)
    return drops_per_m3_mm(rain_mmph, middle) * float(CLASS_MM)


def _slowest(camera: Camera, motion: tuple[Floats, Floats], corners: Floats) -> Floats:
    """(classes, cells) px m/s, a lower bound of image speed times depth."""
    drift, down = motion
    size = np.array([camera.width_px / CELLS[0], camera.height_px / CELLS[1]])
    x, y = corners + 0.5 * size[:, None] - np.array([[camera.cx_px], [camera.cy_px]])
    ends = DIAMETERS_MM[:, None] + float(CLASS_MM) * np.array([0.0, 0.5, 1.0])
    fall = fall_speed_mps(ends.astype(np.float32))[..., None].astype(float)
    speed = drift + fall[..., None] * down  # (classes, 3, 1, 3)
    across = camera.fx_px * speed[..., 0] - x * speed[..., 2]
    along = camera.fy_px * speed[..., 1] - y * speed[..., 2]
    slack = 0.5 * np.hypot(*size) * np.abs(speed[..., 2]).max()
    return np.asarray(np.maximum(np.hypot(across, along).min(axis=1) - slack, 0.0))
