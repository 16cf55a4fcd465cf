"""The effect of weather on tracking and on the focus of expansion, each factor alone and together.

python scripts/studies/weather_effect/measure.py [--seed 0] [--seconds 4] [--every 12]

The same drive is rendered in every weather with the same poses and seed, so all differences come from the weather.
"""

import argparse

import numpy as np
import pandas as pd

from vpf_sim import scenarios
from vpf_sim.envs.camera import Weather
from vpf_sim.envs.camera import weather as weathers
from vpf_sim.evaluation.truth.true_motion import OFF_PX, TrueMotion
from vpf_sim.gallery.poses import Path, ScriptedDrive, smooth_step
from vpf_sim.perception.egomotion import focus_of_expansion
from vpf_sim.perception.egomotion.flow import FlowTracker, grey
from vpf_sim.planning import variant
from vpf_sim.scenarios.parts import ObjectSpec
from vpf_sim.seeding import stream
from vpf_sim.system import limit_opencv

WINDOW_FRAMES = 6  # 0.1 s at 60 Hz: the flow's window in `full-frame`
DRY = {"precipitation": 0.0, "precipitation_deposits": 0.0, "wetness": 0.0, "droplets": 0.0, "wiper_period_s": 0.0}


def changed(**factors: float) -> Weather:
    """Clear weather with some factors changed."""
    return weathers.load("ClearNoon").model_copy(update={**DRY, **factors})


ROWS = {
    "clear": changed(),
    "wet road": changed(wetness=100.0),
    "falling rain": changed(precipitation=100.0, wind_intensity=100.0),
    "drops on the windscreen": changed(droplets=100.0),
    "drops, wiper": changed(droplets=100.0, wiper_period_s=weathers.FAST_WIPER_S),
    "HardRainNoon": weathers.load("HardRainNoon"),
}


def drive() -> ScriptedDrive:
    """From town04's first bend past its second obstacle, with overtaking traffic and a parked truck ahead."""
    scenario = scenarios.drawn_road("town04", 0)
    lane_m = scenario.road.lane_offset_m(2)
    truck = ObjectSpec(kind="truck", s_m=205.0, lane=2)
    car = ObjectSpec(kind="car", s_m=150.0, lane=4, speed_mps=14.0)
    van = ObjectSpec(kind="van", s_m=128.0, lane=4, speed_mps=14.0)
    path = Path(152.0, 5.55, lambda s: lane_m - 1.9 + 1.9 * smooth_step(168.0, 182.0, s))
    return ScriptedDrive(scenario.model_copy(update={"bodies": (*scenario.bodies, truck, car, van)}), path)


def measure(weather: Weather, seed: int, seconds: float, every: int) -> dict[str, float]:
    """Share of tracks that are off by more than OFF_PX, and the median error of the focus of expansion, px."""
    course, random = drive(), stream(seed, "focus of expansion")
    camera, configs = course.rig.camera, [variant.load(name) for name in ("full-frame", "robust")]
    tracker, motion = FlowTracker(camera, configs[0].flow, course.rate_hz), TrueMotion(camera, WINDOW_FRAMES)
    off: list[float] = []
    foe_px: tuple[list[float], list[float]] = ([], [])
    for shot in course.shots(weather, seed, round(seconds * course.rate_hz) + 1):
        motion.add(shot)
        flow = tracker.update(grey(shot.image), shot.pose)
        if shot.index % every or shot.index < WINDOW_FRAMES:
            continue
        truth = shot.renderer.truth(("depth", "instance", "foe"))
        frames = np.rint(flow.gap_s * course.rate_hz).astype(np.int64)
        old = frames == WINDOW_FRAMES
        off += (motion.errors_px(flow.points_px[old], flow.displacement_px[old], frames[old], truth) > OFF_PX).tolist()
        for config, errors in zip(configs, foe_px, strict=True):
            found = focus_of_expansion.estimate(flow, camera, config.focus_of_expansion, random)
            if found.confidence > 0.0:
                errors.append(float(np.hypot(found.x_px - truth["foe"][0], found.y_px - truth["foe"][1])))
    paper, robust = map(np.median, foe_px)
    return {"tracks off, %": 100.0 * float(np.mean(off)), "paper's FOE, px": float(paper), "robust, px": float(robust)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=4.0, help="length of the drive")
    parser.add_argument("--every", type=int, default=12, help="score every N-th frame")
    arguments = parser.parse_args()
    limit_opencv()
    for number, (name, weather) in enumerate(ROWS.items()):
        row = {"weather": name, **measure(weather, arguments.seed, arguments.seconds, arguments.every)}
        line = pd.DataFrame([row]).to_string(
            index=False, header=number == 0, col_space=12, float_format="{:.3g}".format
        )
        print(line, flush=True)


if __name__ == "__main__":
    main()
