"""From what a source recorded to a whole recording: calibrated, gaps told, what is missing derived where it can be."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path

import cv2
import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.geometry import unwrapped
from vpf_sim.planning import variant
from vpf_sim.replay import agreement, calibrate, camera_motion, derived, lane_height, plausible, series
from vpf_sim.replay.mounting_estimate import Angle
from vpf_sim.replay.recording import PICTURES, Frame, Kind, Origin, Recording
from vpf_sim.replay.rectify import Lens, Mounting, rectified, rectified_frames, reduction, rotation
from vpf_sim.types import Bools, Camera, Floats, Image

WHEELBASE_M = 2.7  # of a usual car
CAMERA_AHEAD_M = 1.5  # of the rear axle, behind the windscreen of a usual car
HEIGHT_M = 1.4  # above the road
FIELD_OF_VIEW_RAD = float(np.radians(60.0))  # across, of a camera of which nothing is known
COURSE_WINDOW_S = 1.0
REPEAT_GREY_LEVELS = 0.02  # mean difference below which a picture is the one before once more
REPEAT_LEAST_SPEED_MPS = 1.0
FIRST_FRAMES = 5  # whose brightness is looked at


@dataclass(slots=True)
class Source:
    """What was recorded, in our axes and units, at the times of the N frames; a signal left out is unknown."""

    name: str
    layout: str
    times_s: Floats
    frames: Callable[[], Iterator[Frame]]  # as recorded
    lens: Lens
    mounting: Mounting | None = None  # None: to be found on the way
    height_m: float = HEIGHT_M  # of the camera, where the mounting is not known
    height_assumed: bool = False  # nobody told it: the lanes of the road may
    wheelbase_m: float = WHEELBASE_M
    camera_ahead_m: float = CAMERA_AHEAD_M
    signals: dict[str, Floats] = field(default_factory=dict)
    origins: dict[str, Origin] = field(default_factory=dict)
    acceleration_mps2: Floats | None = None
    directions_m: Floats | None = None  # (N - 1, 3) the camera's motion in its own axes, where poses in space are known
    heading_recorded: bool = True  # else that of the poses is their course, too rough to tell a yaw rate from
    weather: str = ""
    notes: list[str] = field(default_factory=list)
    mounting_found: dict[str, Angle] = field(default_factory=dict)
    no_images: str = ""
    files: Sequence[Path | None] = ()  # its pictures, and others of which it is a function; some may be missing
    bridged: dict[str, Bools] = field(default_factory=dict)  # (N,) by signal, where it was filled in over a gap

    def checked(self, name: str, values: Floats, how: str, kind: Kind = "recorded") -> Floats:
        """(M,) or (M, 3) the values without those that cannot be, at times of their own or at those of the frames."""
        where = plausible.Where(self.name, f"{name} ({how})")
        if values.ndim == 1:
            return plausible.kept(values, name, where, self.notes, refuses=kind == "recorded")
        if kind != "recorded":
            return values
        places_m = plausible.reached(self.times_s, values[:, :2], where, self.notes)
        return np.column_stack([places_m, values[:, 2:]])

    def put(self, name: str, values: Floats, how: str, kind: Kind = "recorded") -> None:
        """A signal with where it comes from, without what cannot be; nothing if no value is known."""
        values = self.checked(name, values, how, kind)
        if np.count_nonzero(np.isfinite(values.reshape(len(values), -1)).all(axis=1)) > (values.ndim > 1):
            self.signals[name] = values
            self.origins[name] = Origin(kind, how)

    def derive(self, name: str, values: Floats, how: str, *inputs: str, within_s: float = 0.0) -> None:
        """A signal that follows from others, each value from theirs within so long before and after.

        It is bridged where one of them is.
        """
        self.put(name, values, how, "derived")
        if name in self.signals:
            pictures = Origin("recorded", "the flow of the pictures")
            self.origins[name] = Origin.following(how, {one: self.origins.get(one, pictures) for one in inputs})
            self.bridged[name] = self.is_bridged(*inputs, within_s=within_s)

    def is_bridged(self, *names: str, within_s: float = 0.0) -> Bools:
        """(N,) whether one of the signals is filled in within so long before and after each frame."""
        gaps = [self.bridged[name] for name in names if name in self.bridged]
        count = np.concatenate([[0], np.cumsum(np.any(gaps, axis=0))]) if gaps else np.zeros(len(self.times_s) + 1)
        within_s += 1e-9
        first = np.searchsorted(self.times_s, self.times_s - within_s, "left")
        last = np.searchsorted(self.times_s, self.times_s + within_s, "right")
        return np.asarray(count[last] > count[first])


def assumed_lens(width_px: int, height_px: int, field_of_view_rad: float = FIELD_OF_VIEW_RAD) -> Lens:
    """An undistorted camera with its axis in the middle."""
    focal = float(0.5 * width_px / np.tan(0.5 * field_of_view_rad))
    return Lens(width_px, height_px, focal, focal, 0.5 * (width_px - 1), 0.5 * (height_px - 1))


def recording(source: Source) -> Recording:
    """All that is known or follows; a drive without speed, or images to tell it from, is an InputError."""
    said = source.origins.get("times_s")
    source.notes += plausible.frame_times(source.times_s, source.name, said.how if said else "")
    if not source.no_images:
        source.notes += plausible.brightness(
            frame.image for frame in islice(source.frames(), FIRST_FRAMES) if frame.image is not None
        )
    if "poses" in source.signals:
        source.signals["poses"] = derived.from_start(_without_gaps(source, "poses", "pose"))
    _motion_from_poses(source)
    _check_sees_road(source, source.lens, source.mounting or Mounting())
    own = _looked_at(source)
    scale = _height_by_lanes(source)
    if own is not None:
        own = replace(own, speed_mps=own.speed_mps * scale)
        _motion_from_pictures(source, own)
    _yaw_rate_at_last(source)
    if "speed_mps" not in source.signals:
        why = "".join(f"; {note}" for note in source.notes)
        raise InputError(
            f"{source.name}: expected a speed, or poses or pictures of a road to tell it from; found none{why}"
        )
    for name, what in (("speed_mps", "speed"), ("yaw_rate_radps", "yaw rate")):
        source.signals[name] = _without_gaps(source, name, what)
    _commands(source)
    if "poses" not in source.signals:
        speed, rate = source.signals["speed_mps"], source.signals["yaw_rate_radps"]
        way = derived.travelled(source.times_s, speed, rate, source.camera_ahead_m)
        source.derive("poses", way, "from speed and yaw rate: dead reckoning", "speed_mps", "yaw_rate_radps")
    recorded = {name for name, origin in source.origins.items() if origin.kind == "recorded"}
    if "poses" in recorded and source.heading_recorded:
        recorded.add("heading")
    source.notes += agreement.notes(source.times_s, source.signals, frozenset(recorded), source.wheelbase_m)
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


def _looked_at(source: Source) -> calibrate.OwnWay | None:
    """What the pictures say, if they are asked; a mounting that is not known is found in them."""
    asked = source.mounting is None or not {"speed_mps", "yaw_rate_radps"} <= set(source.signals)
    if source.mounting is None and source.no_images:
        source.mounting = Mounting(height_m=source.height_m)
        asked = False
    if not asked or source.no_images:
        return None
    told = [source.signals.get(name) for name in ("speed_mps", "yaw_rate_radps")]
    height_m = source.mounting.height_m if source.mounting else source.height_m
    camera, handed_on = rectified(source.lens, Mounting(height_m=height_m))
    own = calibrate.look(
        rectified_frames(source.frames(), handed_on), camera, source.times_s, told[0], told[1], source.camera_ahead_m
    )
    if source.mounting is None:
        source.mounting = own.mounting
        source.mounting_found = {"pitch": own.pitch, "yaw": own.yaw}
        _tell_mounting(source, own)
    return own


def _height_by_lanes(source: Source) -> float:
    """Put the camera as high as the road's lanes say, if nobody told; how many times as high as thought that is."""
    if not source.height_assumed or source.mounting is None or source.no_images:
        return 1.0
    camera, handed_on = rectified(source.lens, source.mounting)
    config = variant.load(calibrate.VARIANT).road_edges
    frames = rectified_frames(source.frames(), handed_on)
    found = lane_height.height_m(frames, camera, source.times_s, config)
    if found is None:
        return 1.0
    scale = found / source.mounting.height_m
    source.height_m, source.mounting = found, replace(source.mounting, height_m=found)
    said = source.origins["camera"]
    how = f"{said.how}; {found:.2f} m above the road by its lanes, taken to be {config.lane_width_m:g} m wide"
    source.origins["camera"] = Origin(said.kind, how)
    return scale


