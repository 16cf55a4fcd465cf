"""Builds a complete recording from a source's signals: calibrates, interpolates and derives."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import islice
from pathlib import Path

import cv2
import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.geometry import unwrapped
from vpf_sim.planning import variant
from vpf_sim.replay import calibrate, consistency, derived, fixed_structure, lane_height, paths, plausible, series
from vpf_sim.replay.fixed_structure import FixedStructure
from vpf_sim.replay.image_files import Frame
from vpf_sim.replay.mounting_estimate import Angle
from vpf_sim.replay.recording import IMAGES, Assumption, Kind, Origin, Recording
from vpf_sim.replay.rectify import Lens, Mounting, rectified, rectified_frames, reduced, reduction, rotation, shrunk
from vpf_sim.types import Bools, Camera, Floats, Image

WHEELBASE_M = 2.7  # of a typical car
CAMERA_AHEAD_M = 1.5  # ahead of the rear axle, for a camera behind the windscreen
HEIGHT_M = 1.4  # above the road
FIELD_OF_VIEW_RAD = float(np.radians(60.0))  # horizontal, for an unknown camera
COURSE_WINDOW_S = 1.0
REPEAT_GREY_LEVELS = 0.02  # mean difference below which an image repeats the one before
REPEAT_LEAST_SPEED_MPS = 1.0
LEAST_BLIND_SHARE = 0.05  # of the frames, above which a note says so
FIRST_FRAMES = 5  # checked for brightness


@dataclass
class Source:
    """Recorded signals in our axes and units at the N frames; absent signals are unknown."""

    name: str
    layout: str
    times_s: Floats
    frames: Callable[[], Iterator[Frame]]  # as recorded
    lens: Lens
    mounting: Mounting | None = None  # None: estimated from the images
    height_m: float = HEIGHT_M  # of the camera, if the mounting is unknown
    assumed: frozenset[Assumption] = frozenset()  # of the camera; an assumed height is estimated from the lane width
    wheelbase_m: float = WHEELBASE_M
    camera_ahead_m: float = CAMERA_AHEAD_M
    signals: dict[str, Floats] = field(default_factory=dict)
    origins: dict[str, Origin] = field(default_factory=dict)
    acceleration_mps2: Floats | None = None
    directions_m: Floats | None = None  # (N - 1, 3) camera motion in its own axes, if poses in space are known
    heading_recorded: bool = True  # False: it is the course, too rough for a yaw rate
    weather: str = ""
    notes: list[str] = field(default_factory=list)
    mounting_found: dict[str, Angle] = field(default_factory=dict)
    no_images: str = ""
    files: Sequence[Path | None] = ()  # images and other files it is read from; some may be missing
    bridged: dict[str, Bools] = field(default_factory=dict)  # (N,) by signal, where it is interpolated over a gap

    @cached_property
    def _fixed(self) -> FixedStructure | None:
        """What is fixed to the camera, in frames that are reduced in size but not rectified."""
        frames = rectified_frames(self.frames(), lambda image: shrunk(image, self._reduced))
        return fixed_structure.find(frames, self.times_s)

    @property
    def _reduced(self) -> Lens:
        return reduced(self.lens, reduction(self.lens.width_px))

    def fixed(self, mounting: Mounting) -> FixedStructure | None:
        """What is fixed to the camera, in frames that are rectified for a mounting."""
        found = self._fixed
        return found and found.rectified(rectified(self._reduced, mounting)[1])

    def checked(self, name: str, values: Floats, how: str, kind: Kind = "recorded") -> Floats:
        """Values (M,) or (M, 3) at any times, with impossible ones replaced by nan."""
        where = plausible.Location(self.name, f"{name} ({how})")
        if values.ndim == 1:
            return plausible.within_limits(values, name, where, self.notes, refuses=kind == "recorded")
        if kind != "recorded":
            return values
        positions_m = plausible.reachable(self.times_s, values[:, :2], where, self.notes)
        return np.column_stack([positions_m, values[:, 2:]])

    def put(self, name: str, values: Floats, how: str, kind: Kind = "recorded") -> None:
        """Store a signal and its origin, with impossible values removed; nothing if no value is known."""
        values = self.checked(name, values, how, kind)
        if np.count_nonzero(np.isfinite(values.reshape(len(values), -1)).all(axis=1)) > (values.ndim > 1):
            self.signals[name] = values
            self.origins[name] = Origin(kind, how)

    def derive(self, name: str, values: Floats, how: str, *inputs: str, within_s: float = 0.0) -> None:
        """Store a signal computed from others within `within_s`; it is bridged where an input is."""
        self.put(name, values, how, "derived")
        if name in self.signals:
            image_flow = Origin("recorded", "the flow of the images")
            self.origins[name] = Origin.derived_from(how, {one: self.origins.get(one, image_flow) for one in inputs})
            self.bridged[name] = self.is_bridged(*inputs, within_s=within_s)

    def is_bridged(self, *names: str, within_s: float = 0.0) -> Bools:
        """(N,) whether one of the signals is interpolated within `within_s` of each frame."""
        gaps = [self.bridged[name] for name in names if name in self.bridged]
        count = np.concatenate([[0], np.cumsum(np.any(gaps, axis=0))]) if gaps else np.zeros(len(self.times_s) + 1)
        within_s += 1e-9
        first = np.searchsorted(self.times_s, self.times_s - within_s, "left")
        last = np.searchsorted(self.times_s, self.times_s + within_s, "right")
        return np.asarray(count[last] > count[first])


def assumed_lens(width_px: int, height_px: int, field_of_view_rad: float = FIELD_OF_VIEW_RAD) -> Lens:
    """An undistorted lens with its axis in the image centre."""
    focal = float(0.5 * width_px / np.tan(0.5 * field_of_view_rad))
    return Lens(width_px, height_px, focal, focal, 0.5 * (width_px - 1), 0.5 * (height_px - 1))


def recording(source: Source) -> Recording:
    """The recording with all signals that are known or follow; InputError without any speed."""
    origin = source.origins.get("times_s")
    source.notes += plausible.frame_times(source.times_s, source.name, origin.how if origin else "")
    if not source.no_images:
        source.notes += plausible.brightness(
            frame.image for frame in islice(source.frames(), FIRST_FRAMES) if frame.image is not None
        )
    if "poses" in source.signals:
        source.signals["poses"] = derived.from_start(_interpolated(source, "poses", "pose"))
    _motion_from_poses(source)
    _check_sees_road(source, source.lens, source.mounting or Mounting())
    own = _calibrated_by_flow(source)
    scale = _height_by_lanes(source)
    if own is not None:
        own = replace(own, speed_mps=own.speed_mps * scale)
        _motion_from_flow(source, own)
    _fallback_yaw_rate(source)
    if "speed_mps" not in source.signals:
        why = "".join(f"; {note}" for note in source.notes)
        raise InputError(
            f"{source.name}: expected a speed, or poses or images of a road to derive it from; found none{why}"
        )
    for name, what in (("speed_mps", "speed"), ("yaw_rate_radps", "yaw rate")):
        source.signals[name] = _interpolated(source, name, what)
    _commands(source)
    if "poses" not in source.signals:
        speed, rate = source.signals["speed_mps"], source.signals["yaw_rate_radps"]
        path = derived.travelled(source.times_s, speed, rate, source.camera_ahead_m)
        source.derive("poses", path, "from speed and yaw rate: dead reckoning", "speed_mps", "yaw_rate_radps")
    recorded = {name for name, origin in source.origins.items() if origin.kind == "recorded"}
    if "poses" in recorded and source.heading_recorded:
        recorded.add("heading")
    source.notes += consistency.contradictions(source.times_s, source.signals, frozenset(recorded), source.wheelbase_m)
    return _finished(source)


def _motion_from_poses(source: Source) -> None:
    if "poses" not in source.signals:
        return
    poses, step_s = source.signals["poses"], float(np.diff(source.times_s).max())
    if "speed_mps" not in source.signals:
        speed = derived.speed(source.times_s, poses)
        source.derive("speed_mps", speed, "from the poses", "poses", within_s=step_s)
    if "yaw_rate_radps" not in source.signals and source.heading_recorded:
        rate = derived.yaw_rate(source.times_s, poses)
        source.derive("yaw_rate_radps", rate, "from the poses", "poses", within_s=step_s)


def _calibrated_by_flow(source: Source) -> calibrate.FlowCalibration | None:
    """Motion by the images' flow where it is needed; estimates an unknown mounting."""
    needed = source.mounting is None or not {"speed_mps", "yaw_rate_radps"} <= set(source.signals)
    if source.mounting is None and source.no_images:
        source.mounting = Mounting(height_m=source.height_m)
        needed = False
    if not needed or source.no_images:
        return None
    known = [source.signals.get(name) for name in ("speed_mps", "yaw_rate_radps")]
    level = Mounting(height_m=source.mounting.height_m if source.mounting else source.height_m)
    camera, rectify_image = rectified(source.lens, level)
    own = calibrate.estimate(
        rectified_frames(source.frames(), rectify_image),
        camera,
        source.times_s,
        known[0],
        known[1],
        source.camera_ahead_m,
        source.fixed(level),
    )
    if "speed_mps" not in source.signals and own.is_blind.mean() > LEAST_BLIND_SHARE:
        share = f"{100.0 * own.is_blind.mean():.0f} % of the frames"
        source.notes.append(f"motion: unknown in {share}, where too few points are not fixed to the camera")
    if source.mounting is None:
        source.mounting = own.mounting
        source.mounting_found = {"pitch": own.pitch, "yaw": own.yaw}
        _describe_mounting(source, own)
    return own


