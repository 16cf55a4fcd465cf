"""The camera and its sensor as they are mounted on the vehicle."""

from dataclasses import dataclass, field

from vpf_sim.errors import InputError
from vpf_sim.types import Camera


@dataclass(frozen=True, slots=True)
class Rig:
    """A camera and the noise of its sensor.

    The default, 1.3 grey levels, is what a small sensor shows by day with 10 000 electrons at full scale (EMVA 1288:
    shot noise and 4 electrons of read noise, after a gamma of 2.2); 0 turns the noise off.
    """

    camera: Camera = field(default_factory=Camera)
    noise_sd: float = 1.3  # grey levels

    def __post_init__(self) -> None:
        camera = self.camera
        for key, low in (("width_px", 64), ("height_px", 48), ("fx_px", 1.0), ("fy_px", 1.0), ("height_m", 0.1)):
            value = getattr(camera, key)
            if not value >= low:
                raise InputError(f"camera: {key}: expected at least {low}, got {value}")
        if camera.width_px % 2:
            raise InputError(f"camera: width_px: expected an even number, got {camera.width_px}")
        if camera.k1 != 0.0 or camera.k2 != 0.0:
            raise InputError(
                f"camera: k1, k2: expected 0, the picture has no lens distortion, got {camera.k1}, {camera.k2}"
            )
        if not abs(camera.pitch_rad) < 0.5:
            raise InputError(f"camera: pitch_rad: expected between -0.5 and 0.5, got {camera.pitch_rad}")
        if not 0.0 <= self.noise_sd <= 20.0:
            raise InputError(f"camera: noise_sd: expected 0 to 20 grey levels, got {self.noise_sd}")
