"""vpf_sim/FourLane-v0: the ego car on a scenario's road, observed through its camera."""

from vpf_sim.envs import import_highway_env  # noqa: F401 - before anything else imports highway-env

# isort: split
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, get_args

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from highway_env.road.road import Road
from numpy.typing import NDArray

from vpf_sim import scenarios
from vpf_sim.driver_interface import Turn
from vpf_sim.envs import camera as cameras
from vpf_sim.envs.camera import Rig
from vpf_sim.envs.camera import weather as weathers
from vpf_sim.envs.camera.rig import checked_rig, preset
from vpf_sim.envs.contacts import distance, nearest, solid_objects
from vpf_sim.envs.ego import MAX_SPEED_MPS, YAW_RATE_LIMIT_RADPS, Ego
from vpf_sim.envs.ending import TERMINATED, TRUNCATED, Ending, Status
from vpf_sim.envs.network import OnRoad
from vpf_sim.envs.sensors import CameraFaults, Sensors, SignalFaults
from vpf_sim.envs.world import build_world
from vpf_sim.errors import InputError, refuse_options, refuse_unknown, unknown_name
from vpf_sim.geometry import wrap_angle
from vpf_sim.scenarios import AnyScenario, HighwayScenario
from vpf_sim.timing import timed
from vpf_sim.types import Camera, Floats, Image, VehicleModel
from vpf_sim.window import Window

RATES_HZ = (60.0, 20.0)
TRUTHS = ("depth", "flow", "foe", "ttc", "instance", "hidden")
FARTHEST_M, LONGEST_S = 1e5, 1e5
TURNS: tuple[Turn, ...] = get_args(Turn)

EnvObservation = dict[str, NDArray[Any]]


