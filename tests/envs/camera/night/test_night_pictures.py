"""Pictures at night: what headlamps light, lamps of others, their mirror images, and what stays as it is."""

import numpy as np
import pytest
from highway_env.road.road import Road
from highway_env.vehicle.kinematics import Vehicle
from highway_scenes import WIDTH_M, add_ego, add_object, straight_road

from vpf_sim.envs.camera import Renderer, Rig, weather
from vpf_sim.envs.camera.light import Light
from vpf_sim.envs.camera.night.glow import flux_px
from vpf_sim.envs.camera.scenery.bands import banded
from vpf_sim.envs.camera.scenery.object_meshes import object_mesh
from vpf_sim.types import Camera, Image

CAMERA = Camera()
EGO = np.array([20.0, 1.5 * WIDTH_M])  # on the line between two lanes
AHEAD_M = CAMERA.forward_m  # of the camera, from the car's middle
NO_POSTS, POSTS = 3, 5  # seeds of roads without lamp posts, and with


def renderer(road: Road, name: str, seed: int = NO_POSTS) -> Renderer:
    return Renderer(road, Rig(CAMERA, noise_sd=0.0), weather.load(name), seed)


def picture(name: str, road: Road | None = None, seed: int = NO_POSTS) -> Image:
    road = straight_road() if road is None else road
    return renderer(road, name, seed).render(add_ego(road, EGO), 0.0)


def road_with_car(ahead_m: float, right_m: float = 0.0, heading: float = 0.0) -> Road:
    """A road with a moving car whose rear end, or front end, is `ahead_m` before the camera."""
    road = straight_road()
    place = EGO + np.array([AHEAD_M + ahead_m + 2.5, right_m])
    road.vehicles.append(Vehicle(road, place, heading, 5.0))
    return road


def row_at(ahead_m: float) -> int:
    """The row of the road `ahead_m` from the camera."""
    return round(CAMERA.cy_px + CAMERA.fy_px * CAMERA.height_m / ahead_m)


def column_at(ahead_m: float, right_m: float) -> int:
    return round(CAMERA.cx_px + CAMERA.fx_px * right_m / ahead_m)


def level(frame: Image, ahead_m: float, right_m: float, half: int = 6) -> float:
    """Mean level of the road at a place from the camera."""
    y, x = row_at(ahead_m), column_at(ahead_m, right_m)
    return float(frame[y : y + 2, x - half : x + half].mean())


def test_road_is_lit_ahead_and_dark_beyond_the_cut_off() -> None:
    frame = picture("ClearNight")
    levels = [level(frame, ahead_m, -0.5 * WIDTH_M) for ahead_m in (16.0, 32.0, 55.0, 110.0)]
    assert np.all(np.diff(levels) < 0.0)
    assert levels[0] > 50.0, "readable right ahead"
    assert levels[-1] < 12.0, "nothing lights it"


def test_light_falls_off_to_the_sides() -> None:
    frame = picture("ClearNight")
    assert level(frame, 9.0, 1.2) > level(frame, 9.0, 4.5) > level(frame, 9.0, 8.0)


def test_without_headlamps_the_road_is_dark(monkeypatch: pytest.MonkeyPatch) -> None:
    lit = picture("ClearNight")
    monkeypatch.setattr("vpf_sim.envs.camera.night.low_beam.PEAK_CD", 0.0)
    monkeypatch.setattr("vpf_sim.envs.camera.night.low_beam.ABOVE_CD", 0.0)
    dark = picture("ClearNight")
    assert dark[row_at(20.0) :].max() < 3
    assert lit[row_at(20.0) :].mean() > 30.0


