"""The verges of a road: where its surface ends, as steps of colour that run along with its lines."""

import cv2
import numpy as np

from vpf_sim.perception.quantiles import quantile
from vpf_sim.perception.road.feature_matcher import FeatureMatcher
from vpf_sim.perception.road.markings import RidgeMap, bright, sight
from vpf_sim.perception.road.model import VERGE, WIDTH, seen_places
from vpf_sim.perception.road.road_settings import RoadEdgeConfig, VergeConfig
from vpf_sim.perception.road.state_filter import LaneFilter
from vpf_sim.types import Bools, Camera, Floats, Image, Integers, Obstacles


class VergeMatcher(FeatureMatcher):
    """Finds the verges of a tracked road in frames of one camera, and matches them."""

    def __init__(self, camera: Camera, road: RoadEdgeConfig, config: VergeConfig) -> None:
        self.config = config
        self._reach = max(2 * round(0.5 * (config.surface_m / config.column_m - 1.0)) + 1, 3)
        margin = 3 * self._reach + round(config.centroid_m / config.column_m)
        super().__init__(camera, road, road.verge_patch(config.column_m), margin, config.sigma_m)

    def steps(self, image_rgb: Image, obstacles: Obstacles | None, pitch_rad: float) -> RidgeMap:
        """The steps of colour in a frame outside the parts that obstacles hide."""
        visible = self.visible(obstacles, pitch_rad)
        response = step(self.view.warp(image_rgb), self._reach)
        sample = response[::2, ::2][visible[::2, ::2]]
        usual = quantile(sample, 0.5) if sample.size else 0.0
        threshold = max(self.config.least_levels, 2.0 * usual)
        return RidgeMap(self.view, response, threshold, visible, self.config.centroid_m)

    def find(self, tracked: LaneFilter, steps: RidgeMap) -> None:
        """Add the verges that are not known yet, and are clear beside the pose."""
        missing = [number for number in VERGE if number not in tracked.verges]
        if not missing:
            return
        config, view = self.config, self.view
        places_m, reached = seen_places(
            tracked.state, (tracked.state[0] + view.right_m) / tracked.state[WIDTH], view.forward_m, self.camera
        )
        columns, shown, length_m = self._shown(places_m, reached, steps)
        rows = np.arange(len(view.forward_m))
        clear = (bright(steps, rows)[rows, columns] * shown) @ view.length_m
        share = clear / np.maximum(length_m, config.least_length_m)
        share -= np.median(share)
        for number in missing:
            beside = np.where(np.sign(number) * view.right_m > config.beside_m, share, 0.0)
            best = int(np.argmax(beside))
            if beside[best] > config.found_share:
                place_m = float(tracked.state[0] + view.right_m[best])
                tracked.add_verge(number, place_m, config.found_sigma_m, float(beside[best]))

    def clear(self, tracked: LaneFilter) -> list[float]:
        """Numbers of the verges that are clear enough to be evidence for the edges."""
        return [number for number, share in tracked.verges.items() if share > self.config.clear_share]

    def judge(self, tracked: LaneFilter, steps: RidgeMap) -> None:
        """Average the visible shares of the known verges, and drop those that have gone or are hidden."""
        if not tracked.verges:
            return
        config, view, numbers = self.config, self.view, tracked.verge_numbers
        expected_m, reached = seen_places(tracked.state, numbers, view.forward_m, self.camera)
        _, shown, length_m = self._shown(expected_m, reached, steps)
        _, seen = sight(steps, expected_m, shown, config.on_verge_m)
        shares = (seen @ view.length_m) / np.maximum(length_m, config.least_length_m)
        for number, share in zip(numbers.tolist(), shares.tolist(), strict=True):
            tracked.verges[number] += config.new_share * (share - tracked.verges[number])
            if tracked.verges[number] < config.lost_share:
                tracked.drop_verge(number)

    def _shown(self, places_m: Floats, reached: Bools, steps: RidgeMap) -> tuple[Integers, Bools, Floats]:
        """The columns of places (L, R) on curves along the road, which are visible, and (L,) m, their length."""
        columns, inside = self.view.columns(places_m, reached)
        inside &= steps.visible[np.arange(len(self.view.forward_m)), columns]
        return columns, inside, inside @ self.view.length_m


def step(patch: Image, reach: int) -> Image:
    """(rows, columns) levels by which the colours left and right of each place differ.

    Means of `reach` columns, an odd number, beside it, and of as many farther out: the smaller difference counts. What
    is narrow and bright, such as a painted line, is taken out first.
    """
    unpainted = cv2.morphologyEx(patch, cv2.MORPH_OPEN, np.ones((1, reach), np.uint8))
    mean = cv2.blur(unpainted, (reach, 1))
    result = np.full(patch.shape[:2], 255, np.uint8)
    for apart in (reach + 1, 4 * reach):
        difference = np.zeros(patch.shape[:2], np.uint8)
        first = apart // 2
        levels = cv2.absdiff(mean[:, :-apart], mean[:, apart:]).max(axis=2)
        difference[:, first : first + levels.shape[1]] = levels
        result = np.minimum(result, difference)
    return cv2.GaussianBlur(result, (3, 1), 0.8).astype(np.uint8, copy=False)
