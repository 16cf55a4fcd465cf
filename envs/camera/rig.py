"""The camera and its sensor as they are mounted on the vehicle."""

from dataclasses import dataclass, field

from vpf_sim.errors import InputError
from vpf_sim.types import Camera


@dataclass(frozen=True, slots=True)
class Rig:
    """A camera, its lens and its sensor.

    noise_sd: standard deviation of the sensor's noise in grey levels; 0 turns it off, None leaves it to the weather's
    light: 1.3 by day, which is what a small sensor shows with 10 000 electrons at full scale (EMVA 1288: shot noise and
    4 electrons of read noise, after a gamma of 2.2), 2.5 in hard rain and at sunset. exposure_ev: longer (+) or shorter
    (-) than the automatic exposure, in powers of 2 of the light. blur_px: standard deviation of the lens's and the
    sensor's blur, 0 is none.
    """

    camera: Camera = field(default_factory=Camera)
    noise_sd: float | None = None
    exposure_ev: float = 0.0
    blur_px: float = 0.0

    def __post_init__(self) -> None:
        from vpf_sim.envs.camera.lens import check_distortion  # and OpenCV, which listings do without

        camera = self.camera
        for key, low in (("width_px", 64), ("height_px", 48), ("fx_px", 1.0), ("fy_px", 1.0), ("height_m", 0.1)):
            value = getattr(camera, key)
            if not value >= low:
                raise InputError(f"camera: {key}: expected at least {low}, got {value}")
        if camera.width_px % 2:
            raise InputError(f"camera: width_px: expected an even number, got {camera.width_px}")
        if not abs(camera.pitch_rad) < 0.5:
            raise InputError(f"camera: pitch_rad: expected between -0.5 and 0.5, got {camera.pitch_rad}")
        check_distortion(camera)
        if self.noise_sd is not None and not 0.0 <= self.noise_sd <= 20.0:
            raise InputError(f"camera: noise_sd: expected 0 to 20 grey levels, got {self.noise_sd}")
        if not -4.0 <= self.exposure_ev <= 4.0:
            raise InputError(f"camera: exposure_ev: expected -4 to 4, got {self.exposure_ev}")
        if not 0.0 <= self.blur_px <= 5.0:
            raise InputError(f"camera: blur_px: expected 0 to 5, got {self.blur_px}")