def test_markings_stand_out_more_at_night_than_by_day_and_less_in_the_wet() -> None:
    """RW1 paint returns ten times the light of asphalt to the driver, and loses most of it in the wet (EN 1436)."""

    def contrast(name: str) -> float:
        frame = picture(name).astype(float).mean(axis=2)
        found = []
        for row in range(row_at(20.0), row_at(8.0)):
            ahead_m = CAMERA.fy_px * CAMERA.height_m / (row - CAMERA.cy_px)
            line, lane = column_at(ahead_m, 0.0), column_at(ahead_m, 0.5 * WIDTH_M)
            found.append(frame[row, line - 6 : line + 7].max() / frame[row, lane - 10 : lane + 10].mean())
        return float(np.quantile(found, 0.9) ** 2.2)

    assert contrast("ClearNight") > 1.3 * contrast("ClearNoon")
    assert contrast("ClearNight") > 1.5 * contrast("HardRainNight")


@pytest.mark.parametrize(("kind", "height_m"), [("van", 1.6), ("truck", 2.0)])
def test_cut_off_shows_on_a_vehicle(kind: str, height_m: float) -> None:
    """12 m ahead it lies about 0.5 m high: the lower end is bright, the upper is not."""
    road = straight_road()
    add_object(road, kind, [EGO[0] + AHEAD_M + 12.0 + 4.25, EGO[1]])
    ahead_m = 12.0 + (1.5 if kind == "van" else 0.0)
    frame = picture("ClearNight", road).astype(float)

    def at(up_m: float) -> float:
        y = round(CAMERA.cy_px + CAMERA.fy_px * (CAMERA.height_m - up_m) / ahead_m)
        x = column_at(ahead_m, 0.0)
        return float(frame[y - 1 : y + 1, x - 20 : x + 20].max())

    assert at(height_m) < 0.75 * at(0.4)


def test_banded_mesh_covers_the_same_area() -> None:
    mesh = object_mesh("truck", (8.5, 2.5, 3.4), np.random.default_rng(1))
    cut = banded(mesh)
    assert len(cut.faces_m) > len(mesh.faces_m)

    def area(faces: np.ndarray) -> float:
        spokes = faces - faces[:, :1]
        return float(0.5 * np.linalg.norm(np.cross(spokes[:, 1:-1], spokes[:, 2:]), axis=2).sum())

    assert area(cut.faces_m) == pytest.approx(area(mesh.faces_m))


def red(frame: Image, ahead_m: float, right_m: float) -> float:
    """How much redder than blue the picture is where a car's tail lamp is."""
    y = round(CAMERA.cy_px + CAMERA.fy_px * (CAMERA.height_m - 0.78) / ahead_m)
    x = column_at(ahead_m, right_m)
    spot = frame[y - 2 : y + 3, x - 2 : x + 3].astype(float)
    return float((spot[..., 0] - spot[..., 2]).max())


def test_tail_lamps_of_a_car_60_m_ahead_are_bright_red_spots() -> None:
    frame = picture("ClearNight", road_with_car(60.0))
    for side in (-1.0, 1.0):
        assert red(frame, 60.0, side * 0.39 * 2.0) > 100.0
    assert red(picture("ClearNight"), 60.0, 0.78) < 10.0


def test_a_parked_car_has_no_lamps_on() -> None:
    road = straight_road()
    add_object(road, "car", [EGO[0] + AHEAD_M + 62.5, EGO[1]])
    assert red(picture("ClearNight", road), 60.0, 0.78) < 60.0


def test_oncoming_headlamps_glare_more_as_they_come_nearer() -> None:
    sizes = []
    for ahead_m in (120.0, 60.0, 30.0):
        frame = picture("ClearNight", road_with_car(ahead_m, -WIDTH_M, np.pi))
        sizes.append(int((frame.min(axis=2) > 240).sum()))
    assert 0 < sizes[0] < sizes[1] < sizes[2]


def test_light_of_a_lamp_falls_with_the_squared_distance() -> None:
    near, far = (flux_px(CAMERA, 8.0 / distance_m**2, 30.0) for distance_m in (30.0, 60.0))
    assert near == pytest.approx(4.0 * far)


