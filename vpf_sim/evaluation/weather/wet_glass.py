"""Scores the detection and removal of water on the windscreen, and its effect on the focus of expansion.

The renderer's windscreen water is added to a dry recording, so that the ground truth behind it is known. A recording
with real water is measured as it is.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

import cv2
import numpy as np

from vpf_sim.envs.camera.glass.glass import Glass
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.scenery.scene import Snapshot
from vpf_sim.envs.camera.view import View
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.evaluation.weather.windscreen_removal import Restoration, WindscreenMask
from vpf_sim.perception.egomotion import focus_of_expansion as expansion
from vpf_sim.perception.egomotion.flow import FlowTracker, grey
from vpf_sim.planning import variant
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Camera, Expansion, Floats, Flow, Image

VARIANT = "robust"
SETTLED_S = 0.5  # earlier frames are not scored
LEAST_SHARE = 0.002  # least hidden share of a frame that is scored


@dataclass(frozen=True, slots=True)
class Drive:
    """A recording: camera, N frames, poses (N, 3) and true foci of expansion (N, 2) px, nan where unknown."""

    camera: Camera
    rate_hz: float
    poses: Floats
    foe_px: Floats
    frames: Iterable[Image | None]  # (H, W, 3) RGB; None is a gap


@dataclass(frozen=True, slots=True)
class Score:
    """Medians over the frames, or ratios of sums over all frames; nan without samples."""

    cover: float  # share of the frames that water hides
    iou: float  # of the mask and the hidden pixels
    precision: float
    recall: float
    psnr_wet: float  # dB, of the hidden pixels against the dry frame
    psnr_inpainted: float
    psnr_restored: float
    foe_present: float  # share of the frames with a focus of expansion
    foe_px: float  # its distance from the true one, if that is known
    foe_iqr_x_px: float
    foe_iqr_y_px: float
    foe_confidence: float
    masked_foe_px: float  # the same without corners on the detected mask
    masked_foe_iqr_x_px: float
    masked_foe_iqr_y_px: float
    masked_foe_confidence: float


class ExpansionEstimator:
    """Flow and focus of expansion, with or without a mask for corners."""

    def __init__(self, drive: Drive) -> None:
        self._camera, self._variant = drive.camera, variant.load(VARIANT)
        self._tracker = FlowTracker(drive.camera, self._variant.flow, drive.rate_hz)
        self._random = stream(0, "focus of expansion")
        self.foe: Expansion | None = None
        self.rows: list[tuple[float, float, float, float]] = []

    def add(self, image: Image, pose: Floats, foe_px: Floats, hidden: Image | None, counts: bool) -> Flow:
        """The flow of a grey frame; its focus of expansion is scored if `counts`."""
        flow = self._tracker.update(image, pose, hidden)
        self.foe = expansion.estimate(flow, self._camera, self._variant.focus_of_expansion, self._random, self.foe)
        if counts:
            error = np.hypot(*(np.array([self.foe.x_px, self.foe.y_px]) - foe_px))
            self.rows.append((self.foe.x_px, self.foe.y_px, self.foe.confidence, float(error)))
        return flow

    def summary(self) -> tuple[float, float, float, float, float]:
        """Share of frames with a focus, its median error, interquartile ranges of x and y, and median confidence."""
        x, y, confidence, error = np.reshape(np.array(self.rows), (-1, 4)).T
        valid = confidence > 0.0
        return float(np.mean(valid)), _median(error[valid]), _spread(x[valid]), _spread(y[valid]), _median(confidence)


@dataclass(slots=True)
class _MaskSums:
    """Pixel counts of the masks, and PSNR of the images."""

    overlap: int = 0
    found: int = 0
    hidden: int = 0
    pixels: int = 0
    psnr: list[tuple[float, float, float]] = field(default_factory=list)

    def add(self, mask: Image, hidden: Bools) -> None:
        self.overlap += int(np.count_nonzero(hidden & (mask != 0)))
        self.found += int(np.count_nonzero(mask))
        self.hidden += int(np.count_nonzero(hidden))
        self.pixels += hidden.size


def measure(drive: Drive, weather: Weather | None, seed: int) -> Score:
    """The score of a drive with the windscreen water of a weather, or with None as recorded."""
    water = None if weather is None else Glass(drive.camera, weather, Light.of(weather), seed)
    plain, masked, mask = (
        ExpansionEstimator(drive),
        ExpansionEstimator(drive),
        WindscreenMask(drive.camera, drive.rate_hz),
    )
    restoration, pictures = Restoration(drive.camera), _MaskSums()
    before: Snapshot | None = None
    for k, frame in enumerate(drive.frames):
        if frame is None:
            continue
        counts = k >= SETTLED_S * drive.rate_hz
        dry, pose = grey(frame), drive.poses[k]
        now = Snapshot(View.at(drive.camera, pose[:2], float(pose[2])), k / drive.rate_hz, [], {})
        wet = dry if water is None else grey(_with_water(water, frame, now, before))
        before = now
        spots = mask.update(wet, pose)
        covered = mask.with_rim(spots)
        plain.add(wet, pose, drive.foe_px[k], None, counts)
        flow = masked.add(wet, pose, drive.foe_px[k], covered, counts)
        if water is not None and masked.foe is not None:
            restored = restoration.update(wet, covered, flow, masked.foe)
            if counts:
                _add_restored(pictures, spots, water.hidden(), (wet, _inpainted(wet, covered), restored), dry)
    return _score(pictures, plain, masked)


def _with_water(water: Glass, frame: Image, now: Snapshot, before: Snapshot | None) -> Image:
    wet = frame.copy()
    water.draw(wet, now, before or now)
    return wet


def _inpainted(wet: Image, covered: Image) -> Image:
    return np.asarray(cv2.inpaint(wet, covered, 3.0, cv2.INPAINT_TELEA), np.uint8)


def _add_restored(
    pictures: _MaskSums, spots: Image, hidden: Bools, images: tuple[Image, Image, Image], dry: Image
) -> None:
    pictures.add(spots, hidden)
    if hidden.mean() > LEAST_SHARE:
        wet, inpainted, restored = (psnr(one, dry, hidden) for one in images)
        pictures.psnr.append((wet, inpainted, restored))


def psnr(image: Image, truth: Image, where: Bools) -> float:
    """dB, peak signal-to-noise ratio of the pixels `where` (H, W), for a peak of 255."""
    error = image[where].astype(np.float64) - truth[where]
    return float(10.0 * np.log10(255.0**2 / max(float(np.mean(error**2)), 1e-9)))


def _score(pictures: _MaskSums, plain: ExpansionEstimator, masked: ExpansionEstimator) -> Score:
    wet, inpainted, restored = (_median(values) for values in np.reshape(np.array(pictures.psnr), (-1, 3)).T)
    present, error, spread_x, spread_y, confidence = plain.summary()
    return Score(
        cover=_ratio(pictures.hidden, pictures.pixels),
        iou=_ratio(pictures.overlap, pictures.found + pictures.hidden - pictures.overlap),
        precision=_ratio(pictures.overlap, pictures.found),
        recall=_ratio(pictures.overlap, pictures.hidden),
        psnr_wet=wet,
        psnr_inpainted=inpainted,
        psnr_restored=restored,
        foe_present=present,
        foe_px=error,
        foe_iqr_x_px=spread_x,
        foe_iqr_y_px=spread_y,
        foe_confidence=confidence,
        **dict(zip(MASKED, masked.summary()[1:], strict=True)),
    )


MASKED = ("masked_foe_px", "masked_foe_iqr_x_px", "masked_foe_iqr_y_px", "masked_foe_confidence")


def _ratio(part: int, whole: int) -> float:
    return part / whole if whole else float("nan")


def _median(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else float("nan")


def _spread(values: Floats) -> float:
    return float(np.subtract(*np.quantile(values, [0.75, 0.25]))) if len(values) else float("nan")