def _height_by_lanes(source: Source) -> float:
    """Set an assumed camera height by the lane width; returns the ratio of new to old height."""
    if "height" not in source.assumed or source.mounting is None or source.no_images:
        return 1.0
    camera, rectify_image = rectified(source.lens, source.mounting)
    config = variant.load(calibrate.VARIANT).road_edges
    frames = rectified_frames(source.frames(), rectify_image)
    found = lane_height.height_m(frames, camera, source.times_s, config, source.fixed(source.mounting))
    if found is None:
        return 1.0
    scale = found / source.mounting.height_m
    source.height_m, source.mounting = found, replace(source.mounting, height_m=found)
    source.assumed = source.assumed - {"height"} | {"height by lanes"}
    origin = source.origins["camera"]
    how = f"{origin.how}; {found:.2f} m above the road by its lanes, assumed {config.lane_width_m:g} m wide"
    source.origins["camera"] = Origin(origin.kind, how)
    return scale


def _describe_mounting(source: Source, own: calibrate.FlowCalibration) -> None:
    origin = source.origins.get("camera", Origin("recorded"))
    named = (("down", own.pitch), ("right", own.yaw))
    parts = [origin.how, *(_angle_text(side, one) for side, one in named)]
    source.origins["camera"] = Origin(origin.kind, "; ".join(part for part in parts if part))