def _tell_mounting(source: Source, own: calibrate.OwnWay) -> None:
    said = source.origins.get("camera", Origin("recorded"))
    named = (("down", own.pitch), ("right", own.yaw))
    parts = [said.how, *(_angle_words(way, one) for way, one in named)]
    source.origins["camera"] = Origin(said.kind, "; ".join(part for part in parts if part))


def _angle_words(way: str, found: Angle) -> str:
    value, half = np.degrees([found.rad, found.half_width_rad])
    interval = f"{value - half:.1f} to {value + half:.1f} deg {way} by {found.seconds:.1f} s of straight way"
    return f"looks {interval}" if found.is_used else f"taken to look 0 deg {way}: the pictures leave {interval}"


def _motion_from_pictures(source: Source, own: calibrate.OwnWay) -> None:
    if "speed_mps" not in source.signals:
        how = f"from the road's flow, for a camera {source.height_m:g} m above it"
        source.derive("speed_mps", own.speed_mps, how, PICTURES)
    if "yaw_rate_radps" not in source.signals:
        source.derive("yaw_rate_radps", own.yaw_rate_radps, "from the flow", PICTURES)


def _yaw_rate_at_last(source: Source) -> None:
    """By the course over ground, or by the kinematic bicycle: speed x tan(steering) / wheelbase."""
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
        source.put("yaw_rate_radps", np.zeros(len(source.times_s)), "none: nothing tells the turn", "assumed")


