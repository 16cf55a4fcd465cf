"""The camera's pose, and the poses of all objects, at one frame."""

from typing import Protocol

import numpy as np
from highway_env.vehicle.objects import RoadObject

from vpf_sim.envs.camera.view import View
from vpf_sim.types import Camera, Floats


class Carrier(Protocol):
    """The highway-env vehicle that carries the camera."""

    position: Floats  # (2,) m
    heading: float  # rad


class Snapshot:
    """View and object poses at one frame; the view and the dictionary of poses are made when first asked for."""

    __slots__ = ("_camera", "_poses", "_view", "objects", "places", "pose", "time_s")

    def __init__(self, view: View, time_s: float, objects: list[RoadObject], poses: dict[RoadObject, Floats]) -> None:
        self._camera = view.camera
        self._view: View | None = view
        self._poses: dict[RoadObject, Floats] | None = poses
        self.time_s = time_s
        self.objects = objects  # without the camera's vehicle
        self.places = np.array([poses[obj] for obj in objects]).reshape(-1, 3)
        forward = view.camera.forward_m * np.array([np.cos(view.yaw_rad), np.sin(view.yaw_rad)])
        x, y = (view.centre[:2] - forward).tolist()
        self.pose = (x, y, view.yaw_rad)  # of the camera's vehicle: x, y in m, heading in rad

    @classmethod
    def of(cls, camera: Camera, ego: Carrier, time_s: float, objects: list[RoadObject]) -> "Snapshot":
        """The snapshot of a camera on `ego` and of objects at their present poses."""
        made = cls.__new__(cls)
        made._camera, made._view, made._poses = camera, None, None
        made.time_s, made.objects = time_s, objects
        x, y = ego.position.tolist()
        made.pose = (x, y, float(ego.heading))
        places = [(*obj.position.tolist(), obj.heading) for obj in objects]
        made.places = np.array(places, np.float64) if places else np.empty((0, 3))
        return made

    @property
    def view(self) -> View:
        """The camera at its pose."""
        if self._view is None:
            x, y, yaw = self.pose
            self._view = View.at(self._camera, np.array((x, y)), yaw)
        return self._view

    @property
    def poses(self) -> dict[RoadObject, Floats]:
        """(3,) x, y in m and heading in rad, by object."""
        if self._poses is None:
            self._poses = dict(zip(self.objects, self.places, strict=True))
        return self._poses