class FourLane(gymnasium.Env[EnvObservation, Any]):
    """Gymnasium environment with one clock: a step is one action, one tick and one camera frame.

    Action: throttle (negative brakes) and steering (+ is right) in [-1, 1]. Observation: `image` (H, W, 3) RGB, `ego`
    (x, y, yaw, speed, yaw rate) in m, rad, s, `goal` (x, y) m, `time` s. Reward: metres of route gained / 10, less 0.01
    x squared change of action, less 5 on collision or off_road, plus 5 on success. `info`: `status` ("running" until
    the end), `is_success` as Stable-Baselines3 reads it, `route_m`, `lane_offset_m` from the centre of the ego's lane
    (+ is right), `clearance_m` to the nearest object, `collided_with`, and the arrays that `truth` names; after an
    invalid frame also `invalid_frame` with its number, `time_s` and `fault`; with sensor errors or faults also `ego`,
    the true state. Success, collision and off_road terminate; timeout, stuck and invalid_frame truncate.

    With camera faults in the scenario (`ego.sensor_faults`), `image` is the last frame that has arrived, the
    observation has its exposure time as `frame_time`, s, and every frame is drawn. `render` shows the frame before the
    faults.

    With `frames=False` nothing is rendered: there is no `image` and no invalid frame, and all else is the same.

    On highway-env's roads the observation has `turn`, the index in `TURNS` of the way to take where roads part.

    Arrays of observations, of `info` and of `render` are the caller's own: changing them changes nothing else.

    `scenario` and `weather` are names of the catalogs, paths of TOML files, or loaded objects. After a reset `scenario`
    is the one drawn for the seed, and `road`, `ego`, `route` and `goal_m` belong to the episode.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array", "human"], "render_fps": 60}  # noqa: RUF012 (gymnasium's)

    road: Road
    ego: Ego
    route: Floats
    goal_m: tuple[float, float]
    route_length_m: float
    episode_seed: int

    def __init__(
        self,
        scenario: str | Path | AnyScenario = "town04",
        weather: "str | Path | weathers.Weather" = "clear",
        render_mode: str | None = None,
        truth: Sequence[str] = (),
        rate_hz: float = 60.0,
        rig: Rig | None = None,
        frames: bool = True,
        **unknown: Any,
    ) -> None:
        refuse_unknown(unknown, FourLane)
        self.vehicle_model = VehicleModel()
        self.rate_hz = _checked_rate(rate_hz)
        self.metadata = {**self.metadata, "render_fps": round(rate_hz)}
        self.render_mode = _checked_name("render mode", render_mode, self.metadata["render_modes"])
        self._truth = _checked_truth(truth)
        self._takes_frames = frames
        if not isinstance(frames, bool):
            raise InputError(f"frames: expected True or False, got {frames!r}")
        if not frames and (self.render_mode or self._truth):
            raise InputError("frames: expected them to be taken for a render mode or for truth, got False")
        self._template = scenarios.load(scenario)
        self.rig = preset(self._template.ego.camera) if rig is None else checked_rig(rig)
        self.camera = self.rig.camera
        self.scenario = self._template.draw(0)
        self.weather = weathers.load(weather)
        self.speed_reference_mps = self._template.ego.speed_reference_mps
        self.action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)
        self._faults = self._template.ego.sensor_faults
        self._camera_faulty = frames and self._faults.affect_camera
        self._tells_turns = isinstance(self._template, HighwayScenario)
        camera = self.camera if frames else None
        self.observation_space = _observation_space(camera, self._camera_faulty, self._tells_turns)
        self._low, self._high = _ego_bounds()
        self._window: Window | None = None
        self._ending: Ending | None = None  # before the first reset

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[EnvObservation, dict[str, Any]]:
        """Begin the episode of a seed; without one, the seed comes from gymnasium's generator. There are no options."""
        refuse_options(options)
        super().reset(seed=seed, options=options)
        self.episode_seed = int(self.np_random.integers(2**31)) if seed is None else seed
        self.scenario = self._template.draw(self.episode_seed)
        self._build_world()
        self._renderer = self._new_renderer() if self._takes_frames else None
        self._sensors = Sensors(self.scenario.ego.sensors, self.camera, self.rate_hz, self.episode_seed)
        self._signal_faults = SignalFaults(self._faults, self.episode_seed)
        self._camera_faults = CameraFaults(self._faults, self.rate_hz, self.episode_seed)
        self._steps, self._route_m = 0, self._path.progress(self.ego.place[0])
        self._action = np.zeros(2)
        self._frame = self._take_frame()
        shape = (self.camera.height_px, self.camera.width_px, 3)
        self._ending = Ending(self.scenario, self._path, self.rate_hz, self.ego, self._frame, shape)
        self._show()
        return self._observation(), self._info(self._ending.status_at_reset)

    @timed("world")
    def step(
        self, action: NDArray[np.float32], *, with_frame: bool = True, ticks: int = 1
    ) -> tuple[EnvObservation, float, bool, bool, dict[str, Any]]:
        """Apply throttle and steering for one tick of the clock, or hold them for several or until the episode ends.

        With `with_frame=False` the frame of this step is not drawn: there is no `image`, of the truth only `foe`, and
        all else and all later frames are the same. Of several ticks the camera takes only the last, like one of a lower
        frame rate; cameras with faults take all.
        """
        ending, command = self._running("step"), _checked_action(action)
        if ticks < 1:
            raise ValueError(f"ticks: expected at least 1, got {ticks}")
        status = self._hold(command, ticks - 1, ending)
        if status == "running":
            self.advance(command)
            self._frame = self._take_frame(with_frame)
            status = ending.status(self.ego, self._frame)
        else:
            self._frame = self._take_frame(with_frame)
        reward = self._reward(command, status)
        self._show()
        return self._observation(), reward, status in TERMINATED, status in TRUNCATED, self._info(status)

    def _hold(self, command: Floats, ticks: int, ending: Ending) -> Status:
        """The status after ticks without a picture, or at the first that ends the episode."""
        status: Status = "running"
        for _ in range(ticks):
            self.advance(command)
            status = ending.status(self.ego, self._take_frame() if self._camera_faulty else None)
            if status != "running":
                break
        return status

    @property
    def route_m(self) -> float:
        """m along the route from the start to the ego."""
        return self._path.progress(self.ego.place[0])

    @property
    def nearest(self) -> tuple[float, OnRoad | None]:
        """m from the ego to the nearest object, and that object, at the last reset or step; inf and None without."""
        return self._nearest

    @property
    def renderer(self) -> cameras.Renderer | None:
        """The camera of the episode, for access to ground truth; None with `frames=False`."""
        return self._renderer

    @timed("physics")
    def advance(self, command: Floats) -> None:
        """The physics of a step, without a frame: throttle and steering for one tick."""
        self.ego.act(self._controls(command))
        self._world.advance(self._steps, self.rate_hz)
        self._steps += 1

    def render(self) -> Image | None:
        """The last frame, for `rgb_array`; for `human`, reset and step draw the window."""
        self._running("render")
        return self._frame.copy() if self.render_mode == "rgb_array" and self._frame is not None else None

    def close(self) -> None:
        if self._window is not None:
            self._window.close()
            self._window = None

    def _running(self, what: str) -> Ending:
        """The ending of the running episode; ResetNeeded before the first reset."""
        if self._ending is None:
            raise ResetNeeded(f"{what}: expected reset() first")
        return self._ending

    def _new_renderer(self) -> cameras.Renderer:
        return cameras.Renderer(self.road, self.rig, self.weather, self.episode_seed)

    def _take_frame(self, with_frame: bool = True) -> Image | None:
        """The camera's present frame as a fresh array; None if it is not needed."""
        if self._renderer is None:
            return None
        take = self._renderer.render if with_frame or self._camera_faulty else self._renderer.skip
        frame = self._sensors.frame(take(self.ego, self._steps / self.rate_hz))
        if self._camera_faulty and frame is not None:
            self._arrived, self._arrived_s = self._camera_faults.frame(frame, self._steps / self.rate_hz)
        return frame

    def _build_world(self) -> None:
        """Build the road, its objects and the ego car."""
        self._world = build_world(self.scenario, self.episode_seed, self.weather.road_friction)
        self.road, self.ego, self._path = self._world.road, self._world.ego, self._world.route
        self.route, self.goal_m = self._path.waypoints(), self._path.goal_m
        self.route_length_m = self._path.length_m

    def _controls(self, command: Floats) -> dict[str, float]:
        """Acceleration and steering angle for a command in [-1, 1]."""
        throttle, steering = command.tolist()
        model = self.vehicle_model
        return {"acceleration": throttle * model.full_mps2(throttle), "steering": steering * model.steering_limit_rad}

    def _reward(self, command: Floats, status: Status) -> float:
        """The reward of a step; see the class."""
        before_m, self._route_m = self._route_m, self._path.progress(self.ego.place[0])
        change, self._action = command - self._action, command
        end = {"success": 5.0, "collision": -5.0, "off_road": -5.0}.get(status, 0.0)
        return (self._route_m - before_m) / 10.0 - 0.01 * float(change @ change) + end

    @timed("observation")
    def _observation(self) -> EnvObservation:
        measured = self._signal_faults.read(self._sensors.read(self._state()), self._steps / self.rate_hz)
        return {
            **self._image(),
            "ego": np.minimum(np.maximum(measured, self._low), self._high),
            "goal": np.array(self.goal_m),
            "time": np.array([self._steps / self.rate_hz]),
            **self._turn(),
        }

    def _turn(self) -> dict[str, Any]:
        """The way to take where roads part, as its index in `TURNS`, on roads that have forks."""
        return {"turn": np.int64(TURNS.index(self._path.turn(self._route_m)))} if self._tells_turns else {}

    def _image(self) -> EnvObservation:
        """The camera's part of the observation, as a copy: its frame, or with faults the last that has arrived."""
        if self._camera_faulty:
            return {"image": self._arrived.copy(), "frame_time": np.array([self._arrived_s])}
        return {} if self._frame is None else {"image": self._frame.copy()}

    def _state(self) -> Floats:
        """(5,) the true x, y, yaw in (-pi, pi], speed, yaw rate."""
        ego = self.ego
        yaw_rate = min(max(ego.yaw_rate_radps, -YAW_RATE_LIMIT_RADPS), YAW_RATE_LIMIT_RADPS)
        return np.array([*ego.position.tolist(), -wrap_angle(-ego.heading), ego.speed, yaw_rate])

    @timed("info")
    def _info(self, status: Status) -> dict[str, Any]:
        self._nearest = nearest(self.ego)
        return {
            "status": status,
            "is_success": status == "success",
            "route_m": self._route_m,
            "lane_offset_m": self.ego.place[1] - self._path.offset_at(self.ego.place[0]),
            "clearance_m": self._nearest[0],
            "collided_with": self._collided_with() if status == "collision" else None,
            **({"ego": self._state()} if self._reads_with_errors else {}),
            **({"invalid_frame": asdict(invalid)} if (invalid := self._running("info").invalid_frame) else {}),
            **(self._renderer.truth(self._available_truth) if self._renderer and self._available_truth else {}),
        }

    @property
    def _reads_with_errors(self) -> bool:
        """Whether the observed state may differ from the true one."""
        return not self._sensors.are_exact or self._faults.affect_signals

    @property
    def _available_truth(self) -> tuple[str, ...]:
        """The requested truth that this step has."""
        return self._truth if self._frame is not None else tuple(name for name in self._truth if name == "foe")

    def _collided_with(self) -> str:
        """The kind of the object hit: the nearest of those in contact."""
        hit = min((obj for obj in solid_objects(self.ego) if obj.crashed), key=lambda obj: distance(self.ego, obj))
        return str(hit.kind)

    def _show(self) -> None:
        if self.render_mode == "human" and self._frame is not None:
            self._window = self._window or Window(self.camera.width_px, self.camera.height_px, self.rate_hz)
            self._window.show(self._frame)


