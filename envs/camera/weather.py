"""Weather: CARLA's factors and presets, and weather files.

Names, ranges and presets are those of CARLA 0.9.16 (`carla.WeatherParameters`, PythonAPI/docs/weather.yml), except
`wetness`, which CARLA leaves at 0 in rain, the sun's azimuth, which it leaves to the map, and the fog at night, where
CARLA's 60 to 100 would leave a visibility of 50 to 550 m here. FoggyNoon and Dusk are ours. Physical meanings:
`vpf_sim.envs.camera.atmosphere`.
"""

from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from vpf_sim import configuration
from vpf_sim.configuration import STRICT
from vpf_sim.errors import InputError, unknown_name

Percent = Annotated[float, Field(ge=0.0, le=100.0)]


class Weather(BaseModel):
    """The weather of one episode. Factors without a unit range from 0 to 100."""

    model_config = ConfigDict(**STRICT, frozen=True)

    name: str = Field(description="Name in tables and records; by default that of the file.")
    cloudiness: Percent = Field(
        default=0.0,
        description="Share of the light that comes from all of the sky instead of the sun: 0 is clear, 100 overcast.",
    )
    precipitation: Percent = Field(
        default=0.0,
        description="Rain of 50 (p / 100)^2 mm/h: 30 is 4.5 mm/h (moderate), 60 is 18 (heavy), 100 is 50 (violent).",
    )
    precipitation_deposits: Percent = Field(
        default=0.0, description="Puddles, in places that belong to the road; a larger value covers more of the road."
    )
    wind_intensity: Percent = Field(default=0.0, description="Wind of 0 to 15 m/s, which slants the rain.")
    fog_density: Percent = Field(
        default=0.0,
        description="Visibility in fog, 20 km x (50 m / 20 km)^(f / 100): 2 is 17.7 km, 60 is 550 m, 100 is 50 m.",
    )
    wetness: Percent = Field(
        default=0.0,
        description="Wetness of the road, which darkens it and reflects; at least that of rain and puddles.",
    )
    sun_altitude_angle: float = Field(
        default=45.0,
        ge=-90.0,
        le=90.0,
        description="Degrees of the sun above the horizon: -6 is dusk, -90 night; lamps are on below 1000 lx.",
    )
    sun_azimuth_angle: float = Field(
        default=215.0, ge=0.0, le=360.0, description="Degrees of the sun clockwise from the world's X axis."
    )
    droplets: Percent = Field(
        default=0.0,
        description="Drops on the windscreen: as many as rain of this precipitation brings.",
    )
    wiper_period_s: float = Field(
        default=0.0,
        ge=0.0,
        le=60.0,
        description="Time between two sweeps of the wiper; 0 is off, 1.33 and 0.92 are 45 and 65 cycles a minute.",
    )
    streak_gain: float = Field(
        default=1.0,
        ge=0.0,
        le=20.0,
        description="Brightness of falling drops; 1 is physical, CARLA's rain is much brighter.",
    )
    road_friction: float | None = Field(
        default=None,
        ge=0.05,
        le=2.0,
        description="Grip of the ego's tyres, their largest acceleration / g; by default they never slip.",
    )


def _preset(
    name: str,
    cloud: float,
    rain: float,
    deposits: float,
    wind: float,
    altitude: float,
    fog: float,
    wiper_s: float = 0.0,
) -> Weather:
    return Weather(
        name=name,
        cloudiness=cloud,
        precipitation=rain,
        precipitation_deposits=deposits,
        wind_intensity=wind,
        fog_density=fog,
        wetness=max(rain, deposits),
        sun_altitude_angle=altitude,
        droplets=rain,
        wiper_period_s=wiper_s,
    )


SLOW_WIPER_S, FAST_WIPER_S, INTERVAL_WIPER_S = 1.33, 0.92, 4.0  # 45 and 65 cycles a minute; FMVSS 104 S4.1.1
PRESETS = {
    weather.name: weather
    for weather in (
        # name, cloudiness, precipitation, deposits, wind, sun's altitude, fog, wiper
        _preset("ClearNoon", 5, 0, 0, 10, 45, 2),
        _preset("CloudyNoon", 60, 0, 0, 10, 45, 3),
        _preset("WetNoon", 5, 0, 50, 10, 45, 3),
        _preset("WetCloudyNoon", 60, 0, 50, 10, 45, 3),
        _preset("SoftRainNoon", 20, 30, 50, 30, 45, 3, INTERVAL_WIPER_S),
        _preset("MidRainyNoon", 60, 60, 60, 60, 45, 3, SLOW_WIPER_S),
        _preset("HardRainNoon", 100, 100, 90, 100, 45, 7, FAST_WIPER_S),
        _preset("FoggyNoon", 80, 0, 0, 10, 45, 70),
        _preset("ClearSunset", 5, 0, 0, 10, 15, 2),
        _preset("CloudySunset", 60, 0, 0, 10, 15, 3),
        _preset("WetSunset", 5, 0, 50, 10, 15, 2),
        _preset("WetCloudySunset", 60, 0, 50, 10, 15, 2),
        _preset("SoftRainSunset", 20, 30, 50, 30, 15, 2, INTERVAL_WIPER_S),
        _preset("MidRainSunset", 60, 60, 60, 60, 15, 3, SLOW_WIPER_S),
        _preset("HardRainSunset", 100, 100, 90, 100, 15, 7, FAST_WIPER_S),
        _preset("ClearDusk", 5, 0, 0, 10, -6, 2),
        _preset("WetDusk", 5, 0, 50, 10, -6, 2),
        _preset("ClearNight", 5, 0, 0, 10, -90, 2),
        _preset("CloudyNight", 60, 0, 0, 10, -90, 3),
        _preset("WetNight", 5, 0, 50, 10, -90, 3),
        _preset("WetCloudyNight", 60, 0, 50, 10, -90, 3),
        _preset("SoftRainNight", 60, 30, 50, 30, -90, 3, INTERVAL_WIPER_S),
        _preset("MidRainyNight", 80, 60, 60, 60, -90, 3, SLOW_WIPER_S),
        _preset("HardRainNight", 100, 100, 90, 100, -90, 7, FAST_WIPER_S),
    )
}
ALIASES = {"clear": "ClearNoon", "cloudy": "CloudyNoon", "rain": "HardRainNoon", "MidRainNoon": "MidRainyNoon"}


def names() -> list[str]:
    """Names of the presets and their aliases."""
    return sorted([*PRESETS, *ALIASES])


def load(name_or_path: str | Path | Weather) -> Weather:
    """The weather of a preset, an alias or a TOML file (`base` and factors); a Weather is returned as it is."""
    if isinstance(name_or_path, Weather):
        return name_or_path
    if not isinstance(name_or_path, str | Path):
        raise InputError(f"weather: expected a name, a TOML file or a Weather, got {name_or_path!r}")
    name_or_path = str(name_or_path)
    name, path = ALIASES.get(name_or_path, name_or_path), Path(name_or_path)
    if name in PRESETS:
        return PRESETS[name]
    if path.suffix != ".toml" and not path.is_file():
        raise unknown_name("weather", name_or_path, names())
    return _read(path)


def _read(path: Path) -> Weather:
    content = configuration.read_file(path, "weather")
    base = content.pop("base", "ClearNoon")
    if not isinstance(base, str):
        raise InputError(f"{path}: base: expected the name of a weather, got {base!r}")
    if base not in names():
        raise InputError(f"{path}: base: {unknown_name('weather', base, names())}")
    factors = {**load(base).model_dump(), "name": path.stem, **content}
    return configuration.build(Weather, factors, str(path), also=("base",))
