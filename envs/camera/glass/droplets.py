"""Drops on the windscreen: they land, merge, run, dry or are wiped away."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from vpf_sim.envs.camera.glass.drops import DRAWN, DROP, PLACE, DropPicture, Drops
from vpf_sim.envs.camera.glass.impacts import FOOTPRINT, Impacts
from vpf_sim.envs.camera.glass.pane import Pane
from vpf_sim.envs.camera.glass.planes import Planes
from vpf_sim.envs.camera.glass.stamps import VARIANTS
from vpf_sim.envs.camera.glass.wipers import Swath
from vpf_sim.seeding import stream
from vpf_sim.types import Bools, Image

RUNS_FROM_MM = 3.3  # diameter from which drops run; the spot is 6 mm wide
GRAVITY_BELOW_MPS, WIND_ABOVE_MPS = 12.0, 20.0  # between these speeds all drops stand still
RUN_MPS = (0.02, 0.1)
RUNS_S, RESTS_S = 0.35, 0.25  # mean durations of running and of resting
SHED_EVERY = 0.6  # mean distance between shed drops, in widths of the spot
SHED_SHARE = (0.2, 0.4)  # size of a shed drop over the running one's
LIFE_S = (5.0, 20.0)  # life of a drop without a wiper
LARGEST_MM = 8.0
SMALLEST_PX = 2.5  # narrower spots are part of the film


class Droplets:
    """All drops on the windscreen and their image."""

    def __init__(self, pane: Pane, planes: Planes, rain_mmph: float, seed: int) -> None:
        self.planes = planes
        self.picture = DropPicture(pane, planes)
        self.drops: Drops = np.zeros(0, DROP)
        self._pane = pane
        self._impacts = Impacts(rain_mmph)
        self._area_m2 = float(pane.above_m2[-1])
        self._rng = stream(seed, "droplets")

    def advance(self, time_s: float, gap_s: float, speed_mps: float) -> None:
        """Simulate landing, running and drying over the `gap_s` before `time_s`."""
        height, width = self.planes.shape
        out = (self.drops["row"] < 0) | (self.drops["row"] > height) | (abs(2 * self.drops["column"] - width) > width)
        gone = (self.drops["dies"] <= time_s) | out
        if gone.any():
            dead, self.drops = self.drops[gone], self.drops[~gone]
            self.picture.replace(dead, self.drops)
        self._run(time_s, gap_s, speed_mps)
        self._land(time_s, gap_s, speed_mps)

    @contextmanager
    def suspended(self) -> Iterator[None]:
        """Suspend drawing; draw the remaining drops at the end."""
        self.picture.drawing = False
        yield
        self.picture.drawing = True
        self.planes.clear(self.planes.whole)
        self.picture.put(self.drops)

    def wipe(self, swath: Swath) -> None:
        """Remove the drops with their centre in a swath, and all water in it.

        A drop cut by the swath's sides lies under the blade and goes with the next swath; a drop cut by its ends is
        drawn again or removed as a whole.
        """
        x, y = self.drops["x"], self.drops["y"]
        gone = swath.holds(x, y)
        cut = swath.at_end(x, y)
        cut[cut] = (self._corners_in(swath.mask, self.drops[cut]) != gone[cut, None]).any(axis=1)
        halves, wholes = self.drops[gone & cut], self.drops[~gone & cut]
        self.drops = self.drops[~gone]
        self.picture.wipe(swath.mask)
        self.picture.put(wholes)
        self.picture.replace(halves, self.drops)

    def _corners_in(self, mask: Image, drops: Drops) -> Bools:
        """(n, 4) whether the corners of each drop's box lie in a mask of the planes."""
        height, width = mask.shape
        column, row, rx, ry = (drops[name][:, None] for name in (*PLACE, "rx", "ry"))
        columns = np.clip(column + rx * np.array([-1, 1, -1, 1]), 0, width - 1)
        rows = np.clip(row + ry * np.array([-1, -1, 1, 1]), 0, height - 1)
        inside: Bools = mask[rows, columns] > 0
        return inside

    def _land(self, time_s: float, gap_s: float, speed_mps: float) -> None:
        sizes = self._impacts.draw(self._rng, speed_mps, self._area_m2 * gap_s)
        random = self._rng.random((4, len(sizes)))
        y = self._pane.spread(random[1])
        rows = self._pane.row(y)
        visible = FOOTPRINT**2 * sizes**2 * self._pane.across[rows] * self._pane.along[rows] >= SMALLEST_PX**2
        sizes, y, random = sizes[visible], y[visible], random[:, visible]
        new = np.zeros(len(sizes), DROP)
        new["x"] = random[0] * self._pane.camera.width_px - 0.5
        new["y"] = y
        new["size"] = sizes
        new["dies"] = time_s + LIFE_S[0] + (LIFE_S[1] - LIFE_S[0]) * random[2]
        new["turns"] = time_s + RESTS_S * random[3]
        new["variant"] = (VARIANTS * random[3]).astype(np.int32)
        self.picture.shape(new)
        first = len(self.drops)
        self.drops = np.concatenate([self.drops, new])
        self.picture.put(self.merge(np.arange(first, len(self.drops)), first))

    def merge(self, movers: NDArray[np.intp], undrawn_from: int) -> Drops:
        """Merge each of `movers` with the drops it touches: volumes add up, at the centre of mass.

        Drops touch if the centre of one lies in the spot of the other. Returns the drops to draw: those that grew, and
        the remaining ones from `undrawn_from` on.

        """
        gone, grown = np.zeros(len(self.drops), bool), np.arange(len(self.drops)) >= undrawn_from
        replaced = [self.drops[:0]]
        for i, touched in self._touching(movers):
            group = np.append(touched[~gone[touched]], i)
            if gone[i] or len(group) == 1:
                continue
            keeper = int(group[np.argmax(self.drops["size"][group])])
            replaced.append(self.drops[group[group < undrawn_from]])
            self._collect(group, keeper)
            gone[group], gone[keeper], grown[keeper] = True, False, True
        if gone.any():
            self.drops, grown = self.drops[~gone], grown[~gone]
        self.picture.replace(np.concatenate(replaced), self.drops)
        return self.drops[grown]

    def _collect(self, group: NDArray[np.intp], keeper: int) -> None:
        """Move the water of a group into one drop."""
        drops = self.drops
        volumes = drops["size"][group] ** 3
        for axis in ("x", "y"):
            drops[axis][keeper] = volumes @ drops[axis][group] / volumes.sum()
        drops["size"][keeper] = min(volumes.sum() ** (1 / 3), LARGEST_MM)
        self.picture.shape(drops[keeper : keeper + 1])

    def _touching(self, movers: NDArray[np.intp]) -> list[tuple[int, NDArray[np.intp]]]:
        """For each mover that touches others: its index and theirs."""
        drops, rows = self.drops, self._pane.row(self.drops["y"][movers])
        dx = (drops["x"][movers, None] - drops["x"]) / self._pane.across[rows, None]
        dy = (drops["y"][movers, None] - drops["y"]) / self._pane.along[rows, None]
        reach = FOOTPRINT / 2 * np.maximum(drops["size"][movers, None], drops["size"])
        touching = dx * dx + dy * dy < reach * reach
        touching[np.arange(len(movers)), movers] = False
        return [(int(movers[k]), np.flatnonzero(touching[k])) for k in np.flatnonzero(touching.any(axis=1))]

    def _run(self, time_s: float, gap_s: float, speed_mps: float) -> None:
        """Move large drops intermittently: down at low speed, up and outwards at high speed."""
        large = np.flatnonzero(self.drops["size"] >= RUNS_FROM_MM)
        for i in large[self.drops["turns"][large] <= time_s]:
            self._turn(int(i), time_s)
        blown = speed_mps > WIND_ABOVE_MPS
        running = large[self.drops["run"][large] > 0.0]
        if not len(running) or (not blown and speed_mps >= GRAVITY_BELOW_MPS):
            return
        before = self.drops[running]
        self.drops[running] = self._stepped(before, gap_s, blown)
        left = self._shed(running, before, gap_s, blown)
        moved = self.drops[DRAWN][running] != before[DRAWN]
        self.picture.replace(before[moved], self.drops)
        self.picture.put(self.drops[running[moved]])
        self.picture.put(self.merge(running[moved], len(self.drops)))
        self.add(left)

    def _turn(self, i: int, time_s: float) -> None:
        """Start a resting drop, or stop a running one."""
        rests = self.drops["run"][i] == 0.0
        self.drops["run"][i] = self._rng.uniform(*RUN_MPS) if rests else 0.0
        self.drops["turns"][i] = time_s + self._rng.exponential(RUNS_S if rests else RESTS_S)

    def _stepped(self, drops: Drops, gap_s: float, blown: bool) -> Drops:
        """Running drops after `gap_s`."""
        later, rows = drops.copy(), self._pane.row(drops["y"])
        way_mm = 1e3 * gap_s * drops["run"]
        sideways = self._rng.normal(0.0, 0.4, len(drops))
        if blown:
            sideways += 0.7 * np.sign(drops["x"] - self._pane.camera.cx_px)
        later["x"] += way_mm * self._pane.across[rows] * sideways
        later["y"] += way_mm * self._pane.along[rows] * (-0.7 if blown else 1.0)
        self.picture.shape(later)
        return later

    def _shed(self, running: NDArray[np.intp], before: Drops, gap_s: float, blown: bool) -> Drops:
        """The small drops that running ones shed; their water is taken from these."""
        spots = before["run"] * 1e3 * gap_s / (SHED_EVERY * FOOTPRINT * before["size"])
        sheds = self._rng.random(len(running)) < spots
        left = before[sheds]
        left["size"] *= self._rng.uniform(*SHED_SHARE, len(left))
        left["run"] = 0.0
        spot_px = FOOTPRINT * before["size"][sheds] * self._pane.along[self._pane.row(left["y"])]
        left["y"] += 0.6 * spot_px * (1.0 if blown else -1.0)
        self.picture.shape(left)
        lighter = self.drops[running[sheds]]
        lighter["size"] = (before["size"][sheds] ** 3 - left["size"] ** 3) ** (1 / 3)
        self.picture.shape(lighter)
        self.drops[running[sheds]] = lighter
        return left

    def add(self, drops: Drops) -> None:
        """Add drops."""
        self.picture.put(drops)
        self.drops = np.concatenate([self.drops, drops])
