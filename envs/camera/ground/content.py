"""The ground as content of the core: paint, shadows, palette, haze, and its levels with their grain."""

from dataclasses import dataclass
from functools import lru_cache
from math import log2

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.core.frames import Core, Polygons
from vpf_sim.envs.camera.detail import detail
from vpf_sim.envs.camera.ground.appearance import ramp
from vpf_sim.envs.camera.ground.levels import Level, levels
from vpf_sim.envs.camera.ground.paint import GRASS, Batch, painted
from vpf_sim.envs.camera.ground.palette import blotch_strength, grain_strength, ground_table, lamp_table
from vpf_sim.envs.camera.ground.rasters import raster_shape
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.layout import LaneShape
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.night.ground_light import paint_efficiency
from vpf_sim.envs.camera.night.lamplight import Lamplight
from vpf_sim.envs.camera.texture import TILE, grain_tile
from vpf_sim.scenarios.parts import RoadAppearance
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats, Image

SHADED = 255  # of a shadow's polygon
SMALLEST_M2 = 0.01  # smaller shadows are left out
THIN_M = 0.075  # texels of half a line's width and more get FINE_ACROSS samples across, smaller ones COARSE_ACROSS
COARSE_ACROSS, FINE_ACROSS = 2, 4
NEAR_ALONG, FAR_ALONG = 2, 4  # samples along a texel
SIZE = 1.6  # texel of noise, in the level's smallest pixels
COARSER = 2.0  # second grain size over the first
SPARSE = 7.0  # texels of noise between averaged samples
BLOTCH_M = 0.6  # texel of the coarse noise
FINEST = 16  # most samples of noise along a texel of the raster
LEAST_FALL = 1e-4  # of a ray below the horizon, over its length ahead
GRAINY_M = (10.0, 30.0)  # texel lengths at which grain starts to fade, and has faded
NO_POLYGONS: Polygons = (np.zeros(1, np.int64), np.empty((0, 2)), np.empty(0, np.int64), np.empty(0))


@dataclass(frozen=True, slots=True)
class Grains:
    """The noise of one level: its sizes, placed in the world by a seed."""

    from_world: Floats  # (3, 3, 3) from world points to texels of fine and coarse grain and of blotches
    fineness: NDArray[np.int64]  # (1 or rows, 3) samples of each along a texel of the raster

    @classmethod
    def of(cls, camera: Camera, level: Level, seed: int) -> "Grains":
        """The noise of a level."""
        sizes = np.array((SIZE * level.across_m, COARSER * SIZE * level.across_m, BLOTCH_M))
        sparse = texel_lengths(camera, level)[:, None] / (SPARSE * sizes)
        fineness = 2 ** np.clip(np.ceil(np.log2(sparse)), 0, log2(FINEST)).astype(np.int64)
        return cls(np.array([_placed(size, seed) for size in sizes.tolist()]), fineness)


def set_ground(
    core: Core,
    shapes: list[LaneShape],
    light: Light,
    wetness: float,
    seed: int,
    look: RoadAppearance,
    shadows: list[Floats],
    haze: Haze,
    gains: tuple[Floats, ...],
    lamplight: Lamplight | None,
) -> None:
    """Set the ground of a road.

    `shadows` are the convex outlines (V, 2) m of the scenery's shadows; `lamplight` is None by day.
    """
    colours = ramp(look)
    core.set_ground(
        palette=ground_table(light, wetness, colours)
        if lamplight is None
        else lamp_table(wetness, colours, paint_efficiency(wetness, lamplight.share)),
        shade=light.shadow,
        outside=GRASS,
        tiles=noise_tiles(),
        gains=(grain_strength(), blotch_strength()),
        haze=haze.ground_rows(),
        paint=polygons_of(painted(shapes, seed, look)),
        shadows=polygons_of(shadow_batches(shadows)),
    )
    for level, gain in zip(levels(core.camera), gains, strict=True):
        add_level(core, level, Grains.of(core.camera, level, seed), look.grain * shown_gains(core.camera, level, gain))


