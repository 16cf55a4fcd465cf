"""A lane is found where paint or an edge supports it: films of roads with known lines, and of streets without any."""

from pathlib import Path
from typing import Any

import made_films
import numpy as np
import pytest
from made_films import RATE_HZ, SPEED_MPS

from vpf_sim.planning import variant
from vpf_sim.replay import open_loop, readers
from vpf_sim.replay.fixed_structure import FixedStructure
from vpf_sim.replay.present_lane import LaneSupport
from vpf_sim.types import Camera, RoadEdges

CAMERA = "field_of_view_deg = 60.0\nheight_m = 1.4\npitch_deg = 0.0\nyaw_deg = 0.0"
RADIUS_M = 80.0
LENS = Camera.of(made_films.WIDTH_PX, made_films.HEIGHT_PX, 60.0, height_m=1.4, forward_m=0.0)


def found_share(folder: Path, radius_m: float = np.inf, **made: Any) -> float:
    """Share of the frames in which `vpf` has a lane."""
    images = made_films.film(seconds=2.5, radius_m=radius_m, **made)
    drive = made_films.write(folder / "drive", images, camera=CAMERA, motion=(SPEED_MPS, SPEED_MPS / radius_m))
    record, _ = open_loop.run(readers.read(drive), "vpf", folder / "out", with_video=False)
    return float(record.perception.road_found_share)


@pytest.mark.parametrize(
    ("weather", "look"),
    [
        ("ClearNight", ()),
        pytest.param("WetNight", (), marks=pytest.mark.slow),
        pytest.param("ClearNight", ("kerbs",), marks=pytest.mark.slow),
        pytest.param("CloudyNight", ("marks",), marks=pytest.mark.slow),
    ],
    ids=["night", "wet night", "kerbs", "crosswalks"],
)
def test_street_without_lines_has_no_lane(weather: str, look: tuple[str, ...], tmp_path: Path) -> None:
    assert found_share(tmp_path, weather=weather, look=look, lines=False) < 0.2


@pytest.mark.parametrize(
    "made",
    [
        {"weather": "ClearNight"},
        pytest.param({"radius_m": RADIUS_M}, marks=pytest.mark.slow),
        pytest.param({"look": ("marks",)}, marks=pytest.mark.slow),
        pytest.param({"look": ("worn",)}, marks=pytest.mark.slow),
    ],
    ids=["night", "bend", "crosswalks", "worn"],
)
def test_road_with_lines_has_its_lane(made: dict[str, Any], tmp_path: Path) -> None:
    assert found_share(tmp_path, **made) > 0.85


def road(curvature_per_m: float = 0.0, right_m: float = 0.0) -> RoadEdges:
    """The true lane of the film, or one that is bent or beside it."""
    return RoadEdges(-5.25, 5.25, 0.0, curvature_per_m, 0.05, 1.0, right_m, 3.5, 1.0)


def support(fixed: FixedStructure | None = None) -> LaneSupport:
    return LaneSupport(LENS, variant.load("robust").road_edges, fixed)


@pytest.mark.parametrize(("lane", "is_there"), [(road(), True), (road(0.02), False), (road(right_m=1.2), False)])
def test_lane_is_supported_where_its_lines_are(lane: RoadEdges, is_there: bool) -> None:
    """A lane that bends away from straight lines, as at a crosswalk, is not, nor is one beside them."""
    reader = support()
    seen = [reader.update(image, lane, k / RATE_HZ) for k, image in enumerate(made_films.film(seconds=2.5)[::2])]
    assert np.mean(seen[5:]) == pytest.approx(float(is_there), abs=0.1)


def test_lane_is_lost_a_second_after_its_paint_ends() -> None:
    painted, bare = (made_films.film(seconds=2.5, lines=lines) for lines in (True, False))
    reader = support()
    seen = [reader.update(image, road(), k / RATE_HZ) for k, image in enumerate([*painted, *bare])]
    end = len(painted)
    assert all(seen[end - 10 : end + 5])
    assert not any(seen[end + round(1.2 * RATE_HZ) :])


def test_lines_that_are_fixed_to_the_camera_support_no_lane() -> None:
    image = made_films.film(seconds=2.5)[0]
    everything = FixedStructure(np.ones(image.shape[:2], np.bool_))
    assert support().update(image, road(), 0.0)
    assert not support(everything).update(image, road(), 0.0)