def _ego_bounds() -> tuple[Floats, Floats]:
    """Lower and upper bounds of the five values."""
    high = np.array([FARTHEST_M, FARTHEST_M, np.pi, MAX_SPEED_MPS, YAW_RATE_LIMIT_RADPS])
    return np.array([-1.0, -1.0, -1.0, 0.0, -1.0]) * high, high


def _observation_space(camera: Camera | None, stamped: bool, tells_turns: bool) -> Any:
    """The observation space; with `stamped` also the image's exposure time, with `tells_turns` the way to take."""
    low, high = _ego_bounds()
    shape = None if camera is None else (camera.height_px, camera.width_px, 3)
    return spaces.Dict(
        {
            **({} if shape is None else {"image": spaces.Box(0, 255, shape, np.uint8)}),
            "ego": spaces.Box(low, high, dtype=np.float64),
            "goal": spaces.Box(-FARTHEST_M, FARTHEST_M, (2,), np.float64),
            "time": spaces.Box(0.0, LONGEST_S, (1,), np.float64),
            **({"frame_time": spaces.Box(0.0, LONGEST_S, (1,), np.float64)} if stamped else {}),
            **({"turn": spaces.Discrete(len(TURNS))} if tells_turns else {}),
        }
    )


def _checked_rate(rate_hz: float) -> float:
    if rate_hz not in RATES_HZ:
        got = f"{rate_hz:g}" if isinstance(rate_hz, int | float) else repr(rate_hz)
        raise InputError(f"rate_hz: expected 60 or 20, got {got}")
    return float(rate_hz)


def _checked_name(what: str, name: str | None, known: Sequence[str]) -> str | None:
    if name is not None and name not in known:
        raise unknown_name(what, str(name), known)
    return name


def _checked_truth(truth: Sequence[str]) -> tuple[str, ...]:
    """The names in a list or tuple; a string is refused."""
    if isinstance(truth, str) or not isinstance(truth, Iterable):
        raise InputError(f"truth: expected a tuple of names, such as ('depth',), got {truth!r}")
    return tuple(str(_checked_name("truth", name, TRUTHS)) for name in truth)


def _checked_action(action: NDArray[np.float32]) -> Floats:
    """The action as a fresh array, clipped to [-1, 1]."""
    try:
        command = np.array(action, np.float64)
    except (TypeError, ValueError):  # not numeric
        command = np.empty(0)
    if command.shape != (2,) or not np.isfinite(command).all():
        raise ValueError(f"action: expected two finite numbers in [-1, 1], throttle and steering, got {action}")
    return np.minimum(np.maximum(command, -1.0), 1.0)
