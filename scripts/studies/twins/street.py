"""A straight street that matches a recorded drive, and the drive along it with the recording's camera and speed."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from vpf_sim.envs.camera import Rig
from vpf_sim.gallery.poses import ScriptedDrive, TimedPath
from vpf_sim.scenarios import Scenario
from vpf_sim.scenarios.kinds import SIZES
from vpf_sim.types import Camera, Floats

LENGTH_M = 600.0
START_M = 60.0


@dataclass(frozen=True, slots=True)
class Street:
    """A straight road with obstacles and traffic; their s_m counts from the start of the drive.

    Traffic keeps its speed, whoever is ahead; the lead vehicle keeps the recorded gap.
    """

    lanes: int
    lane: int  # of the camera, counted from the right
    weather: str
    objects: tuple[dict[str, Any], ...]
    lane_width_m: float = 3.5
    lateral_m: float = 0.0  # of the camera from the lane's centre, + is right
    heading_deg: float = 0.0  # of the road, which decides where shadows fall
    look: dict[str, Any] = field(default_factory=dict)  # keys of the road's look
    blur_px: float = 0.0  # of the recording, estimated from the edges of its markings
    noise_sd: float | None = None  # grey levels, estimated from the recording's sky
    pitch_deg: float = 0.0  # of the body on its springs, standard deviation
    exposure_ev: float = 0.0  # of the recording against an automatic exposure, by its brightness
    lead: int | None = None  # the object that keeps the recorded gap
    camera: Camera | None = None  # estimated from the images of a recording without calibration
    speed_mps: float | None = None  # likewise

    def scenario(self) -> Scenario:
        """The road with its obstacles and traffic."""
        return Scenario.model_validate(
            {
                "schema": 1,
                "road": {
                    "lanes": self.lanes,
                    "lane_width_m": self.lane_width_m,
                    "heading_deg": self.heading_deg,
                    "segments": [{"kind": "line", "length_m": LENGTH_M}],
                    "look": self.look,
                },
                "goal": {"s_m": LENGTH_M - 10.0},
                "bodies": [{**street_object, "s_m": START_M + street_object["s_m"]} for street_object in self.objects],
            }
        )

    def drive(self, camera: Camera, rate_hz: float, speeds_mps: Floats, gaps_m: Floats | None = None) -> ScriptedDrive:
        """The drive with the speed (N,) at each frame, and the gaps (N,) from the camera to the lead vehicle.

        The width of the frames is rounded down to an even number.
        """
        camera = replace(camera, width_px=camera.width_px // 2 * 2)
        rig = Rig(camera, noise_sd=self.noise_sd, blur_px=self.blur_px, exposure_ev=self.exposure_ev)
        times_s = np.arange(len(speeds_mps)) / rate_hz
        steps_m = 0.5 * (speeds_mps[1:] + speeds_mps[:-1]) / rate_hz
        driven_m = np.concatenate([[0.0], np.cumsum(steps_m)])
        scenario = self.scenario()
        offset_m = scenario.road.lane_offset_m(self.lane) + self.lateral_m
        path = TimedPath(times_s, START_M + driven_m, lambda _: offset_m)
        moved = {number: self._motion(number) for number, thing in enumerate(self.objects) if thing["speed_mps"] > 0.0}
        if self.lead is not None and gaps_m is not None:
            ahead_m = camera.forward_m + 0.5 * SIZES[self.objects[self.lead]["kind"]].length_m
            moved[self.lead] = TimedPath(times_s, path.places_m + gaps_m + ahead_m, path.offset_m).s_m
        return ScriptedDrive(scenario, path, rig, rate_hz, moved, self.pitch_deg)

    def _motion(self, number: int) -> Callable[[float], float]:
        """The place of a vehicle over time, at its constant speed."""
        vehicle = self.objects[number]
        return partial(_steady, START_M + vehicle["s_m"], vehicle["speed_mps"])


def _steady(start_m: float, speed_mps: float, time_s: float) -> float:
    return start_m + speed_mps * time_s


def street_object(kind: str, s_m: float, lane: int, lateral_m: float = 0.0, speed_mps: float = 0.0) -> dict[str, Any]:
    """One obstacle or vehicle of a street."""
    return {"kind": kind, "s_m": s_m, "lane": lane, "lateral_m": lateral_m, "speed_mps": speed_mps}
