"""The low beam against the limits of UN Regulation 112, and the light of two lamps against its formula."""

from math import radians, tan

import numpy as np
import pytest
from highway_scenes import straight_road

from vpf_sim.envs.camera import weather
from vpf_sim.envs.camera.layout import lane_shapes
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.night.lamplight import LAMP_ASIDE_M, LAMP_HEIGHT_M, Lamplight
from vpf_sim.envs.camera.night.low_beam import intensity_cd
from vpf_sim.envs.camera.scenery.furniture import LAMP_HEIGHT_M as POST_M
from vpf_sim.envs.camera.scenery.verge import Verge, lamp_places
from vpf_sim.envs.camera.view import View
from vpf_sim.seeding import stream
from vpf_sim.types import Camera, Floats

NO_POSTS = np.empty((0, 3))

# UN Regulation 112, class B, right-hand traffic: degrees right and up, least and most cd of one lamp.
POINTS = {
    "B50L": (-3.43, 0.57, 0.0, 350.0),
    "75R": (1.15, -0.57, 10_100.0, np.inf),
    "75L": (-3.43, -0.57, 0.0, 10_600.0),
    "50L": (-3.43, -0.86, 0.0, 13_200.0),
    "50R": (1.72, -0.86, 10_100.0, np.inf),
    "50V": (0.0, -0.86, 5_100.0, np.inf),
    "25L": (-9.0, -1.72, 1_700.0, np.inf),
    "25R": (9.0, -1.72, 1_700.0, np.inf),
    "zone III": (-6.0, 2.0, 0.0, 625.0),
    "zone IV, left": (-5.15, -0.86, 2_500.0, np.inf),
    "zone IV, right": (5.15, -1.72, 2_500.0, np.inf),
    "zone I": (0.0, -3.0, 0.0, 17_600.0),
}


def slope(degrees: float) -> Floats:
    return np.array(tan(radians(degrees)))


def night() -> Light:
    return Light.of(weather.load("ClearNight"))


def place(ahead_m: float, right_m: float = 0.0, up_m: float = 0.0) -> Floats:
    """(1, 3) a world point ahead of the lamps of a car at the origin."""
    return np.array([[2.2 + ahead_m, right_m, up_m]])


def view() -> View:
    return View.at(Camera(), np.zeros(2), 0.0)


@pytest.mark.parametrize("name", POINTS)
def test_low_beam_meets_the_regulation(name: str) -> None:
    right_deg, up_deg, least, most = POINTS[name]
    assert least <= float(intensity_cd(slope(right_deg), slope(up_deg))) <= most


def test_cut_off_rises_to_the_right_only() -> None:
    just_above = slope(-0.2)  # the cut-off is 0.57 deg down on the left
    assert intensity_cd(slope(4.0), just_above) > 5.0 * intensity_cd(slope(-4.0), just_above)


@pytest.mark.parametrize(("ahead_m", "right_m"), [(10.0, 0.0), (20.0, -1.5), (35.0, 3.0)])
def test_illuminance_is_intensity_over_squared_distance_of_both_lamps(ahead_m: float, right_m: float) -> None:
    expected = 0.0
    for lamp in (-LAMP_ASIDE_M, LAMP_ASIDE_M):
        aside, up = right_m - lamp, -LAMP_HEIGHT_M
        cd = float(intensity_cd(np.array(aside / ahead_m), np.array(up / ahead_m)))
        expected += cd / (ahead_m**2 + aside**2 + up**2)
    found = Lamplight(night(), NO_POSTS).beam_lx(view(), place(ahead_m, right_m))
    assert found == pytest.approx([expected])


def test_beam_turns_with_the_car() -> None:
    lamps, turned = Lamplight(night(), NO_POSTS), View.at(Camera(), np.array([5.0, 7.0]), np.pi / 2)
    point = np.array([[5.0 - 3.0, 7.0 + 2.2 + 20.0, 0.0]])  # 20 m ahead of the lamps and 3 m right
    assert lamps.beam_lx(turned, point) == pytest.approx(lamps.beam_lx(view(), place(20.0, 3.0)))


def test_low_beam_reaches_50_to_70_m_in_the_own_lane_and_farther_on_the_right() -> None:
    """The cut-off, 1 % down from 0.65 m, meets the road 65 m ahead; 3 lx are what a driver sees by."""
    lamps, places = Lamplight(night(), NO_POSTS), np.arange(5.0, 150.0, 0.5)
    for right_m, low, high in ((0.0, 50.0, 68.0), (-3.5, 45.0, 68.0), (3.5, 60.0, 140.0)):
        points = np.stack([2.2 + places, np.full(len(places), right_m), np.zeros(len(places))], axis=1)
        lit = places[lamps.beam_lx(view(), points) > 3.0]
        assert low < lit.max() < high, right_m


def test_light_falls_off_with_distance_and_height_and_is_dark_behind() -> None:
    lamps = Lamplight(night(), NO_POSTS)
    by_distance = [float(lamps.beam_lx(view(), place(m))[0]) for m in (5, 10, 20, 40, 60)]
    assert np.all(np.diff(by_distance) < 0.0)
    by_height = [float(lamps.beam_lx(view(), place(15.0, -1.0, m))[0]) for m in (0.4, 0.6, 5.0)]
    assert by_height[0] > 5.0 * by_height[1] > by_height[2]
    assert lamps.beam_lx(view(), np.array([[-10.0, 0.0, 0.0]])) == pytest.approx([0.0])


def test_street_lamps_hang_over_the_road_from_their_posts() -> None:
    seeds = [seed for seed in range(8) if len(places_of(seed))]
    assert seeds, "half of all roads have lamp posts"
    lamps = places_of(seeds[0])
    assert np.all(np.abs(lamps[:, 2] - POST_M) < 0.2)
    edge = max(float(shape.right_m[:, 1].max()) for shape in lane_shapes(straight_road()))
    assert np.all(lamps[:, 1] < edge + 1.0)


def places_of(seed: int) -> Floats:
    return lamp_places(Verge(lane_shapes(straight_road())).furniture(stream(seed, "scenery")))
