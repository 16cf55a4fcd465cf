"""Simulated water on the windscreen of a dry recording, marked in its origins."""

from collections.abc import Iterator
from dataclasses import replace

from vpf_sim.envs.camera.glass import Glass
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.snapshot import Snapshot
from vpf_sim.envs.camera.view import View
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.errors import InputError
from vpf_sim.replay.recording import Frame, Origin, Recording


def with_water(recording: Recording, weather: Weather, seed: int = 0) -> Recording:
    """The recording seen through a weather's drops, water film and wiper."""
    if weather.droplets <= 0.0:
        raise InputError(
            f"--water: expected a weather with droplets > 0, got '{weather.name}' with {weather.droplets:g}"
        )

    def frames() -> Iterator[Frame]:
        glass = Glass(recording.camera, weather, Light.of(weather), seed)
        before: Snapshot | None = None
        for frame in recording.frames():
            if frame.image is None:
                yield frame
                continue
            pose, time_s = recording.poses[frame.index], float(recording.times_s[frame.index])
            now = Snapshot(View.at(recording.camera, pose[:2], float(pose[2])), time_s, [], {})
            wet = frame.image.copy()
            glass.draw(wet, now, before or now)
            before = now
            yield replace(frame, image=wet)

    added = Origin("derived", f"simulated water of {weather.name}")
    return replace(recording, frames=frames, origins={**recording.origins, "weather": added})