def _commands(source: Source) -> None:
    """Steering and throttle as the motion has them, where they were not recorded; unknown where that is bridged."""
    speed, rate = source.signals["speed_mps"], source.signals["yaw_rate_radps"]
    if "steering_rad" not in source.signals:
        angle = derived.steering(speed, rate, source.wheelbase_m)
        how = f"from speed and yaw rate: the kinematic bicycle of {source.wheelbase_m:g} m wheelbase"
        inputs = ("speed_mps", "yaw_rate_radps")
        source.derive("steering_rad", np.where(source.is_bridged(*inputs), np.nan, angle), how, *inputs)
    if "throttle" not in source.signals:
        scale = "full throttle 3 m/s2, full brake 6 m/s2"
        if source.acceleration_mps2 is not None:
            pedals = derived.throttle(source.acceleration_mps2)
            source.put("throttle", pedals, f"from the recorded acceleration; {scale}", "derived")
            return
        unknown = source.is_bridged("speed_mps", within_s=0.5 * derived.SLOPE_WINDOW_S)
        pedals = np.where(unknown, np.nan, derived.throttle(derived.slope(source.times_s, speed)))
        source.derive("throttle", pedals, f"from the speed's slope over 0.5 s; {scale}", "speed_mps")


def _without_gaps(source: Source, name: str, what: str) -> Floats:
    """What the driver needs at every frame is interpolated; that is told, and no score goes by it."""
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
    camera, handed_on = rectified(source.lens, source.mounting)
    if reduction(source.lens.width_px) > 1:
        source.notes.append(f"frames reduced to {camera.width_px} x {camera.height_px} px")
    _tell_uneven_times(source)
    foe = _truth(source, camera)
    if foe is not None:
        source.origins["foe_px"] = Origin("derived", "from the poses")
    speed = source.signals["speed_mps"]

    def frames() -> Iterator[Frame]:
        if source.no_images:
            raise InputError(source.no_images)
        return rectified_frames(_showing_something(source.frames(), speed), handed_on)

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
        no_images=source.no_images,
        files=tuple(source.files),
        bridged=source.bridged,
        foe_px=np.empty(0) if foe is None else foe,
        **{name: source.signals[name] for name in names if name in source.signals},
    )


def _tell_uneven_times(source: Source) -> None:
    """Tracks are taken to be followed at the median interval."""
    steps = np.diff(source.times_s)
    usual, longest, shortest = float(np.median(steps)), float(steps.max()), float(steps.min())
    if longest > 1.5 * usual or shortest < usual / 1.5:
        source.notes.append(f"frames come {shortest:.3f} to {longest:.3f} s apart, usually {usual:.3f} s")


def _check_sees_road(source: Source, lens: Lens, mounting: Mounting) -> None:
    """Intrinsics of another size of picture, or degrees for radians, put the road where nothing is seen."""
    size = f"{lens.width_px} x {lens.height_px} px"
    try:
        for value in (lens.fx_px, lens.fy_px):
            plausible.key("focal length, px", value, "focal_px")
        for value in lens.distortion:
            plausible.key("distortion", value)
    except ValueError as error:
        raise InputError(f"{source.name}: {error}") from None
    if not (0.0 <= lens.cx_px < lens.width_px and 0.0 <= lens.cy_px < lens.height_px):
        centre = f"{lens.cx_px:g}, {lens.cy_px:g}"
        raise InputError(f"{source.name}: expected the camera's axis within its picture of {size}, got {centre}")
    horizon = lens.cy_px - lens.fy_px * np.tan(mounting.pitch_rad)
    if not -0.5 * lens.height_px <= horizon <= 0.9 * lens.height_px:
        row = f"row {horizon:.0f} of its picture of {size}"
        raise InputError(f"{source.name}: expected a camera that sees the road, got the horizon at {row}")


def _truth(source: Source, camera: Camera) -> Floats | None:
    """(N, 2) px of the rectified frames: row k + 1 is the motion from k to k + 1, in the axes half way between."""
    if source.directions_m is None or source.mounting is None:
        return None
    straight = rotation(replace(source.mounting, yaw_rad=0.0, roll_rad=0.0)).T @ rotation(source.mounting)
    result = np.full((len(source.times_s), 2), np.nan)
    result[1 : 1 + len(source.directions_m)] = camera_motion.expansion(camera, source.directions_m @ straight.T)
    return result


def _showing_something(frames: Iterator[Frame], speed_mps: Floats) -> Iterator[Frame]:
    """A picture that shows nothing is a gap, and so is one that comes twice while the car moves, as if it stood."""
    before: Image | None = None
    for frame in frames:
        if frame.image is None:
            yield frame
            continue
        small = frame.image[::4, ::4, 1]
        if plausible.is_blank(small):
            before = None
            yield replace(frame, image=None, fault=f"frame {frame.index}: all of it is of one brightness")
            continue
        moving = speed_mps[frame.index] > REPEAT_LEAST_SPEED_MPS
        same = before is not None and moving and float(cv2.absdiff(small, before).mean()) < REPEAT_GREY_LEVELS
        before = small.copy()
        yield replace(frame, image=None, fault="the picture of the frame before once more") if same else frame
