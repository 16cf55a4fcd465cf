"""The driver by lane lines: where it finds the lane, when it brakes, that it arrives."""

from pathlib import Path

import cv2
import numpy as np
import pytest
import rendered_drive as rendered

from vpf_sim.drivers.lane_lines import BirdsEye, ContactBrake, LaneFit, fit_lane, ridges
from vpf_sim.evaluation.episode import episode
from vpf_sim.types import Camera, Image

LANE_M = 3.5
FRAMES = 12


@pytest.mark.parametrize(("right_m", "radius_m"), [(0.0, np.inf), (0.4, np.inf), (-0.4, np.inf), (0.0, 100.0)])
def test_the_lane_is_found_where_it_lies(right_m: float, radius_m: float) -> None:
    """A camera `right_m` right of the lane's centre sees the centre that far to the left."""
    images, poses = rendered.shots(radius_m, 2, right_m, None, FRAMES)
    above, lane = BirdsEye(rendered.CAMERA), None
    errors_m, curvatures_per_m = [], []
    for k, image in enumerate(images):
        if lane is not None:
            moved = poses[k] - poses[k - 1]
            lane = lane.predict(float(np.hypot(*moved[:2])), float(moved[2]))
        found = fit_lane(ridges(above.of(image)), lane)
        assert found is not None
        lane = found
        errors_m.append(found.at_m(0.0) + right_m)
        curvatures_per_m.append(found.curvature_per_m)
    assert np.median(np.abs(errors_m)) < 0.15
    assert np.median(curvatures_per_m) == pytest.approx(1.0 / radius_m, abs=0.003)
    assert lane is not None
    assert lane.width_m == pytest.approx(LANE_M, abs=0.15)


def test_no_lane_is_found_on_bare_road() -> None:
    bare = np.full((480, 640, 3), 90, np.uint8)
    assert fit_lane(ridges(BirdsEye(Camera()).of(bare)), None) is None


def test_a_lane_is_predicted_along_its_bend() -> None:
    """A car that follows a bend keeps its place and heading in the lane."""
    lane = LaneFit(0.2, 0.0, 0.01, LANE_M)
    after = lane.predict(5.0, 0.01 * 5.0)
    assert (after.right_m, after.heading_rad) == pytest.approx((0.2, 0.0), abs=0.02)


def looming(ttc_s: float, rate_hz: float, count: int) -> list[Image]:
    """A textured wall that is `ttc_s` away in the first frame and nears at constant speed."""
    random = np.random.default_rng(1)
    wall = cv2.resize(random.integers(0, 255, (48, 64, 3), np.uint8), (640, 480), interpolation=cv2.INTER_CUBIC)
    centre = 319.5, 239.5
    scales = [ttc_s / (ttc_s - k / rate_hz) for k in range(count)]
    turns = [np.array([[s, 0.0, centre[0] * (1 - s)], [0.0, s, centre[1] * (1 - s)]]) for s in scales]
    return [cv2.warpAffine(wall, turn, (640, 480), borderMode=cv2.BORDER_REFLECT).astype(np.uint8) for turn in turns]


@pytest.mark.parametrize(("ttc_s", "alarms"), [(1.4, True), (6.0, False)])
def test_it_brakes_for_a_wall_that_comes_near(ttc_s: float, alarms: bool) -> None:
    brake = ContactBrake(Camera())
    shown = looming(ttc_s, 20.0, 10)
    assert any(brake.alarm(image, k / 20.0) for k, image in enumerate(shown)) == alarms


def test_it_arrives_in_a_bend(tmp_path: Path) -> None:
    path = tmp_path / "bend.toml"
    path.write_text('schema = 1\nbase = "curve-left"\n[ego]\ns_m = 45.0\n[goal]\ns_m = 95.0\n')
    found = episode.run(str(path), "clear", "lane-lines", 0)
    assert found.record.succeeded
    assert found.record.scores["max_lane_offset_m"] < 0.5
