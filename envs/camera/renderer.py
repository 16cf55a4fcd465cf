"""First-person rendering of a highway-env road."""

from typing import Protocol

import numpy as np
from highway_env.road.road import Road
from highway_env.vehicle.objects import RoadObject
from numpy.typing import NDArray

from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.glass import Glass
from vpf_sim.envs.camera.ground.ground import Ground
from vpf_sim.envs.camera.haze import Haze
from vpf_sim.envs.camera.layout import lane_shapes
from vpf_sim.envs.camera.lens import Lens
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.onboard.bonnet import Bonnet
from vpf_sim.envs.camera.onboard.recorder import ExposureControl, Recorder
from vpf_sim.envs.camera.onboard.windscreen import Windscreen
from vpf_sim.envs.camera.rain.spray import Spray
from vpf_sim.envs.camera.rain.streaks import Streaks
from vpf_sim.envs.camera.rain.wet_road import WetRoad
from vpf_sim.envs.camera.rig import Rig
from vpf_sim.envs.camera.scenery.scene import Scene, Snapshot
from vpf_sim.envs.camera.scenery.shadows import NO_SUN
from vpf_sim.envs.camera.sensor import Sensor
from vpf_sim.envs.camera.sky.sky import Sky
from vpf_sim.envs.camera.truth import Drawn, Moment, truth
from vpf_sim.envs.camera.view import View
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.timing import timed
from vpf_sim.types import Floats, Image


class Carrier(Protocol):
    """The highway-env vehicle that carries the camera."""

    position: Floats  # (2,) m
    heading: float  # rad


