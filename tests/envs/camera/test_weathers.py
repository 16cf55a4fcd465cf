"""Weathers: CARLA's presets, physical meanings, and errors of invalid files."""

import json
from dataclasses import dataclass
from pathlib import Path

import pytest

from vpf_sim import cli
from vpf_sim.envs.camera import weather
from vpf_sim.errors import InputError
from vpf_sim.gallery.weather_meaning import aliases, in_words, physical

# Read out of the official `carla` 0.9.16 wheel (LibCarla/source/carla/rpc/WeatherParameters.cpp): cloudiness,
# precipitation, precipitation_deposits, wind_intensity, sun_altitude_angle, fog_density.
CARLA = {
    "ClearNoon": (5, 0, 0, 10, 45, 2),
    "CloudyNoon": (60, 0, 0, 10, 45, 3),
    "WetNoon": (5, 0, 50, 10, 45, 3),
    "WetCloudyNoon": (60, 0, 50, 10, 45, 3),
    "SoftRainNoon": (20, 30, 50, 30, 45, 3),
    "MidRainyNoon": (60, 60, 60, 60, 45, 3),
    "HardRainNoon": (100, 100, 90, 100, 45, 7),
    "ClearSunset": (5, 0, 0, 10, 15, 2),
    "CloudySunset": (60, 0, 0, 10, 15, 3),
    "WetSunset": (5, 0, 50, 10, 15, 2),
    "WetCloudySunset": (60, 0, 50, 10, 15, 2),
    "SoftRainSunset": (20, 30, 50, 30, 15, 2),
    "MidRainSunset": (60, 60, 60, 60, 15, 3),
    "HardRainSunset": (100, 100, 90, 100, 15, 7),
}
# The same of CARLA's nights, without their fog of 60 to 100, which here would hide the road.
CARLA_NIGHTS = {
    "ClearNight": (5, 0, 0, 10, -90),
    "CloudyNight": (60, 0, 0, 10, -90),
    "WetNight": (5, 0, 50, 10, -90),
    "WetCloudyNight": (60, 0, 50, 10, -90),
    "SoftRainNight": (60, 30, 50, 30, -90),
    "MidRainyNight": (80, 60, 60, 60, -90),
    "HardRainNight": (100, 100, 90, 100, -90),
}
PERCENT = (
    "cloudiness",
    "precipitation",
    "precipitation_deposits",
    "wind_intensity",
    "fog_density",
    "wetness",
    "droplets",
)


def test_presets_are_carlas_plus_fog_and_dusk() -> None:
    assert set(weather.PRESETS) == {*CARLA, *CARLA_NIGHTS, "FoggyNoon", "ClearDusk", "WetDusk"}
    assert all(preset.name == name for name, preset in weather.PRESETS.items())


@pytest.mark.parametrize("name", CARLA)
def test_a_preset_has_carlas_numbers(name: str) -> None:
    one = weather.load(name)
    factors = (one.cloudiness, one.precipitation, one.precipitation_deposits, one.wind_intensity)
    assert (*factors, one.sun_altitude_angle, one.fog_density) == CARLA[name]
    assert one.wetness == max(one.precipitation, one.precipitation_deposits), "CARLA leaves it 0 in rain"


@pytest.mark.parametrize("name", CARLA_NIGHTS)
def test_a_night_has_carlas_numbers_and_the_fog_of_the_day(name: str) -> None:
    one = weather.load(name)
    factors = (one.cloudiness, one.precipitation, one.precipitation_deposits, one.wind_intensity)
    assert (*factors, one.sun_altitude_angle) == CARLA_NIGHTS[name]
    assert one.fog_density == weather.load(name.replace("Night", "Noon")).fog_density


@pytest.mark.parametrize("name", weather.PRESETS)
def test_it_rains_on_the_glass_where_it_rains(name: str) -> None:
    one = weather.load(name)
    assert (one.droplets > 0.0) == (one.wiper_period_s > 0.0) == (one.precipitation > 0.0)
    assert one.streak_gain == 1.0
    assert one.road_friction is None, "grip is another switch than the picture"


def test_each_alias_is_a_preset() -> None:
    meant = {"clear": "ClearNoon", "cloudy": "CloudyNoon", "rain": "HardRainNoon", "MidRainNoon": "MidRainyNoon"}
    assert {alias: weather.load(alias).name for alias in meant} == meant == weather.ALIASES
    assert aliases(weather.load("HardRainNoon")) == ["rain"]
    assert aliases(weather.load("WetNoon")) == []


