"""Ground truth against independent reprojection, and against Lucas-Kanade on rendered frames."""

import cv2
import numpy as np
import pytest
from highway_env.vehicle.kinematics import Vehicle
from highway_scenes import add_ego, add_object, bent_road, on_bend, straight_road

from vpf_sim.envs.camera import Renderer, Rig, weather
from vpf_sim.geometry import ground_from_pixels, project, vehicle_from_world, world_from_vehicle
from vpf_sim.types import Camera

CLEAR = weather.load("clear")
SPEED_MPS, RATE_HZ = 5.55, 60.0
ALL = ("depth", "flow", "foe", "ttc", "instance", "hidden")


def straight_scene(seed=4):
    road = straight_road()
    ego = add_ego(road, [20.0, 7.0])
    for kind, place in (("car", [36.0, 3.6]), ("van", [34.0, 10.6]), ("truck", [44.0, 7.4])):
        add_object(road, kind, place)
    return road, ego, Renderer(road, Rig(Camera(), noise_sd=0.0), CLEAR, seed)


def bent_scene(seed=4):
    road = bent_road()
    ego = add_ego(road, *on_bend(2.0, 1.75))
    for s, right in ((16.0, 3.5), (22.0, -3.5), (28.0, 2.0)):
        add_object(road, "car", *on_bend(s, right))
    return road, ego, Renderer(road, Rig(Camera(), noise_sd=0.0), CLEAR, seed)


def advance(ego, curvature):
    step = SPEED_MPS / RATE_HZ
    middle = ego.heading + 0.5 * curvature * step
    ego.position = ego.position + step * np.array([np.cos(middle), np.sin(middle)])
    ego.heading += curvature * step


SCENES = {"straight": (straight_scene, 0.0), "bend": (bent_scene, 1.0 / 98.25)}


def pose(vehicle):
    return np.array([*vehicle.position, vehicle.heading])


def pair(scene, curvature):
    """The truth of the second of two frames, and the poses of both."""
    _, ego, renderer = scene()
    renderer.render(ego, 0.0)
    before = pose(ego)
    advance(ego, curvature)
    renderer.render(ego, 1.0 / RATE_HZ)
    return renderer.truth(ALL), before, pose(ego)


@pytest.mark.parametrize("name", SCENES)
def test_ground_flow_is_the_reprojection_of_the_ground(name):
    truth, before, now = pair(*SCENES[name])
    camera = Camera()
    rows, columns = np.nonzero((truth["instance"] == 0) & np.isfinite(truth["depth"]) & (truth["depth"] < 60.0))
    pixels = np.stack([columns, rows], axis=1)[::97].astype(float)
    ground = ground_from_pixels(camera, pixels)
    earlier = vehicle_from_world(world_from_vehicle(ground, now), before)
    expected = pixels - project(camera, np.column_stack([earlier, np.zeros(len(earlier))]))
    got = truth["flow"][rows[::97], columns[::97]]
    assert np.abs(got - expected).max() < 1e-3
    assert np.allclose(truth["depth"][rows[::97], columns[::97]], ground[:, 0] - camera.forward_m, rtol=1e-5)


def test_sky_flow_is_pure_rotation():
    truth, before, now = pair(*SCENES["bend"])
    sky = truth["flow"][20, ::40]
    x = (np.arange(0, 640, 40) - 319.5) / 320.0
    before_x = np.tan(np.arctan(x) + (now[2] - before[2]))
    assert np.allclose(sky[:, 0], 320.0 * (x - before_x), atol=1e-3)
    straight, _, _ = pair(*SCENES["straight"])
    assert np.abs(straight["flow"][20]).max() < 1e-6
    assert np.isinf(straight["depth"][20]).all()
    assert np.isinf(straight["ttc"][20]).all()


def test_the_focus_of_expansion_is_where_the_flow_of_pure_translation_vanishes():
    road = straight_road()
    ego = add_ego(road, [20.0, 7.0])
    renderer = Renderer(road, Rig(Camera(), noise_sd=0.0), CLEAR, 1)
    renderer.render(ego, 0.0)
    ego.position = ego.position + np.array([0.09, 0.0045])  # a crab angle of 0.05 rad
    renderer.render(ego, 1.0 / RATE_HZ)
    truth = renderer.truth(ALL)
    assert truth["foe"] == pytest.approx([319.5 + 320.0 * 0.05, 239.5])
    rows, columns = np.nonzero(np.isfinite(truth["depth"]))
    away = np.stack([columns, rows], axis=1) - truth["foe"]
    flow = truth["flow"][rows, columns]
    assert np.abs(away[:, 0] * flow[:, 1] - away[:, 1] * flow[:, 0]).max() < 1e-2 * np.hypot(*away.T).max()
    # and the time to contact is the distance from the focus over the flow, one step ahead of the exact ratio
    moving = np.hypot(*flow.T) > 0.5
    ratio = np.hypot(*away[moving].T) / np.hypot(*flow[moving].T) / RATE_HZ
    ttc = truth["ttc"][rows, columns][moving]
    assert np.allclose(ratio - 1.0 / RATE_HZ, ttc, rtol=0.02)