class Renderer:
    """Renders one road; a new road needs a new renderer.

    It reads the road's lanes (`position`, `heading_at`, `width_at`, `length`, `line_types`) and its vehicles and
    objects (`position`, `heading`, LENGTH, WIDTH, and if present HEIGHT and `kind`). Without a `kind` a vehicle is a
    car and an obstacle a barrier; landmarks are not drawn. A network may have an `appearance`: verge and surface of the
    road.
    """

    def __init__(self, road: Road, rig: Rig, weather: Weather, seed: int) -> None:
        self._road = road
        light, atmosphere = Light.of(weather), Atmosphere.of(weather)
        shapes = lane_shapes(road)
        self._lens = Lens(rig.camera)
        camera = self._camera = self._lens.pinhole
        self._sky = Sky(camera, light, atmosphere, seed)
        appearance = getattr(road.network, "appearance", None)
        self._haze = Haze(camera, atmosphere, light)
        self._scene = Scene(camera, shapes, light, self._haze, seed)
        shaded = appearance is not None and appearance.shadows and light.shadow < NO_SUN
        shadows = self._scene.scenery_shadows() if shaded else None
        lamplight = self._scene.lamplight
        self._ground = Ground(camera, shapes, light, atmosphere.wetness, seed, appearance, shadows, lamplight)
        self._wet_road = WetRoad(camera, shapes, atmosphere, seed)
        self._spray = Spray(camera, atmosphere, light, seed)
        self._streaks = Streaks(camera, atmosphere, light, weather.streak_gain, seed)
        self._glass = Glass(rig.camera, weather, light, seed)
        self._bonnet = Bonnet(camera, light) if rig.bonnet else None
        self._windscreen = Windscreen(rig, light, seed) if rig.dirt > 0.0 or rig.reflection > 0.0 else None
        self._exposure = ExposureControl(rig.auto_exposure_s)
        self._recorder = Recorder(rig)
        self._sensor = Sensor(rig, weather, seed)
        self._drawn: list[Drawn] | None = None  # items of the last frame; None if it was skipped
        self._now: Snapshot | None = None
        self._before: Snapshot | None = None

    @property
    def objects(self) -> list[RoadObject]:
        """The objects: `truth`'s instance i + 1 is objects[i]."""
        return [] if self._now is None else self._now.objects

    @timed("render")
    def render(self, ego: Carrier, time_s: float) -> Image:
        """(H, W, 3) RGB, a fresh array: the frame of the camera on `ego` at its present pose."""
        now, before = self._advance(ego, time_s)
        frame = np.empty((self._camera.height_px, self._camera.width_px, 3), np.uint8)
        self._draw_world(frame, now, before)
        if self._bonnet is not None:
            self._bonnet.draw(frame)
        self._streaks.draw(frame, now, before)
        frame = self._recorder.read_out(self._lens.distorted(frame), now, before)
        self._glass.draw(frame, now, before)
        if self._windscreen is not None:
            self._windscreen.draw(frame)
        self._exposure.apply(frame, time_s)
        self._sensor.expose(frame)
        return self._recorder.record(frame, now, before)

    @timed("skip")
    def skip(self, ego: Carrier, time_s: float) -> None:
        """Skip a frame; later frames are the same to the last bit.

        The frame is drawn only if later frames reuse parts of it (reflections).
        """
        if self._wet_road.is_due or self._exposure.is_due(time_s):
            self.render(ego, time_s)
            return
        now, before = self._advance(ego, time_s)
        self._drawn = None
        self._ground.update(now.view)
        self._scene.update(now)
        self._wet_road.skip(now.view)
        self._glass.skip(now, before)
        self._sensor.skip()

    def truth(self, names: tuple[str, ...]) -> dict[str, NDArray[np.generic]]:
        """The ground truth `names` of the last frame (see `vpf_sim.envs.camera.truth`), and `hidden`.

        `hidden` is (H, W) bool: pixels that reflections, spray, drops, wipers, dirt or the bonnet hide or falsify. A
        skipped frame has `foe` only.
        """
        if self._now is None or self._before is None:
            raise RuntimeError("no frame has been rendered yet")
        if self._drawn is None and set(names) - {"foe"}:
            raise RuntimeError(f"truth: expected a frame that was rendered for {', '.join(names)}, got one skipped")
        moment = Moment(self._now.view, self._before.view, self._now.time_s - self._before.time_s)
        result = truth(names, moment, self._drawn or [], self._lens)
        if "hidden" in names:
            outside = self._wet_road.hidden() | self._spray.hidden()
            if self._bonnet is not None:
                hides = self._bonnet.hides()
                outside[-len(hides) :] |= hides
            hidden = self._lens.nearest(outside) | self._glass.hidden()
            result["hidden"] = hidden if self._windscreen is None else hidden | self._windscreen.hidden()
        return result

    def _advance(self, ego: Carrier, time_s: float) -> tuple[Snapshot, Snapshot]:
        """Record all poses; returns the present snapshot and the one before."""
        view = View.at(self._camera, ego.position, ego.heading)
        objects = [obj for obj in (*self._road.vehicles, *self._road.objects) if obj is not ego]
        poses = {obj: self._pose(obj) for obj in objects}
        now = Snapshot(view, time_s, objects, poses)
        self._before, self._now = self._now or now, now
        return now, self._before

    def _pose(self, obj: RoadObject) -> Floats:
        """(3,) x m, y m, heading rad of an object; the same array while it does not move."""
        pose = [*obj.position.tolist(), float(obj.heading)]
        before = None if self._now is None else self._now.poses.get(obj)
        return before if before is not None and before.tolist() == pose else np.array(pose)

    def _draw_world(self, frame: Image, now: Snapshot, before: Snapshot) -> None:
        """Draw everything outside the windscreen except falling rain."""
        self._sky.draw(now.view, frame)
        self._ground.draw(now.view, frame)
        self._haze.ground(frame)
        drawn = self._drawn = self._scene.visible(now, before)
        self._wet_road.draw(frame, now.view, drawn)
        self._scene.paint_shadows(frame, now)
        self._scene.paint(frame, self._spray.added(drawn, now, before))
