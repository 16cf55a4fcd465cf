"""Simulated sensor faults added to a recording, marked in its origins."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from vpf_sim.envs.camera.glass import Glass
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.snapshot import Snapshot
from vpf_sim.envs.camera.view import View
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.envs.sensors import SPEED, YAW_RATE, CameraFaults, SignalFaults
from vpf_sim.errors import InputError
from vpf_sim.replay.image_files import Frame
from vpf_sim.replay.recording import Origin, Recording
from vpf_sim.scenarios.parts import SensorFaults


def with_faults(recording: Recording, faults: SensorFaults, seed: int = 0) -> Recording:
    """The recording with these sensor faults in its frames and signals."""
    if not (faults.affect_camera or faults.affect_signals):
        raise InputError("--faults: expected a scenario with a fault in [ego.sensor_faults], got none")
    added = Origin("derived", "simulated sensor faults")
    failing = _with_signal_faults(_with_camera_faults(recording, faults, seed), faults, seed)
    return replace(failing, origins={**failing.origins, "sensor_faults": added})


def _with_camera_faults(recording: Recording, faults: SensorFaults, seed: int) -> Recording:
    if not faults.affect_camera:
        return recording

    def frames() -> Iterator[Frame]:
        camera = CameraFaults(faults, recording.rate_hz, seed)
        for frame in recording.frames():
            if frame.image is None:
                yield frame
                continue
            image, time_s = camera.frame(frame.image, float(recording.times_s[frame.index]))
            yield replace(frame, image=image, time_s=time_s)

    return replace(recording, frames=frames, fixed=None)


def _with_signal_faults(recording: Recording, faults: SensorFaults, seed: int) -> Recording:
    if not faults.affect_signals:
        return recording
    signals = SignalFaults(faults, seed)
    start_s, true = float(recording.times_s[0]), np.zeros((len(recording), 5))
    true[:, SPEED], true[:, YAW_RATE] = recording.speed_mps, recording.yaw_rate_radps
    measured = np.array(
        [signals.read(row, time_s - start_s) for row, time_s in zip(true, recording.times_s, strict=True)]
    )
    names = [] if faults.speed_stuck_after_s is None else ["speed_mps"]
    names += ["yaw_rate_radps"] if faults.yaw_rate_spike_share > 0.0 else []
    faulty = Origin("derived", "with a simulated sensor fault")
    origins = {**recording.origins, **dict.fromkeys(names, faulty)}
    return replace(recording, speed_mps=measured[:, SPEED], yaw_rate_radps=measured[:, YAW_RATE], origins=origins)


def with_water(recording: Recording, weather: Weather, seed: int = 0) -> Recording:
    """The recording through a weather's drops, water film and wiper."""
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
    return replace(recording, frames=frames, fixed=None, origins={**recording.origins, "weather": added})
