"""First-person rendering of a highway-env road."""

import numpy as np
from highway_env.road.road import Road
from highway_env.vehicle.objects import RoadObject
from numpy.typing import NDArray

from vpf_sim.envs.camera import made_worlds
from vpf_sim.envs.camera.atmosphere import Atmosphere
from vpf_sim.envs.camera.glass import Glass
from vpf_sim.envs.camera.lens import Lens
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.onboard.bonnet import Bonnet
from vpf_sim.envs.camera.onboard.recorder import ExposureControl, Recorder
from vpf_sim.envs.camera.onboard.windscreen import Windscreen
from vpf_sim.envs.camera.rain.streaks import Streaks
from vpf_sim.envs.camera.rig import Rig
from vpf_sim.envs.camera.sensor import Sensor
from vpf_sim.envs.camera.snapshot import Carrier, Snapshot
from vpf_sim.envs.camera.truth import Moment, truth
from vpf_sim.envs.camera.weather import Weather
from vpf_sim.timing import timed
from vpf_sim.types import Image


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
        self._lens = Lens(rig.camera)
        camera = self._camera = self._lens.pinhole
        self._world = made_worlds.world(road, camera, weather, seed)
        self._streaks = Streaks(camera, atmosphere, light, weather.streak_gain, seed)
        self._glass = Glass(rig.camera, weather, light, seed)
        self._bonnet = Bonnet(camera, light) if rig.bonnet else None
        self._windscreen = Windscreen(rig, light, seed) if rig.dirt > 0.0 or rig.reflection > 0.0 else None
        self._exposure = ExposureControl(rig.auto_exposure_s)
        self._recorder = Recorder(rig)
        self._sensor = Sensor(rig, weather, seed)
        self._is_drawn = False  # whether the last frame was drawn, not skipped
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
        self._world.draw(frame, now, before)
        self._is_drawn = True
        if self._bonnet is not None:
            self._bonnet.draw(frame)
        self._streaks.draw(frame, now, before)
        frame = self._recorder.read_out(self._lens.distorted(frame), now, before)
        self._glass.draw(frame, now, before)
        if self._windscreen is not None:
            self._windscreen.draw(frame)
        self._exposure.apply(frame, time_s)
        self._sensor.expose(frame, time_s)
        return self._recorder.record(frame, now, before)

    @timed("skip")
    def skip(self, ego: Carrier, time_s: float) -> None:
        """Skip a frame; later frames are the same to the last bit.

        The frame is drawn only if the exposure control measures it.
        """
        if self._exposure.is_due(time_s):
            self.render(ego, time_s)
            return
        now, before = self._advance(ego, time_s)
        self._is_drawn = False
        self._glass.skip(now, before)

    def truth(self, names: tuple[str, ...]) -> dict[str, NDArray[np.generic]]:
        """The ground truth `names` of the last frame (see `vpf_sim.envs.camera.truth`), and `hidden`.

        `hidden` is (H, W) bool: pixels that reflections, spray, drops, wipers, dirt or the bonnet hide or falsify. A
        skipped frame has `foe` only.
        """
        if self._now is None or self._before is None:
            raise RuntimeError("no frame has been rendered yet")
        if not self._is_drawn and set(names) - {"foe"}:
            raise RuntimeError(f"truth: expected a frame that was rendered for {', '.join(names)}, got one skipped")
        result = truth(names, Moment(self._now, self._before), self._world.shown, self._lens)
        if "hidden" in names:
            outside = self._world.hidden()
            if self._bonnet is not None:
                hides = self._bonnet.hides()
                outside[-len(hides) :] |= hides
            hidden = self._lens.nearest(outside) | self._glass.hidden()
            result["hidden"] = hidden if self._windscreen is None else hidden | self._windscreen.hidden()
        return result

    def _advance(self, ego: Carrier, time_s: float) -> tuple[Snapshot, Snapshot]:
        """Record all poses; returns the present snapshot and the one before."""
        objects = [obj for obj in (*self._road.vehicles, *self._road.objects) if obj is not ego]
        now = Snapshot.of(self._camera, ego, time_s, objects)
        self._before, self._now = self._now or now, now
        return now, self._before