def _angle_text(side: str, found: Angle) -> str:
    low, high = found.interval_deg
    interval = f"{low:.1f} to {high:.1f} deg {side} by {found.seconds:.1f} s of straight road"
    return f"looks {interval}" if found.is_used else f"assumed to look 0 deg {side}: the images give {interval}"


def _motion_from_flow(source: Source, own: calibrate.FlowCalibration) -> None:
    if "speed_mps" not in source.signals:
        how = f"from the road's flow, for a camera {source.height_m:g} m above it"
        source.derive("speed_mps", own.speed_mps, how, IMAGES)
    if "yaw_rate_radps" not in source.signals:
        source.derive("yaw_rate_radps", own.yaw_rate_radps, "from the flow", IMAGES)


def _fallback_yaw_rate(source: Source) -> None:
    """Yaw rate by the course over ground, or speed x tan(steering) / wheelbase."""
    if "yaw_rate_radps" in source.signals:
        return
    if "poses" in source.signals:
        rate = derived.slope(source.times_s, unwrapped(source.signals["poses"][:, 2]), COURSE_WINDOW_S)
        how, half_s = "from the course over ground", 0.5 * COURSE_WINDOW_S
        source.derive("yaw_rate_radps", rate, how, "poses", within_s=half_s)
    elif {"speed_mps", "steering_rad"} <= set(source.signals):
        rate = source.signals["speed_mps"] * np.tan(source.signals["steering_rad"]) / source.wheelbase_m
        how = "from speed and steering: the kinematic bicycle"
        source.derive("yaw_rate_radps", rate, how, "speed_mps", "steering_rad")
    if "yaw_rate_radps" not in source.signals:
        source.put("yaw_rate_radps", np.zeros(len(source.times_s)), "none: no signal yields it", "assumed")


def _commands(source: Source) -> None:
    """Derive steering and throttle from the motion where not recorded; nan where that is bridged."""
    speed, rate = source.signals["speed_mps"], source.signals["yaw_rate_radps"]
    if "steering_rad" not in source.signals:
        angle = derived.steering(speed, rate, source.wheelbase_m)
        how = f"from speed and yaw rate: the kinematic bicycle of {source.wheelbase_m:g} m wheelbase"
        inputs = ("speed_mps", "yaw_rate_radps")
        source.derive("steering_rad", np.where(source.is_bridged(*inputs), np.nan, angle), how, *inputs)
    if "throttle" not in source.signals:
        scale = "full throttle 3 m/s2, full brake 6 m/s2"
        if source.acceleration_mps2 is not None:
            throttle = derived.throttle(source.acceleration_mps2)
            source.put("throttle", throttle, f"from the recorded acceleration; {scale}", "derived")
            return
        unknown = source.is_bridged("speed_mps", within_s=0.5 * derived.SLOPE_WINDOW_S)
        throttle = np.where(unknown, np.nan, derived.throttle(derived.slope(source.times_s, speed)))
        source.derive("throttle", throttle, f"from the speed's slope over 0.5 s; {scale}", "speed_mps")


