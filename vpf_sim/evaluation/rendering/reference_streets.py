"""Simulated streets that match recorded drives, rendered with the drive's camera and speed."""

from dataclasses import dataclass, field, replace
from typing import Any

from vpf_sim.envs.camera import Rig, Weather
from vpf_sim.envs.camera import weather as weathers
from vpf_sim.evaluation.rendering.scripted import Path, ScriptedDrive
from vpf_sim.scenarios import Scenario
from vpf_sim.types import Camera

LENGTH_M = 600.0
START_M = 60.0


@dataclass(frozen=True, slots=True)
class Street:
    """A straight road with obstacles and traffic; their s_m counts from the start of the drive."""

    lanes: int
    lane: int  # of the camera, counted from the right
    weather: str
    objects: tuple[dict[str, Any], ...]
    changes: dict[str, float] = field(default_factory=dict)  # to the weather's factors
    lane_width_m: float = 3.5
    blur_px: float = 0.0  # of the recording, estimated from the edges of its markings
    noise_sd: float | None = None  # grey levels, estimated from the recording's sky

    def scenario(self) -> Scenario:
        """The road with its obstacles and traffic."""
        return Scenario.model_validate(
            {
                "schema": 1,
                "road": {
                    "lanes": self.lanes,
                    "lane_width_m": self.lane_width_m,
                    "segments": [{"kind": "line", "length_m": LENGTH_M}],
                },
                "goal": {"s_m": LENGTH_M - 10.0},
                "bodies": [{**street_object, "s_m": START_M + street_object["s_m"]} for street_object in self.objects],
            }
        )

    def modified_weather(self) -> Weather:
        """The weather with its changes."""
        return weathers.load(self.weather).model_copy(update=self.changes)

    def drive(self, camera: Camera, rate_hz: float, speed_mps: float) -> ScriptedDrive:
        """A drive along the centre of the camera's lane; the width is rounded down to an even number."""
        scenario = self.scenario()
        camera = replace(camera, width_px=camera.width_px // 2 * 2)
        rig = Rig(camera, noise_sd=self.noise_sd, blur_px=self.blur_px)
        offset_m = scenario.road.lane_offset_m(self.lane)
        return ScriptedDrive(scenario, Path(START_M, speed_mps, lambda _: offset_m), rig, rate_hz)


def street_object(kind: str, s_m: float, lane: int, lateral_m: float = 0.0, speed_mps: float = 0.0) -> dict[str, Any]:
    """One obstacle or vehicle of a street."""
    return {"kind": kind, "s_m": s_m, "lane": lane, "lateral_m": lateral_m, "speed_mps": speed_mps}


STREETS = {
    # A street with cars parked on the right and a few on the left.
    "kitti_vo_seq1": Street(
        lanes=3,
        lane=2,
        weather="ClearNoon",
        objects=(
            *(street_object("car", s, 1, 0.4) for s in (16.0, 30.0, 37.0, 52.0, 66.0, 73.0, 88.0)),
            *(street_object("car", s, 3, -0.4) for s in (24.0, 45.0, 58.0, 80.0)),
            street_object("van", 44.0, 1, 0.4),
            street_object("pedestrian", 28.0, 1, 1.2),
        ),
    ),
    # A queue before a traffic light: a lead car, trucks on both sides.
    "kitti_raw_leadcar": Street(
        lanes=4,
        lane=2,
        weather="ClearNoon",
        objects=(
            street_object("car", 12.5, 2, speed_mps=1.0),
            street_object("truck", 14.0, 1),
            street_object("truck", 20.0, 3),
            street_object("car", 5.0, 3, -0.5),
            street_object("car", 26.0, 2),
            street_object("car", 24.0, 1),
            street_object("van", 35.0, 2),
            street_object("car", 32.0, 3),
        ),
    ),
    "carnd_highway": Street(
        lanes=4,
        lane=1,
        weather="ClearNoon",
        lane_width_m=3.66,
        blur_px=1.0,
        noise_sd=0.5,
        objects=(
            street_object("van", 28.0, 3, speed_mps=25.3),
            street_object("car", 70.0, 2, speed_mps=25.3),
            street_object("van", 60.0, 3, speed_mps=25.3),
            street_object("car", 80.0, 3, speed_mps=25.3),
            street_object("car", 120.0, 1, speed_mps=25.3),
            street_object("truck", 160.0, 2, speed_mps=25.3),
        ),
    ),
    "radiate_fog": Street(
        lanes=2,
        lane=1,
        weather="FoggyNoon",
        blur_px=1.5,
        noise_sd=0.5,
        changes={
            "precipitation": 30.0,
            "precipitation_deposits": 30.0,
            "wetness": 60.0,
            "droplets": 40.0,
            "cloudiness": 100.0,
        },
        objects=(street_object("car", 45.0, 2), street_object("car", 70.0, 2)),
    ),
}
