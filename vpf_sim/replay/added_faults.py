"""Sensor faults in a recording that was made without: ours, and told so wherever the drive is named."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from vpf_sim.envs.sensor_faults import SPEED, YAW_RATE, CameraFaults, SignalFaults
from vpf_sim.errors import InputError
from vpf_sim.replay.recording import Frame, Origin, Recording
from vpf_sim.scenarios.parts import SensorFaults


def with_faults(recording: Recording, faults: SensorFaults, seed: int = 0) -> Recording:
    """The recording as sensors that fail would have made it; all else as it was."""
    if not (faults.affect_camera or faults.affect_signals):
        raise InputError("--faults: expected a scenario with a fault in [ego.sensor_faults], got none")
    added = Origin("derived", "sensor faults, ours")
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

    return replace(recording, frames=frames)


def _with_signal_faults(recording: Recording, faults: SensorFaults, seed: int) -> Recording:
    if not faults.affect_signals:
        return recording
    signals = SignalFaults(faults, seed)
    start_s, read = float(recording.times_s[0]), np.zeros((len(recording), 5))
    read[:, SPEED], read[:, YAW_RATE] = recording.speed_mps, recording.yaw_rate_radps
    told = np.array([signals.read(row, time_s - start_s) for row, time_s in zip(read, recording.times_s, strict=True)])
    names = [] if faults.speed_stuck_after_s is None else ["speed_mps"]
    names += ["yaw_rate_radps"] if faults.yaw_rate_spike_share > 0.0 else []
    spoilt = Origin("derived", "with a fault of the sensor, ours")
    origins = {**recording.origins, **dict.fromkeys(names, spoilt)}
    return replace(recording, speed_mps=told[:, SPEED], yaw_rate_radps=told[:, YAW_RATE], origins=origins)
