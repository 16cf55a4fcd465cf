"""Mirror images on a wet road: how far the road mirrors, and how faint a vehicle's own image is.

A mirror image lies below the road and moves as a vehicle does, so point tracks cannot reject it. A wet road reflects
a small share of the light (Fresnel) and smears it: an image has a part of the contrast of upright objects. Contrasts
are logarithms of squared gradients; 0 is that of upright objects.
"""

from math import exp

import numpy as np

from vpf_sim.perception.obstacles.moving.detection import MeasuredPoints
from vpf_sim.perception.obstacles.moving.moving_obstacle_settings import (
    ContrastConfig,
    MirrorImageConfig,
    MovingObstacleConfig,
    ReflectivityConfig,
)
from vpf_sim.perception.obstacles.moving.place import is_on_carriageway
from vpf_sim.perception.obstacles.moving.track import MovingTrack
from vpf_sim.perception.quantiles import median
from vpf_sim.types import Camera, Floats, Integers, RoadEdges

WET = (20.0, 50.0)  # points below the road, and all: before the first observation the road mirrors


class Reflectivity:
    """How far the road mirrors, by the share of its points that lie below it and belong to no track."""

    def __init__(self, config: ReflectivityConfig, look_s: float) -> None:
        self._config = config
        self._kept = exp(-look_s / config.memory_s)
        self._below, self._all = WET

    def update(self, below: int, count: int) -> None:
        """Add an observation of `count` points on the road, outside all tracks, `below` of them below the road."""
        if not count:
            return
        self._below, self._all = self._kept * self._below + below, self._kept * self._all + count

    @property
    def degree(self) -> float:
        """0 on a dry road, 1 on a wet one."""
        dry, wet = self._config.dry_share, self._config.wet_share
        return min(max((self._below / max(self._all, 1.0) - dry) / (wet - dry), 0.0), 1.0)


def faint_contrast(degree: float, depth_m: float, config: ContrastConfig) -> float:
    """The contrast below which points at a depth speak against a track, by the road's reflectivity."""
    dry = float(np.interp(depth_m, config.faint_m, config.dry_faint))
    return dry + degree * (config.wet_faint - dry)


def image_contrast(degree: float, upper: Floats, config: MirrorImageConfig) -> float:
    """The contrast below which points belong to a vehicle's mirror image, by the road's reflectivity.

    `upper` (N,) is the contrast of the vehicle's points above `above_m`: a dark car's image is fainter. But points up
    there as faint as an image are one themselves.
    """
    own = median(upper) if len(upper) else config.wet
    dark = min(own - config.fainter - config.wet, 0.0)
    is_vehicle = min(max((own - config.wet) / config.ramp, 0.0), 1.0)
    return config.dry + degree * (config.wet + is_vehicle * dark - config.dry)


class MirrorImages:
    """Contrast limits of a track's points, against its own mirror image and against other images."""

    def __init__(self, camera: Camera, config: MovingObstacleConfig, look_s: float) -> None:
        self._camera, self._config = camera, config
        self.reflectivity = Reflectivity(config.reflectivity, look_s)

    def own_image(self, seen: MeasuredPoints, within: Integers, depth_m: float) -> float:
        """Contrast of the mirror image of a vehicle with the points `within` its outline; -inf: no image."""
        config = self._config
        if depth_m < config.steep_m:
            return -np.inf
        height = self._camera.height_m - seen.drop[within] * depth_m
        upper = within[(height > config.mirror_image.above_m) & (height < config.evidence.high_m)]
        return image_contrast(self.reflectivity.degree, seen.contrast[upper], config.mirror_image)

    def faint(self, track: MovingTrack, image: float, own_mps: float, pose: Floats, road: RoadEdges) -> float:
        """The contrast below which points speak against a track.

        Hardly anything stands on the road, so where the mirrored object would stand there, the limit is that of the
        own `image`, or of asphalt.
        """
        config, contrast = self._config, self._config.evidence.contrast
        forward, right = track.place(pose)
        depth, mirrored_m = forward - self._camera.forward_m, config.mirrored_place_m
        share = track.closing_share(own_mps)  # of the track's depth in that of the mirrored object
        is_known = depth > config.steep_m and share * mirrored_m > depth
        if is_known and is_on_carriageway(
            self._camera.forward_m + depth / share, right / share, road, config.edge_margin_m
        ):
            return max(image, faint_contrast(0.0, depth, contrast))
        return faint_contrast(self.reflectivity.degree, depth, contrast)
