"""A weather's factors in physical units and as a line of text."""

from math import hypot

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.weather import ALIASES, PRESETS, Weather

FOG_FROM_M = 5000.0  # a lower visibility is mentioned
NIGHT_DEG = -12.0  # end of nautical twilight
BREEZE_MPS = 4.0  # a stronger wind is mentioned


def physical(weather: Weather) -> dict[str, float]:
    """The factors in the units of their keys, as `vpf_sim.envs.camera.atmosphere` interprets them.

    `visibility_m` is through fog and rain together: the distance at which contrast falls to 5 %.
    """
    air = Atmosphere.of(weather)
    meaning = {
        "rain_mmph": air.rain_mmph,
        "fog_visibility_m": air.visibility_m,
        "visibility_m": 3.0 / air.extinction_per_m,
        "extinction_per_km": 1e3 * air.extinction_per_m,
        "wind_mps": hypot(*air.wind_mps),
        "wetness": air.wetness,
        "puddles": air.puddles,
        "sun_altitude_deg": weather.sun_altitude_angle,
        "wiper_cycles_per_min": 60.0 / weather.wiper_period_s if weather.wiper_period_s else 0.0,
    }
    return {key: float(f"{value:.4g}") for key, value in meaning.items()}


def factors(weather: Weather) -> tuple[tuple[str, str, str], ...]:
    """(name, value, meaning) of each factor, in physical units where it has them."""
    found = physical(weather)
    friction = weather.road_friction
    meaning = {
        "cloudiness": "0 clear, 100 overcast",
        "precipitation": f"{found['rain_mmph']:g} mm/h of rain",
        "precipitation_deposits": "puddles; 100 is the maximum",
        "wind_intensity": f"{found['wind_mps']:g} m/s",
        "fog_density": f"visibility {_distance(found['fog_visibility_m'])}",
        "wetness": "of the road between the puddles",
        "sun_altitude_angle": "degrees above the horizon; lamps are on below about 0",
        "sun_azimuth_angle": "degrees clockwise from the world's X axis",
        "droplets": "drops on the windscreen, as many as rain of this precipitation brings",
        "wiper_period_s": f"{found['wiper_cycles_per_min']:.0f} cycles a minute" if weather.wiper_period_s else "off",
        "streak_gain": "factor on the brightness of falling drops",
        "road_friction": "the tyres never slip" if friction is None else "grip of the tyres",
    }
    if found["rain_mmph"] > 0.0:
        meaning["fog_density"] += f"; in this rain {_distance(found['visibility_m'])}"
    values = weather.model_dump(exclude={"name"})
    return tuple((key, "-" if value is None else f"{value:g}", meaning[key]) for key, value in values.items())


def aliases(weather: Weather) -> list[str]:
    """The other names of a preset; empty for a weather file."""
    return sorted(alias for alias, name in ALIASES.items() if PRESETS[name] == weather)


def in_words(weather: Weather) -> str:
    """Sky, sun, rain, fog, wind, road and windscreen in one line."""
    meaning = physical(weather)
    parts = [_sky(weather.cloudiness), _sun(weather.sun_altitude_angle), *_rain(meaning["rain_mmph"])]
    if (visibility_m := meaning["fog_visibility_m"]) < FOG_FROM_M:
        parts.append(f"fog, visibility {_distance(visibility_m)}")
    if meaning["wind_mps"] >= BREEZE_MPS:
        parts.append(f"wind {meaning['wind_mps']:g} m/s")
    if meaning["wetness"] > 0.0:
        parts.append("wet road" if meaning["puddles"] == 0.0 else "wet road with puddles")
    if weather.droplets > 0.0:
        parts.append("drops on the windscreen")
    if weather.wiper_period_s > 0.0:
        parts.append(f"wipers every {weather.wiper_period_s:g} s")
    return ", ".join(parts)


def _distance(metres: float) -> str:
    """A distance with two digits."""
    rounded = float(f"{metres:.2g}")
    return f"{rounded:g} m" if rounded < 1000.0 else f"{rounded / 1000.0:g} km"


def _sky(cloudiness: float) -> str:
    return "clear sky" if cloudiness < 15.0 else "overcast" if cloudiness >= 90.0 else "clouds"


def _sun(altitude_deg: float) -> str:
    if altitude_deg >= 0.0:
        return f"sun {altitude_deg:g}° high"
    return "night" if altitude_deg < NIGHT_DEG else f"dusk, sun {-altitude_deg:g}° below the horizon"


def _rain(rate_mmph: float) -> list[str]:
    """Rain rate in the terms of weather services: heavy from 10, violent from 50 mm/h."""
    if rate_mmph == 0.0:
        return []
    strength = "light" if rate_mmph < 2.0 else "moderate" if rate_mmph < 10.0 else "heavy"
    return [f"{'violent' if rate_mmph >= 50.0 else strength} rain of {rate_mmph:g} mm/h"]
