"""The camera and its image sensor, as mounted on the vehicle."""

from dataclasses import dataclass, field, fields
from math import isfinite
from numbers import Integral, Real

from vpf_sim.errors import InputError
from vpf_sim.geometry import horizon_px
from vpf_sim.scenarios.parts import CameraName
from vpf_sim.types import Camera

LARGEST_PX = 8192


@dataclass(frozen=True, slots=True)
class Rig:
    """A camera, its lens and its sensor.

    noise_sd: standard deviation of the sensor's noise in grey levels; 0 turns it off, None derives it from the
    weather's light: 1.3 by day, 2.5 in hard rain and at sunset. 1.3 is a small sensor with 10 000 electrons at full
    scale (EMVA 1288: shot noise and 4 electrons of read noise, after a gamma of 2.2). exposure_ev: longer (+) or
    shorter (-) than the automatic exposure, in powers of 2 of the light. blur_px: standard deviation of the blur of
    lens and sensor, 0 for none.

    What cameras in cars add, all off by default: `bonnet` at the lower edge; `reflection` of the dashboard in the
    windscreen, 0 to 0.5 of the horizon's brightness; `dirt` on it, 0 to 0.5 of the picture; `overlay`, time and speed
    as text; `rolling_shutter_ms`, the time to read all rows; `auto_exposure_s`, the lag of an exposure control;
    `jpeg_quality`, 1 to 100. `preset` makes some cameras.
    """

    camera: Camera = field(default_factory=Camera)
    noise_sd: float | None = None
    exposure_ev: float = 0.0
    blur_px: float = 0.0
    bonnet: bool = False
    reflection: float = 0.0
    dirt: float = 0.0
    overlay: bool = False
    rolling_shutter_ms: float = 0.0
    auto_exposure_s: float = 0.0
    jpeg_quality: int | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.camera, Camera):
            raise InputError(f"rig: camera: expected a vpf_sim.types.Camera, got {self.camera!r}")
        _check_camera(self.camera)
        for key, value in (("noise_sd", self.noise_sd), ("exposure_ev", self.exposure_ev), ("blur_px", self.blur_px)):
            if not (_is_number(value) or (key == "noise_sd" and value is None)):
                raise InputError(f"camera: {key}: expected a finite number, got {value!r}")
        if self.noise_sd is not None and not 0.0 <= self.noise_sd <= 20.0:
            raise InputError(f"camera: noise_sd: expected 0 to 20 grey levels, got {self.noise_sd}")
        if not -4.0 <= self.exposure_ev <= 4.0:
            raise InputError(f"camera: exposure_ev: expected -4 to 4, got {self.exposure_ev}")
        if not 0.0 <= self.blur_px <= 5.0:
            raise InputError(f"camera: blur_px: expected 0 to 5, got {self.blur_px}")
        for key, high in (("reflection", 0.5), ("dirt", 0.5), ("rolling_shutter_ms", 100.0), ("auto_exposure_s", 10.0)):
            value = getattr(self, key)
            if not _is_number(value) or not 0.0 <= value <= high:
                raise InputError(f"camera: {key}: expected 0 to {high:g}, got {value!r}")
        for key in ("bonnet", "overlay"):
            if not isinstance(getattr(self, key), bool):
                raise InputError(f"camera: {key}: expected True or False, got {getattr(self, key)!r}")
        quality = self.jpeg_quality
        if quality is not None and not (isinstance(quality, Integral) and 1 <= int(quality) <= 100):
            raise InputError(f"camera: jpeg_quality: expected 1 to 100, got {quality!r}")


def preset(name: CameraName) -> Rig:
    """A camera by its name in scenario files."""
    if name == "dash-cam":
        return Rig(
            Camera.of(848, 480, 105.0, height_m=1.3, pitch_rad=0.03, k1=-0.08, k2=0.01),
            blur_px=0.7,
            bonnet=True,
            reflection=0.08,
            dirt=0.01,
            overlay=True,
            rolling_shutter_ms=25.0,
            auto_exposure_s=0.5,
            jpeg_quality=75,
        )
    if name == "phone":
        return Rig(
            Camera.of(960, 540, 65.0, height_m=1.25, pitch_rad=-0.02),
            blur_px=0.5,
            reflection=0.12,
            dirt=0.02,
            rolling_shutter_ms=18.0,
            auto_exposure_s=0.3,
            jpeg_quality=85,
        )
    if name == "kitti":  # Geiger et al., IJRR 32(11), 2013: camera 0 of the recordings of 2011-09-26
        return Rig(Camera(1242, 374, 721.5, 721.5, 609.6, 172.9, height_m=1.65, forward_m=0.3))
    return Rig()


def checked_rig(rig: object) -> Rig:
    """The given rig, or the default one for None; InputError for anything else."""
    if rig is None:
        return Rig()
    if not isinstance(rig, Rig):
        remedy = ": Rig(camera=...)?" if isinstance(rig, Camera) else ""
        raise InputError(f"rig: expected a vpf_sim.envs.camera.Rig, got {rig!r}{remedy}")
    return rig


def _check_camera(camera: Camera) -> None:
    """Raise InputError for an invalid camera or one that shows no road."""
    from vpf_sim.envs.camera.lens import check_distortion  # imports OpenCV, which listings do not need

    for key in (item.name for item in fields(camera)):
        value = getattr(camera, key)
        if key in ("width_px", "height_px") and not isinstance(value, Integral):
            raise InputError(f"camera: {key}: expected a whole number, got {value!r}")
        if not _is_number(value):
            raise InputError(f"camera: {key}: expected a finite number, got {value!r}")
    for key, low in (("width_px", 64), ("height_px", 48), ("fx_px", 1.0), ("fy_px", 1.0), ("height_m", 0.1)):
        value = getattr(camera, key)
        if value < low:
            raise InputError(f"camera: {key}: expected at least {low}, got {value}")
    for key, size in (("width_px", camera.width_px), ("height_px", camera.height_px)):
        if size > LARGEST_PX:
            raise InputError(f"camera: {key}: expected at most {LARGEST_PX}, got {size}")
    if camera.width_px % 2:
        raise InputError(f"camera: width_px: expected an even number, got {camera.width_px}")
    for key, size in (("cx_px", camera.width_px), ("cy_px", camera.height_px)):
        value = getattr(camera, key)
        if not 0.0 <= value <= size - 1:
            raise InputError(f"camera: {key}: expected within the image, 0 to {size - 1}, got {value:g}")
    if not abs(camera.pitch_rad) < 0.5:
        raise InputError(f"camera: pitch_rad: expected between -0.5 and 0.5, got {camera.pitch_rad}")
    if horizon_px(camera) > camera.height_px - 1:
        raise InputError(f"camera: pitch_rad: expected one that shows the road, got only sky at {camera.pitch_rad:g}")
    check_distortion(camera)


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and isfinite(value)
