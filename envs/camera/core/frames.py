"""The core from Python: the content of one road, camera and weather, and its frames.

Content is rounded to what a picture can show, far above the last bits in which numpy differs between processors.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.core import _core
from vpf_sim.types import Bools, Camera, Floats, Image

POSITION_M = 1.0 / 1024.0  # resolution of points
SHARE = 1.0 / 65536.0  # resolution of directions, factors and shares
LEVEL = 1.0 / 256.0  # resolution of colours, grey levels

TEXEL = 128.0  # places in a panorama are given in fractions of a texel, VC_TEXEL in core.h
NO_LAMPS = np.empty((0, 10))
Array = NDArray[Any]
Polygons = tuple[NDArray[np.int64], Floats, NDArray[np.int64], Floats]  # starts (n + 1,), points, values, ranges


def rounded(values: Array | Sequence[float], step: float) -> Floats:
    """The values to the next multiple of a step."""
    return np.asarray(np.round(np.asarray(values, np.float64) / step) * step)


class Core:
    """A core: first its content, each part once, then any number of frames.

    A copy is built when it is first used, from the same content, which the calls that set it keep, and stands at the
    same frame.
    """

    def __init__(self, camera: Camera, ground_top: int) -> None:
        self.camera = camera
        self._top = ground_top
        self._content: list[tuple[str, tuple[Any, ...]]] = []  # calls
        self._reserved = 0
        self._begun: tuple[Any, ...] = ()

    @cached_property
    def _handle(self) -> object:
        """The core itself, with the content so far and at the frame that was begun."""
        handle = self._new()
        for name, arguments in self._content:
            getattr(_core, name)(handle, *arguments)
        if self._reserved:
            _core.reserve(handle, self._reserved)
        if self._begun:
            _core.begin(handle, *self._begun)
        return handle

    def _new(self) -> object:
        camera = self.camera
        size, focal = (camera.width_px, camera.height_px), (camera.fx_px, camera.fy_px)
        place = (camera.height_m, camera.forward_m, camera.pitch_rad)
        return _core.new(*size, self._top, *focal, camera.cx_px, camera.cy_px, *place)

    def _set(self, name: str, *arguments: Any) -> Any:
        """Call a function that sets content, and keep the call for copies."""
        result = getattr(_core, name)(self._handle, *arguments)
        self._content.append((name, arguments))
        return result

    def __getstate__(self) -> dict[str, Any]:
        """All but the core itself."""
        return {name: value for name, value in self.__dict__.items() if name != "_handle"}

    def __deepcopy__(self, memo: dict[int, Any]) -> "Core":
        copy = Core.__new__(Core)
        memo[id(self)] = copy
        copy.__dict__.update({**self.__getstate__(), "_content": list(self._content)})
        return copy

    def set_ground(
        self,
        palette: Image,
        shade: float,
        outside: int,
        tiles: Image,
        gains: tuple[NDArray[np.float32], NDArray[np.float32]],
        haze: Image,
        paint: Polygons,
        shadows: Polygons,
    ) -> None:
        """Set what all levels of the ground share; see `vc_ground` in core.h."""
        arrays: list[Array] = [_bytes(palette), _bytes(tiles)]
        arrays += [np.ascontiguousarray(gain, np.float32) for gain in gains]
        arrays += [_bytes(haze), *_polygons(paint), *_polygons(shadows)]
        self._set("set_ground", outside, round(256.0 * shade), *arrays)

    def add_level(
        self,
        whole: Sequence[int],
        real: Sequence[float],
        bands: NDArray[np.int32],
        weights: Image,
        gains: NDArray[np.float32],
        fineness: NDArray[np.int64],
    ) -> None:
        """Add a level of the ground, the farthest first; see `vc_level` in core.h."""
        numbers = np.array(whole, np.int32), np.array(real, np.float64)
        gains = np.ascontiguousarray(rounded(gains, SHARE), np.float32)
        self._set(
            "add_level", *numbers, np.ascontiguousarray(bands, np.int32), _bytes(weights), gains, _bytes(fineness)
        )

    def add_panorama(
        self, rows: slice, coarse: int, px: Image, columns_per_rad: float, across: Floats, down: Floats
    ) -> None:
        """Add a panorama that fills image rows; `across` and `down` are (h, w) places in it, see core.h."""
        texels = [np.ascontiguousarray(np.rint(TEXEL * of), np.int32) for of in (across, down)]
        tall, wide = px.shape[:2]
        place = rows.start, rows.stop, coarse, tall, wide, *across.shape
        self._set("add_panorama", *place, float(columns_per_rad), _bytes(px), *texels)

    def set_light(
        self,
        horizon: Floats,
        sun: Floats,
        factors: tuple[Floats, Floats],
        shadows: tuple[float, float],
        fall: Floats,
        transmission: Floats,
    ) -> None:
        """Set light and haze of what rises from the ground; see `vc_light` in core.h."""
        numbers = [rounded(horizon, LEVEL), rounded(sun, SHARE), *(rounded(factor, SHARE) for factor in factors)]
        light = np.concatenate([*numbers, rounded(shadows, SHARE), rounded(fall, SHARE)])
        self._set("set_light", light, rounded(transmission, SHARE))

    def set_roadside(self, faces: Sequence[Array], items: Sequence[Array], ranges_m: Sequence[Floats]) -> None:
        """Set the furniture beside the road: its faces, items and drawing ranges; see `vc_roadside` in core.h."""
        first, middles, radii = items
        arrays: list[Array] = [np.ascontiguousarray(first, np.int32)]
        arrays += [rounded(middles, POSITION_M), rounded(radii, POSITION_M), *(rounded(of, SHARE) for of in ranges_m)]
        self._set("set_roadside", faces[0].shape[1], *_faces(*faces), *arrays)

    def add_mesh(
        self,
        size_m: tuple[float, float, float],
        faces: Sequence[Array],
        parts: NDArray[np.int64],
        thickness_m: Floats,
        centres_m: Floats,
    ) -> int:
        """Add a mesh in its object's axes and return its number; see `vc_mesh` in core.h."""
        arrays = np.ascontiguousarray(parts, np.int32), rounded(thickness_m, POSITION_M), rounded(centres_m, POSITION_M)
        return int(self._set("add_mesh", faces[0].shape[1], *size_m, *_faces(*faces), *arrays))

    def add_tree(self, range_m: float, levels: Sequence[Image], haze: Floats) -> None:
        """Add a kind of tree: pictures (h, w, 4), the finest first; see `vc_tree` in core.h."""
        sizes = np.array([level.shape[:2] for level in levels], np.int32)
        px = _bytes(np.concatenate([level.ravel() for level in levels]))
        self._set("add_tree", range_m, sizes, px, rounded(haze, SHARE))

    def plant(self, trees: Floats) -> None:
        """Set the trees, (n, 7); see `vc_plant` in core.h."""
        self._set("plant", rounded(trees, POSITION_M))

    def set_lamps(
        self, numbers: Sequence[float], street_lamps_m: Floats, factors: Floats, factor_scale: float, ground: Floats
    ) -> None:
        """Set the light of lamps in the dark; see `vc_lamps` in core.h."""
        arrays = [np.array([*numbers, factor_scale], np.float64), rounded(street_lamps_m, POSITION_M)]
        arrays += [rounded(factors, SHARE), rounded(ground, SHARE)]
        self._set("set_lamps", ground.shape[1], *arrays)

    def add_glow(self, picture: Image) -> int:
        """Add the picture (n, n, 4) of a lamp and return its number."""
        return int(self._set("add_glow", len(picture), _bytes(picture)))

    def set_wet_road(self, reflectance: Image, share: Image, level: int, smear: int, ripple: int, seed: int) -> None:
        """Set how the road reflects; `reflectance` is (rows, columns) of the canvas; see `vc_wet_road` in core.h."""
        rows, columns = reflectance.shape
        arrays = _bytes(reflectance), _bytes(share)
        self._set("set_wet_road", rows, columns, level, smear, ripple, seed, *arrays)

    def set_puddles(self, depths: Image, corner_m: tuple[float, float], cell_m: float) -> None:
        """Set depths of water (cells, cells) around a place; see `vc_puddles` in core.h. A copy has none."""
        _core.set_puddles(self._handle, len(depths), *corner_m, cell_m, _bytes(depths))

    def set_spray(self, strength: float, colour: Floats, opacity: Image, seed: int) -> None:
        """Set the spray: pictures (n, size, size) of puffs; see `vc_spray` in core.h."""
        red, green, blue = np.rint(colour).astype(int).tolist()
        pictures, size = opacity.shape[:2]
        self._set("set_spray", strength, red, green, blue, pictures, size, seed, _bytes(opacity))

    def begin_spray(self, speeds_mps: Floats) -> None:
        """Add spray to what the next frame shows, by the (n,) speeds of the objects."""
        _core.begin_spray(self._handle, speeds_mps)

    def draw_wet_road(self, frame: Image) -> None:
        """Draw reflections on the road, between backdrop and scene."""
        _core.draw_wet_road(self._handle, frame)

    def hidden_by_rain(self) -> Bools:
        """(H, W) where reflections or spray hide the scene of the last frame."""
        hidden = np.empty((self.camera.height_px, self.camera.width_px), np.int32)
        _core.hidden_by_rain(self._handle, hidden)
        return hidden > 0

    def set_noise(self, levels: NDArray[np.int8], seed: int) -> None:
        """Set the bank of noise, (rows, columns, 3) grey levels."""
        rows, columns = levels.shape[:2]
        self._set("set_noise", rows, columns, seed, np.ascontiguousarray(levels))

    def begin(
        self, x_m: float, y_m: float, yaw_rad: float, time_s: float, objects: Floats, lamps: Floats = NO_LAMPS
    ) -> None:
        """Set the pose of the next frame and find what it shows.

        `objects` is (n, 4): x, y, heading, and the number of the mesh as the bits of an int64. `lamps` is (n, 10):
        x, y in px, depth, flux, size in px, linear RGB, and as the bits of int64 the number of the picture, and of the
        object or -1.
        """
        if len(objects) > self._reserved:
            self._reserved = 2 * len(objects)
            _core.reserve(self._handle, self._reserved)
        self._begun = (x_m, y_m, yaw_rad, round(1e6 * time_s), objects, lamps)
        _core.begin(self._handle, *self._begun)

    def draw_backdrop(self, frame: Image) -> None:
        """Draw sky, ground and haze."""
        _core.draw_backdrop(self._handle, frame)

    def draw_scene(self, frame: Image) -> None:
        """Draw the shadows of objects, and all that rises from the ground."""
        _core.draw_scene(self._handle, frame)

    def draw_noise(self, frame: Image, time_s: float) -> None:
        """Add the sensor's noise of a time."""
        _core.draw_noise(self._handle, round(1e6 * time_s), frame)

    def read_out(self, frame: Image, shift_px: float) -> Image:
        """(H, W, 3) the frame through a rolling shutter: the scene moves `shift_px` further to the left in each row."""
        read = np.empty_like(frame)
        _core.read_out(self._handle, shift_px, frame, read)
        return read

    def truth(self) -> tuple[NDArray[np.int32], Floats]:
        """(H, W) what each pixel shows: 0 ground or sky, -1 scenery, i + 1 object i; and (H, W, 3) its plane."""
        size = (self.camera.height_px, self.camera.width_px)
        instance, planes = np.empty(size, np.int32), np.empty((*size, 3))
        _core.truth(self._handle, instance, planes)
        return instance, planes

    def raster(self, level: int, rows: int, columns: int) -> NDArray[np.uint32]:
        """(rows, columns) texels of a level in the last frame: palette values, and shadow in the high half."""
        texels = np.empty((rows, columns), np.uint32)
        _core.read_raster(self._handle, level, texels)
        return texels


def _bytes(array: Array) -> Image:
    return np.ascontiguousarray(array, np.uint8)


def _polygons(polygons: Polygons) -> list[Array]:
    starts, points, values, ranges_m = polygons
    ranges_m = np.minimum(ranges_m, 1e6)
    return [
        np.ascontiguousarray(starts, np.int32),
        rounded(points, POSITION_M),
        _bytes(values),
        rounded(ranges_m, SHARE),
    ]


def _faces(points: Array, normals: Array, colours: Array, flags: Array) -> list[Array]:
    return [rounded(points, POSITION_M), rounded(normals, SHARE), rounded(colours, LEVEL), _bytes(flags)]
