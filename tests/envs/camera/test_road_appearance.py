"""Verges, road surfaces and markings as set by the scenario."""

from contextlib import closing

import numpy as np
import pytest
from highway_env.road.lane import LineType

from vpf_sim import scenarios
from vpf_sim.envs.camera.ground.appearance import SURFACES, VERGES, ramp
from vpf_sim.envs.camera.ground.palette import RAMP
from vpf_sim.envs.four_lane import FourLane
from vpf_sim.envs.road import Carriageway
from vpf_sim.scenarios.parts import RoadAppearance
from vpf_sim.types import Floats

ROAD = """
schema = 1
[road]
segments = [{{kind = "line", length_m = 120}}]
{look}
[goal]
s_m = 60.0
"""


def frame(look: str = "") -> Floats:
    with closing(FourLane(scenarios.parse(ROAD.format(look=look), "a road"))) as env:
        return env.reset(seed=2)[0]["image"].astype(float)


def verge(picture: Floats) -> Floats:
    """(3,) the mean colour right of the road, near."""
    return np.asarray(picture[270:300, 600:].mean(axis=(0, 1)))


def road(picture: Floats) -> Floats:
    """(3,) the median colour of the own lane, near."""
    return np.asarray(np.median(picture[360:460, 260:380], axis=(0, 1)))


@pytest.fixture(scope="module")
def plain() -> Floats:
    return frame()


def test_default_appearance_is_the_palette_ramp() -> None:
    assert np.array_equal(ramp(RoadAppearance()), RAMP)


def test_verge_can_be_set(plain: Floats) -> None:
    red, green, blue = verge(plain)
    assert green > blue + 15.0
    for name in VERGES:
        picture = frame(f'[road.look]\nverge = "{name}"')
        red, green, blue = verge(picture)
        assert red >= green - 6.0
        assert np.abs(verge(picture) - verge(plain)).max() > 15.0
        assert road(picture) == pytest.approx(road(plain), abs=3.0)


def test_road_surface_can_be_set(plain: Floats) -> None:
    concrete, dark = (road(frame(f'[road.look]\nsurface = "{name}"')) for name in SURFACES)
    assert concrete.mean() > road(plain).mean() + 30.0
    assert dark.mean() < road(plain).mean() - 30.0


def test_worn_paint_has_less_contrast(plain: Floats) -> None:
    worn = frame("[road.look]\nworn = true")
    below = slice(300, 460)
    stands_out = [np.percentile(one[below, :, 1], 99.7) - np.median(one[360:460, 260:380, 1]) for one in (plain, worn)]
    assert stands_out[1] < 0.7 * stands_out[0]
    assert verge(worn) == pytest.approx(verge(plain), abs=1.0)


@pytest.mark.parametrize(
    ("painted", "left", "right"),
    [("both", True, True), ("left", True, False), ("right", False, True), ("none", False, False)],
)
def test_an_edge_line_may_be_missing(painted: str, left: bool, right: bool) -> None:
    scenario = scenarios.parse(ROAD.format(look=f'[road.look]\nedge_lines = "{painted}"'), "a road").draw(0)
    lanes = [Carriageway(scenario.road).get_lane(("start", "end", index)) for index in range(4)]
    assert (lanes[0].line_types[0] == LineType.CONTINUOUS_LINE) == left
    assert (lanes[3].line_types[1] == LineType.CONTINUOUS_LINE) == right
    assert {lanes[0].line_types[1], lanes[1].line_types[0], lanes[3].line_types[0]} == {LineType.STRIPED}