def test_motionless_camera_has_no_foe_and_infinite_ttc():
    _, ego, renderer = straight_scene()
    renderer.render(ego, 0.0)
    renderer.render(ego, 1.0 / RATE_HZ)
    truth = renderer.truth(ALL)
    assert np.isnan(truth["foe"]).all()
    assert np.isinf(truth["ttc"]).all()
    assert np.abs(truth["flow"]).max() < 1e-9
    assert not truth["hidden"].any()


def test_instances_match_the_objects_and_their_distances():
    _, ego, renderer = straight_scene()
    renderer.render(ego, 0.0)
    truth = renderer.truth(("depth", "instance"))
    assert set(truth) == {"depth", "instance"}
    for index, obj in enumerate(renderer.objects):
        mine = truth["instance"] == index + 1
        assert mine.sum() > 200, obj.kind
        rear = obj.position[0] - 0.5 * obj.LENGTH - ego.position[0] - 0.8
        assert truth["depth"][mine].min() == pytest.approx(rear, abs=0.25)
        assert truth["depth"][mine].max() < rear + obj.LENGTH + 0.5
    assert (truth["instance"] == -1).any()


def test_object_at_constant_distance_has_no_flow_and_infinite_ttc():
    road, ego, renderer = straight_scene()
    leader = Vehicle(road, [32.0, 0.0], 0.0, SPEED_MPS)
    road.vehicles.append(leader)
    renderer.render(ego, 0.0)
    for vehicle in (ego, leader):
        vehicle.position = vehicle.position + np.array([0.09, 0.0])
    renderer.render(ego, 1.0 / RATE_HZ)
    truth = renderer.truth(ALL)
    mine = truth["instance"] == renderer.objects.index(leader) + 1
    assert mine.sum() > 200
    assert np.abs(truth["flow"][mine]).max() < 1e-4
    assert np.isinf(truth["ttc"][mine]).all()


def tracked(previous, picture, mask):
    """Corners within a mask, tracked to the previous frame and back."""
    corners = cv2.goodFeaturesToTrack(picture, 300, 0.01, 8, mask=mask.astype(np.uint8) * 255)
    options = {"winSize": (25, 25), "maxLevel": 2, "criteria": (3, 30, 0.03)}
    back, _, _ = cv2.calcOpticalFlowPyrLK(picture, previous, corners, None, **options)
    forth, _, _ = cv2.calcOpticalFlowPyrLK(previous, picture, back, None, **options)
    kept = np.hypot(*(forth - corners)[:, 0].T) < 0.5
    return corners[kept, 0], back[kept, 0]


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("surface", ["ground", "objects"])
def test_lucas_kanade_on_two_frames_agrees_with_the_truth(name, surface):
    scene, curvature = SCENES[name]
    errors = []
    for seed in (4, 11):
        _, ego, renderer = scene(seed)
        previous = None
        for k in range(13):
            picture = cv2.cvtColor(renderer.render(ego, k / RATE_HZ), cv2.COLOR_RGB2GRAY)
            if k % 4 == 0 and previous is not None:
                truth = renderer.truth(("depth", "flow", "instance"))
                if surface == "ground":
                    wanted = (truth["instance"] == 0) & (truth["depth"] > 5.0) & (truth["depth"] < 40.0)
                    # a window that sees two motions follows the stronger: keep them off what stands up
                    wanted &= cv2.dilate((truth["instance"] != 0).astype(np.uint8), np.ones((25, 25))) == 0
                else:
                    wanted = truth["instance"] > 0
                points, back = tracked(previous, picture, wanted)
                at = np.rint(points).astype(int)
                errors.append(np.hypot(*(points - back - truth["flow"][at[:, 1], at[:, 0]]).T))
            previous = picture
            advance(ego, curvature)
    everything = np.concatenate(errors)
    assert len(everything) > 150
    assert np.median(everything) < 0.15


@pytest.mark.parametrize("name", SCENES)
def test_lucas_kanade_chained_over_six_frames_agrees_with_the_truth(name):
    """Tracked from frame to frame, as in the planner; the truth is chained the same way."""
    scene, curvature = SCENES[name]
    _, ego, renderer = scene()
    pictures, flows = [], []
    for k in range(7):
        pictures.append(cv2.cvtColor(renderer.render(ego, k / RATE_HZ), cv2.COLOR_RGB2GRAY))
        truth = renderer.truth(("depth", "flow", "instance"))
        flows.append(truth["flow"])
        advance(ego, curvature)
    on_ground = (truth["instance"] == 0) & (truth["depth"] > 5.0) & (truth["depth"] < 40.0)
    on_ground &= cv2.dilate((truth["instance"] != 0).astype(np.uint8), np.ones((41, 41))) == 0
    for wanted in (on_ground, truth["instance"] > 0):
        points, _ = tracked(pictures[-2], pictures[-1], wanted)
        seen, true = points.copy(), points.copy()
        for k in range(6, 0, -1):
            options = {"winSize": (25, 25), "maxLevel": 2, "criteria": (3, 30, 0.03)}
            seen = cv2.calcOpticalFlowPyrLK(pictures[k], pictures[k - 1], seen[:, None], None, **options)[0][:, 0]
            at = np.clip(np.rint(true).astype(int), 0, [639, 479])
            true = true - flows[k][at[:, 1], at[:, 0]]
        errors = np.hypot(*(seen - true).T)
        assert len(errors) > 15
        assert np.median(errors) < 6 * 0.15