def _interpolated(source: Source, name: str, what: str) -> Floats:
    """The signal with gaps interpolated; they are noted and not scored."""
    values = source.signals[name]
    if values.ndim == 2:
        result, missing = derived.bridged(source.times_s, values)
    else:
        result, missing = series.filled(source.times_s, values)
    if missing.any():
        source.notes.append(f"{what}: {np.count_nonzero(missing)} of {len(missing)} values missing, interpolated")
    source.bridged[name] = missing | source.bridged.get(name, missing)
    return result


def _finished(source: Source) -> Recording:
    assert source.mounting is not None
    camera, rectify_image = rectified(source.lens, source.mounting)
    if reduction(source.lens.width_px) > 1:
        source.notes.append(f"frames reduced to {camera.width_px} x {camera.height_px} px")
    _note_uneven_times(source)
    foe = _truth(source, camera)
    if foe is not None:
        source.origins["foe_px"] = Origin("derived", "from the poses")
    speed = source.signals["speed_mps"]

    def frames() -> Iterator[Frame]:
        if source.no_images:
            raise InputError(source.no_images)
        return rectified_frames(_without_blank_or_repeated(source.frames(), speed), rectify_image)

    names = ("poses", "speed_mps", "yaw_rate_radps", "steering_rad", "throttle", "obstacle", "lead_gap_m")
    return Recording(
        name=source.name,
        layout=source.layout,
        camera=camera,
        times_s=source.times_s,
        frames=frames,
        origins=source.origins,
        weather=source.weather,
        notes=tuple(source.notes),
        mounting_found=source.mounting_found,
        fixed=partial(source.fixed, source.mounting),
        assumed=source.assumed,
        no_images=source.no_images,
        files=tuple(source.files),
        bridged=source.bridged,
        foe_px=np.empty(0) if foe is None else foe,
        **{name: source.signals[name] for name in names if name in source.signals},
    )


def _note_uneven_times(source: Source) -> None:
    """Note frame intervals that vary: trackers assume the median interval."""
    steps = np.diff(source.times_s)
    usual, longest, shortest = float(np.median(steps)), float(steps.max()), float(steps.min())
    if longest > 1.5 * usual or shortest < usual / 1.5:
        source.notes.append(f"frames are {shortest:.3f} to {longest:.3f} s apart, {usual:.3f} s in the median")


def _check_sees_road(source: Source, lens: Lens, mounting: Mounting) -> None:
    """Refuse a camera that cannot see the road, as with wrong intrinsics or units."""
    size = f"{lens.width_px} x {lens.height_px} px"
    try:
        for value in (lens.fx_px, lens.fy_px):
            plausible.check_key("focal length, px", value, "focal_px")
        for value in lens.distortion:
            plausible.check_key("distortion", value)
    except ValueError as error:
        raise InputError(f"{source.name}: {error}") from None
    if not (0.0 <= lens.cx_px < lens.width_px and 0.0 <= lens.cy_px < lens.height_px):
        centre = f"{lens.cx_px:g}, {lens.cy_px:g}"
        raise InputError(f"{source.name}: expected the camera's axis within its image of {size}, got {centre}")
    horizon = lens.cy_px - lens.fy_px * np.tan(mounting.pitch_rad)
    if not -0.5 * lens.height_px <= horizon <= 0.9 * lens.height_px:
        row = f"row {horizon:.0f} of its image of {size}"
        raise InputError(f"{source.name}: expected a camera that sees the road, got the horizon at {row}")


def _truth(source: Source, camera: Camera) -> Floats | None:
    """(N, 2) px, true focus of expansion in rectified frames, in the axes halfway from the frame before."""
    if source.directions_m is None or source.mounting is None:
        return None
    straight = rotation(replace(source.mounting, yaw_rad=0.0, roll_rad=0.0)).T @ rotation(source.mounting)
    result = np.full((len(source.times_s), 2), np.nan)
    result[1 : 1 + len(source.directions_m)] = paths.expansion(camera, source.directions_m @ straight.T)
    return result


def _without_blank_or_repeated(frames: Iterator[Frame], speed_mps: Floats) -> Iterator[Frame]:
    """The frames, with blank images and repeated images of a moving car as gaps."""
    before: Image | None = None
    for frame in frames:
        if frame.image is None:
            yield frame
            continue
        small = frame.image[::4, ::4, 1]
        if plausible.is_blank(small):
            before = None
            yield replace(frame, image=None, fault=f"frame {frame.index}: blank image")
            continue
        moving = speed_mps[frame.index] > REPEAT_LEAST_SPEED_MPS
        same = before is not None and moving and float(cv2.absdiff(small, before).mean()) < REPEAT_GREY_LEVELS
        before = small.copy()
        yield replace(frame, image=None, fault="repeats the image before") if same else frame
