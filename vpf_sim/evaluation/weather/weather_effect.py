"""The effect of weather on tracking and the paper's perception, each factor alone and together.

The same drive is rendered in every weather with the same poses and seed, so all differences come from the weather.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

from vpf_sim import scenarios
from vpf_sim.envs.camera import Weather
from vpf_sim.envs.camera import weather as weathers
from vpf_sim.evaluation.rendering.scripted import Path, ScriptedDrive, smooth_step
from vpf_sim.evaluation.weather.scorer import Score, TrackingScorer
from vpf_sim.perception.egomotion.flow import grey
from vpf_sim.scenarios.parts import ObjectSpec
from vpf_sim.types import Image

DRY = {"precipitation": 0.0, "precipitation_deposits": 0.0, "wetness": 0.0, "droplets": 0.0, "wiper_period_s": 0.0}


def _changed(**update: float) -> Weather:
    """Clear weather with some factors changed."""
    return weathers.load("ClearNoon").model_copy(update={**DRY, **update})


CLEAR = _changed()


@dataclass(frozen=True, slots=True)
class Factor:
    """One row: a weather, the weather without the factor, the sensor noise (None: default), and traffic or not."""

    name: str
    weather: Weather
    without: Weather = CLEAR
    noise_sd: float | None = None  # grey levels
    traffic: bool = True


def factors() -> list[Factor]:
    """Clear weather, every factor alone, and weathers that combine them."""
    return [*_single_factors(), *(Factor(name, weathers.load(name)) for name in TOGETHER)]


TOGETHER = ("WetNoon", "SoftRainNoon", "MidRainyNoon", "HardRainNoon", "FoggyNoon", "ClearSunset", "HardRainSunset")


def _single_factors() -> list[Factor]:
    hard = {"precipitation": 100.0, "wind_intensity": 100.0}
    rain = _changed(**hard, streak_gain=0.0)  # rain also wets the road and adds haze
    return [
        Factor("clear", CLEAR),
        Factor("no noise", CLEAR, noise_sd=0.0),
        Factor("noise of sd 4", CLEAR, noise_sd=4.0),
        Factor("slippery road", _changed(road_friction=0.4)),
        Factor("wiper on dry glass", _changed(wiper_period_s=weathers.FAST_WIPER_S)),
        Factor("haze: fog of 50", _changed(fog_density=50.0)),
        Factor("haze: fog of 80", _changed(fog_density=80.0)),
        Factor("wet road reflections", _changed(wetness=100.0), traffic=False),
        Factor("puddles", _changed(precipitation_deposits=90.0), traffic=False),
        Factor("spray of traffic", _changed(wetness=100.0)),
        Factor("wet road and haze", rain),
        Factor("streaks", _changed(**hard), rain),
        Factor("streaks x 8", _changed(**hard, streak_gain=8.0), rain),
        Factor("droplets of 20", _changed(droplets=20.0)),
        Factor("droplets", _changed(droplets=100.0)),
        Factor("droplets, wiper", _changed(droplets=100.0, wiper_period_s=weathers.FAST_WIPER_S)),
    ]


def drive(traffic: bool = True) -> ScriptedDrive:
    """From town04's first bend past its second obstacle, with overtaking traffic and a parked truck ahead."""
    scenario = scenarios.drawn_road("town04", 0)
    lane_m = scenario.road.lane_offset_m(2)
    bodies = [*scenario.bodies, ObjectSpec(kind="truck", s_m=205.0, lane=2)]
    if traffic:
        bodies.append(ObjectSpec(kind="car", s_m=150.0, lane=4, speed_mps=14.0))
        bodies.append(ObjectSpec(kind="van", s_m=128.0, lane=4, speed_mps=14.0))
    path = Path(152.0, 5.55, lambda s: lane_m - 1.9 + 1.9 * smooth_step(168.0, 182.0, s))
    return ScriptedDrive(scenario.model_copy(update={"bodies": tuple(bodies)}), path)


@lru_cache(maxsize=3)
def _greys(weather: Weather, traffic: bool, seed: int, count: int) -> list[Image]:
    """The grey frames of the drive in the reference weather."""
    return [grey(shot.image) for shot in drive(traffic).shots(weather, seed, count)]


def measure(factor: Factor, seed: int, seconds: float, every: int) -> Score:
    """Drive in one weather; every `every`-th frame is scored."""
    course = drive(factor.traffic)
    if factor.noise_sd is not None:
        course = replace(course, rig=replace(course.rig, noise_sd=factor.noise_sd))
    scorer = TrackingScorer(course.rig.camera, course.rate_hz, seed)
    count = round(seconds * course.rate_hz) + 1
    without = _greys(factor.without, factor.traffic, seed, count)
    for shot in course.shots(factor.weather, seed, count):
        scorer.add_frame(shot, without[shot.index], score=shot.index % every == 0)
    return scorer.score()
