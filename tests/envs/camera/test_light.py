"""Light and daylight against closed forms, and their effect on frames."""

from math import exp, radians, sin, sqrt

import numpy as np
import pytest
from highway_scenes import add_ego, add_object, straight_road

from vpf_sim.envs.camera import Renderer, Rig, weather
from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.daylight import Daylight, sun_colour
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.types import Camera, Floats


def sky(**factors: float) -> Weather:
    return Weather(name="sky", **factors)


def light(name: str) -> Light:
    return Light.of(weather.load(name))


def daylight(**factors: float) -> Daylight:
    return Daylight.of(sky(**factors), Atmosphere.of(sky(**factors)))


@pytest.mark.parametrize(
    ("altitude_deg", "azimuth_deg", "towards"),
    [(0.0, 0.0, (1, 0, 0)), (0.0, 90.0, (0, 1, 0)), (90.0, 10.0, (0, 0, 1)), (45.0, 180.0, (-(0.5**0.5), 0, 0.5**0.5))],
)
def test_the_sun_stands_at_its_altitude_and_clockwise_azimuth(
    altitude_deg: float, azimuth_deg: float, towards: tuple[float, float, float]
) -> None:
    assert Light.of(sky(sun_altitude_angle=altitude_deg, sun_azimuth_angle=azimuth_deg)).sun == pytest.approx(towards)


@pytest.mark.parametrize("altitude_deg", [10.0, 30.0, 60.0])
def test_clear_sky_matches_the_ies_model(altitude_deg: float) -> None:
    height = sin(radians(altitude_deg))
    fog_left = exp(-3.0 / 20_000.0 * 200.0 / height)  # of the clearest air there is
    sun = 133.8 * exp(-0.21 / height)
    got = daylight(sun_altitude_angle=altitude_deg)
    assert got.sun_klx == pytest.approx(fog_left * sun)
    assert got.sky_klx == pytest.approx(0.8 + 15.5 * sqrt(height) + 0.5 * (1.0 - fog_left) * sun * height)
    assert got.ground_klx == pytest.approx(got.sun_klx * height + got.sky_klx)


def test_an_overcast_sky_has_no_sun() -> None:
    got = daylight(cloudiness=100.0, sun_altitude_angle=30.0)
    assert got.sun_klx == 0.0
    assert got.sky_klx == got.ground_klx == pytest.approx(0.3 + 21.0 * 0.5)
    overcast = Light.of(sky(cloudiness=100.0))
    assert overcast.shadow == 1.0
    assert not overcast.direct.any()


def test_sun_and_sky_stand_about_four_to_one_at_clear_noon() -> None:
    noon = Daylight.of(weather.load("ClearNoon"), Atmosphere.of(weather.load("ClearNoon")))
    assert 3.0 < noon.ground_klx / noon.sky_klx - 1.0 < 6.0


def test_sun_reddens_as_it_sinks_from_the_white_balance() -> None:
    assert sun_colour(45.0) == pytest.approx([1.0, 1.0, 1.0])
    ratios = [sun_colour(altitude)[0] / sun_colour(altitude)[2] for altitude in (60.0, 45.0, 30.0, 15.0, 5.0)]
    assert np.all(np.diff(ratios) > 0.0)
    # Rayleigh's depths at 610 and 465 nm are 0.064 and 0.19, the haze's 0.19 and 0.27; the path grows from 1.41 to 3.86
    assert ratios[3] == pytest.approx(exp((0.194 + 0.271 - 0.064 - 0.190) * (3.864 - 1.414)), rel=0.02)


def test_no_preset_by_day_is_over_or_under_exposed() -> None:
    for name in (name for name in weather.PRESETS if not light(name).has_lamps):
        assert np.all((light(name).ground > 0.5) & (light(name).ground < 1.1)), name
        assert np.all((light(name).horizon > 140.0) & (light(name).horizon < 245.0)), name


def test_hard_rain_is_flat_grey_and_darker_than_clear_noon() -> None:
    rain, clear = light("HardRainNoon"), light("ClearNoon")
    assert rain.shadow > 0.99
    assert clear.shadow < 0.6
    assert np.ptp(rain.horizon) < 12.0
    assert rain.ground.mean() < 0.85 * clear.ground.mean()
    assert rain.horizon.mean() < clear.horizon.mean() - 20.0


def test_sunset_is_warm() -> None:
    for name in ("ClearSunset", "CloudySunset"):
        sunset, noon = light(name), light(name.replace("Sunset", "Noon"))
        for colour in ("ground", "horizon"):
            assert warmth(getattr(sunset, colour)) > warmth(getattr(noon, colour)) + 0.05, name
    assert warmth(light("ClearSunset").direct) > 1.3


def warmth(colour: Floats) -> float:
    return float(colour[0] / colour[2])


def test_it_gets_dark_after_sunset() -> None:
    levels = [Light.of(sky(sun_altitude_angle=altitude)).ground.mean() for altitude in (-2.0, -6.0, -12.0, -90.0)]
    assert np.all(np.diff(levels) < 0.0)
    assert levels[-1] < 1e-3


@pytest.mark.parametrize("name", weather.PRESETS)
def test_light_of_every_weather_is_in_image_units(name: str) -> None:
    of = light(name)
    for colour in (of.horizon, of.zenith, of.gap, of.cloud):
        assert np.all((colour >= 0.0) & (colour <= 255.0))
    assert 0.0 < of.contact < of.shadow <= 1.0
    assert of.ground == pytest.approx(of.sky + of.direct * of.sun[2])


@pytest.mark.parametrize("altitude_deg", [20.0, 45.0])
def test_shadow_length_grows_as_the_sun_sinks(altitude_deg: float) -> None:
    """A van 2.3 m high throws it to the left across the road, over its height / tangent of the altitude; its rounded
    top takes up to a quarter off."""
    at = sky(sun_altitude_angle=altitude_deg, sun_azimuth_angle=90.0)
    pictures = []
    for kinds in (["van"], []):
        road = straight_road()
        for kind in kinds:
            add_object(road, kind, [32.0, 10.6])
        ego = add_ego(road, [20.0, 3.5])
        pictures.append(Renderer(road, Rig(Camera(), noise_sd=0.0), at, 1).render(ego, 0.0).mean(axis=2))
    forward = 32.0 - 20.0 - 0.8
    row = round(239.5 + 320.0 * 1.4 / forward)
    tip = int(np.argmax(pictures[0][row] < 0.85 * pictures[1][row]))
    length = 10.6 - 1.05 - (3.5 + forward * (tip - 319.5) / 320.0)
    assert 0.75 < length * np.tan(radians(altitude_deg)) / 2.3 < 1.02