RANGES = {
    **dict.fromkeys(PERCENT, (0.0, 100.0)),
    "sun_altitude_angle": (-90.0, 90.0),
    "sun_azimuth_angle": (0.0, 360.0),
    "wiper_period_s": (0.0, 60.0),
}


@dataclass
class Edge:
    key: str
    bound: float
    beyond: float
    words: str


EDGES = [
    Edge(key, bound, bound + sign, f"{words} {bound:g}")
    for key, (low, high) in RANGES.items()
    for bound, sign, words in ((low, -0.5, ">="), (high, 0.5, "<="))
]


@pytest.mark.parametrize("edge", EDGES, ids=lambda edge: f"{edge.key}-{edge.bound:g}")
def test_factor_is_accepted_within_its_range_only(edge: Edge, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(f"{edge.key} = {edge.bound}\n")
    assert getattr(weather.load(str(path)), edge.key) == edge.bound
    path.write_text(f"{edge.key} = {edge.beyond}\n")
    with pytest.raises(InputError) as error:
        weather.load(str(path))
    assert str(error.value) == f"{path}: {edge.key}: expected {edge.words}, got {edge.beyond}"


@pytest.mark.parametrize("value", ["nan", "inf", "-inf"])
@pytest.mark.parametrize("key", [*RANGES, "streak_gain", "road_friction"])
def test_non_finite_factor_is_rejected(key: str, value: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(f"{key} = {value}\n")
    with pytest.raises(InputError, match=f"{key}: expected "):
        weather.load(str(path))


@pytest.mark.parametrize(("precipitation", "rain_mmph"), [(0, 0.0), (30, 4.5), (60, 18.0), (100, 50.0)])
def test_rain_in_mm_an_hour(precipitation: float, rain_mmph: float) -> None:
    assert physical(weather.Weather(name="mine", precipitation=precipitation))["rain_mmph"] == pytest.approx(rain_mmph)


@pytest.mark.parametrize(("fog", "visibility_m"), [(2, 17700.0), (7, 13000.0), (30, 3300.0), (60, 550.0), (100, 50.0)])
def test_fog_in_m(fog: float, visibility_m: float) -> None:
    found = physical(weather.Weather(name="mine", fog_density=fog))
    assert found["fog_visibility_m"] == pytest.approx(visibility_m, rel=0.02)
    assert found["visibility_m"] == pytest.approx(found["fog_visibility_m"], rel=1e-3), "without rain the same"


def test_wind_wetness_and_wipers_have_units() -> None:
    found = physical(weather.Weather(name="mine", wind_intensity=60.0, precipitation_deposits=40.0, wiper_period_s=1.5))
    assert (found["wind_mps"], found["wetness"], found["puddles"]) == (9.0, 0.4, 0.4)
    assert found["wiper_cycles_per_min"] == 40.0


def test_a_weather_in_words() -> None:
    assert in_words(weather.load("clear")) == "clear sky, sun 45° high"
    assert in_words(weather.load("ClearNight")) == "clear sky, night"
    assert in_words(weather.load("ClearDusk")) == "clear sky, dusk, sun 6° below the horizon"
    assert in_words(weather.load("rain")) == (
        "overcast, sun 45° high, violent rain of 50 mm/h, wind 15 m/s, wet road with puddles, drops on the windscreen, "
        "wipers every 0.92 s"
    )
    assert "fog, visibility 550 m" in in_words(weather.Weather(name="mine", fog_density=60.0))
    assert "wet road" in in_words(weather.Weather(name="mine", wetness=5.0))


def test_show_prints_factors_and_their_meaning(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (["weathers", "show", "rain"], ["weathers", "show", "rain", "--json"]):
        assert cli.run(arguments) == 0
        shown = json.loads(capsys.readouterr().out)
        assert weather.Weather.model_validate({key: shown[key] for key in weather.Weather.model_fields}) == (
            weather.load("rain")
        )
        assert shown["aliases"] == ["rain"]
        assert shown["physical"]["rain_mmph"] == 50.0
        assert shown["meaning"] == in_words(weather.load("rain"))


def test_list_names_each_weather_with_its_alias(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["weathers", "list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[2:]] == list(weather.PRESETS)
    assert any(line.startswith("HardRainNoon") and line.split()[1] == "rain" for line in lines)
    assert cli.run(["weathers", "list", "--json"]) == 0
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)["weathers"]}
    assert set(rows) == set(weather.names())
    assert (rows["rain"]["preset"], rows["HardRainNoon"]["preset"]) == ("HardRainNoon", "HardRainNoon")