def test_wet_road_mirrors_tail_lamps_as_streaks_below_them() -> None:
    ahead_m, up_m = 25.0, 0.78
    mirrored = round(CAMERA.cy_px + CAMERA.fy_px * (CAMERA.height_m + up_m) / ahead_m)
    x = column_at(ahead_m, 0.39 * 2.0)

    def redness(name: str) -> Image:
        frame = picture(name, road_with_car(ahead_m)).astype(float)
        return frame[..., 0] - frame[..., 2]

    wet, dry = redness("WetNight"), redness("ClearNight")
    streak = (slice(mirrored - 3, mirrored + 4), slice(x - 1, x + 2))
    assert wet[streak].mean() > dry[streak].mean() + 25.0
    box = wet[mirrored - 20 : mirrored + 21, x - 20 : x + 4] > 0.5 * wet[streak].mean()
    assert box.any(axis=1).sum() > 2 * box.any(axis=0).sum(), "taller than wide"


def test_street_lamps_light_the_road() -> None:
    road = straight_road()
    with_posts, without = picture("ClearNight", road, POSTS), picture("ClearNight", seed=NO_POSTS)
    far = slice(row_at(130.0), row_at(75.0))
    assert with_posts[far].mean() > 1.5 * without[far].mean()
    assert with_posts[: row_at(1e4)].max() > 240, "the lamps themselves"


def test_dusk_is_between_day_and_night() -> None:
    for rows in (slice(0, 200), slice(250, 330)):
        day, dusk, night = (picture(name)[rows].mean() for name in ("ClearSunset", "ClearDusk", "ClearNight"))
        assert day > 1.2 * dusk > 1.44 * night


def test_by_day_lamps_are_off_and_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    before = picture("HardRainSunset", road_with_car(20.0), POSTS)
    for name in ("low_beam.PEAK_CD", "lamps.TAIL_CD", "lamps.STREET_CD"):
        monkeypatch.setattr(f"vpf_sim.envs.camera.night.{name}", 1e6)
    assert np.array_equal(picture("HardRainSunset", road_with_car(20.0), POSTS), before)


def test_truth_is_that_of_the_day() -> None:
    found = []
    for name in ("ClearNoon", "ClearNight"):
        road = road_with_car(15.0, -WIDTH_M)
        add_object(road, "van", [EGO[0] + 25.0, EGO[1] + WIDTH_M])
        ego = add_ego(road, EGO)
        camera = renderer(road, name, POSTS)
        camera.render(ego, 0.0)
        ego.position = ego.position + np.array([0.3, 0.0])
        camera.render(ego, 0.05)
        found.append(camera.truth(("depth", "instance", "flow")))
    day, night = found
    same = day["instance"] == night["instance"]
    assert same.mean() > 0.9995, "edges of cut faces are rounded"
    for name in ("depth", "flow"):
        equal = np.isclose(day[name], night[name], rtol=1e-3, atol=1e-3)
        assert equal.mean() > 0.9995


def test_skipped_frames_change_nothing() -> None:
    frames = []
    for skips in (False, True):
        road = road_with_car(12.0)
        ego, other = add_ego(road, EGO), road.vehicles[0]
        camera = renderer(road, "HardRainNight", POSTS)
        for k in range(8):
            ego.position, other.position = EGO + np.array([0.25 * k, 0.0]), EGO + np.array([18.0 + 0.4 * k, 0.0])
            if skips and k not in (0, 7):
                camera.skip(ego, 0.05 * k)
            else:
                last = camera.render(ego, 0.05 * k)
        frames.append(last)
    assert np.array_equal(*frames)


@pytest.mark.parametrize(
    ("altitude_deg", "cloudiness", "on"), [(15.0, 100.0, False), (3.0, 0.0, False), (-1.0, 0.0, True)]
)
def test_lamps_are_on_below_1000_lx(altitude_deg: float, cloudiness: float, on: bool) -> None:
    """Overcast at 15 deg the sky gives 5700 lx, clear at -1 deg 320 lx (IES, and 0.4 decades a degree)."""
    sky = weather.Weather(name="sky", sun_altitude_angle=altitude_deg, cloudiness=cloudiness)
    assert Light.of(sky).has_lamps is on
