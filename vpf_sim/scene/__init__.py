"""What a planner knows of the world at one moment: the road, the ego, and all that is on the road.

A camera's perception and the simulator's truth fill the same records (`truth.py` is the latter).
"""

from vpf_sim.scene.prediction import Prediction, predict
from vpf_sim.scene.road import Road
from vpf_sim.scene.scene import EgoState, Scene
from vpf_sim.scene.tracks import Tracks

__all__ = ["EgoState", "Prediction", "Road", "Scene", "Tracks", "predict"]