def add_level(core: Core, level: Level, grains: Grains, gains: NDArray[np.float32]) -> None:
    """Add a level whose grain and blotches have `gains` (1 or rows, 2)."""
    camera = core.camera
    shape = raster_shape(camera, level)
    bands = np.array([(band.first, band.last, band.fineness, band.faded) for band in level.bands], np.int32)
    fine = FINE_ACROSS if shape.across_m > THIN_M else COARSE_ACROSS, NEAR_ALONG if level.steep else FAR_ALONG
    numbers = [level.near_m / detail(camera), shape.across_m, shape.along_m, shape.turn_rad, shape.step, shape.sidestep]
    numbers += [shape.ahead_m, shape.right_m, shape.phase, shape.depth_scale]
    core.add_level(
        [level.steep, shape.rows, shape.columns, *fine],
        [*numbers, *shape.to_texels.ravel(), *grains.from_world.ravel()],
        bands,
        level.weights[:, 0],
        np.broadcast_to(gains, (len(grains.fineness), 2)),
        grains.fineness,
    )


def shown_gains(camera: Camera, level: Level, gain: Floats) -> NDArray[np.float32]:
    """(1 or rows, 2) gains of grain and blotches, faded where texels are long."""
    lengths = texel_lengths(camera, level)
    shortest, longest = GRAINY_M
    shown = np.clip((longest - lengths) / (longest - shortest), 0.0, 1.0)
    return np.stack([shown * gain, shown], axis=1).astype(np.float32)


def texel_lengths(camera: Camera, level: Level) -> Floats:
    """(1,) or (rows,) m, the length of a near raster's texels, or of each row's in a far one."""
    shape = raster_shape(camera, level)
    if level.steep:
        return np.array([shape.along_m])
    row_px = (np.arange(-1.0, shape.rows + 1.0) - shape.to_texels[1, 2]) / shape.to_texels[1, 1]
    down = (row_px - camera.cy_px) / camera.fy_px
    c, s = np.cos(camera.pitch_rad), np.sin(camera.pitch_rad)
    below = np.maximum(c * down + s, LEAST_FALL)
    ahead = camera.height_m * (c - s * down) / below
    return np.asarray(0.5 * np.abs(ahead[2:] - ahead[:-2]))


@lru_cache(maxsize=1)
def noise_tiles() -> Image:
    """(2, TILE, TILE) noise about 128: of the grain, and of blotches. The same on every road."""
    tiles = grain_tile("ground", shortest=3.0, slope=0.2), grain_tile("blotches", shortest=3.0, slope=1.0)
    return np.stack([tile[:TILE, :TILE] for tile in tiles])


def polygons_of(batches: list[Batch]) -> Polygons:
    """The polygons of batches, without the repeated vertices that pad short ones."""
    kept = [_kept(batch.polygons_m) for batch in batches]
    if not batches:
        return NO_POLYGONS
    counts = np.concatenate([keep.sum(axis=1) for keep in kept])
    points = np.concatenate([batch.polygons_m[keep] for batch, keep in zip(batches, kept, strict=True)])
    values = np.concatenate([batch.values for batch in batches])
    ranges = np.concatenate([np.full(len(batch.values), batch.range_m) for batch in batches])
    return np.concatenate([[0], np.cumsum(counts)]), points, values, ranges


def shadow_batches(outlines: list[Floats]) -> list[Batch]:
    """Convex polygons (V, 2) m as batches of one vertex count; each is a strip of its own, since they overlap."""
    batches = []
    for count in sorted({len(outline) for outline in outlines}):
        polygons = np.array([outline for outline in outlines if len(outline) == count])
        polygons = polygons[_areas_m2(polygons) > SMALLEST_M2]
        if len(polygons):
            values = np.full(len(polygons), SHADED, np.int64)
            batches.append(Batch(polygons, values, np.arange(len(polygons)), thin=False))
    return batches


def _areas_m2(polygons: Floats) -> Floats:
    """(n,) areas of polygons (n, V, 2)."""
    x, y = polygons[..., 0], polygons[..., 1]
    twice = np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)
    return np.asarray(0.5 * np.abs(twice))


def _kept(polygons: Floats) -> NDArray[np.bool_]:
    """(n, V) which vertices differ from the one before."""
    kept = np.ones(polygons.shape[:2], bool)
    x, y = polygons[..., 0], polygons[..., 1]
    kept[:, 1:] = (x[:, 1:] != x[:, :-1]) | (y[:, 1:] != y[:, :-1])
    return kept


def _placed(size_m: float, seed: int) -> Floats:
    """(3, 3) from world points to texels of noise of `size_m`."""
    rng = stream(seed, f"grain {size_m:.6g}")
    angle, (x, y) = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.0, TILE, 2)
    c, s = np.cos(angle) / size_m, np.sin(angle) / size_m
    return np.array([[c, -s, x], [s, c, y], [0.0, 0.0, 1.0]])
