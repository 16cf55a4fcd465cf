"""The edges of the carriageway, from the camera: painted lines found, fitted and followed; no map."""

import numpy as np

from vpf_sim.geometry import rotation, wrap_angle
from vpf_sim.perception.road.birds_eye import BirdsEye
from vpf_sim.perception.road.config import RoadEdgeConfig
from vpf_sim.perception.road.hypotheses import CarriagewayHypotheses
from vpf_sim.perception.road.line_matcher import LineMatcher
from vpf_sim.perception.road.markings import RidgeMap, comb
from vpf_sim.perception.road.model import PITCH, WIDTH, curvature_ahead, state_of
from vpf_sim.perception.road.relocalisation import Relocalisation
from vpf_sim.perception.road.state_filter import LaneFilter
from vpf_sim.perception.schedule import Schedule
from vpf_sim.types import Camera, Floats, Image, Obstacles, RoadEdges


class RoadEdgeTracker:
    """Follows the carriageway from frame to frame; looks at the picture every `update_period_s`, predicts in between.

    Bird's-eye patch, ridges, search about the predicted lines, robust least squares with the prediction as prior. Which
    of the lines are the edges comes from their kinds and the ground beside them (`road.hypotheses`). Lines 0 and 1 are
    those of the lane in which the road was found.
    """

    def __init__(self, camera: Camera, config: RoadEdgeConfig, rate_hz: float) -> None:
        self.camera = camera
        self.config = config
        self.matcher = LineMatcher(camera, config)
        self.view = self.matcher.view
        self._colour_view = BirdsEye(camera, config.verge_patch)
        self._relocalisation = Relocalisation(config.relocalisation, config) if config.relocalisation else None
        self._update = Schedule(config.update_period_s, rate_hz)
        self._judgement = Schedule(config.index_period_s, self._update.rate_hz)  # among the updates
        self._search = Schedule(config.search_period_s, rate_hz)
        self._filter: LaneFilter | None = None
        self._lost: LaneFilter | None = None  # what was followed last, carried on by the own motion alone
        self._index = CarriagewayHypotheses.start(config.lanes, config.likely_lane, config.hypotheses)
        self._pose: Floats | None = None
        self._travelled_m, self._judged_m = 0.0, 0.0  # by the own motion; by the last judgement
        self._refuted, self._agreed_m = 0, 0.0  # looks since lines were last where they should be, and the way then
        self._frame = -1
        self._pitch_rad: float | None = None  # of the camera against the road, as last seen,
        self._pitch_frame = -1  # and when

    def update(
        self,
        image_rgb: Image,
        grey: Image,
        pose: Floats,
        speed_mps: float,
        yaw_rate_radps: float,
        obstacles: Obstacles | None,
    ) -> RoadEdges:
        """The carriageway at the frame taken at `pose`; `obstacles` are those known before, they hide lines."""
        self._frame += 1
        self._predict(pose)
        look, search = self._update.step(), self._search.step()
        judge = look and self._judgement.step()
        if self._filter is None and search:
            self._find(image_rgb, self.matcher.ridges(grey, obstacles, self._pitch_rad or 0.0))
        elif self._filter is not None and look:
            ridges = self.matcher.ridges(grey, obstacles, self._pitch_rad or 0.0)
            if (
                self._look(self._filter, ridges)
                and judge
                and self._travelled_m >= self._judged_m + self.config.new_road_m
            ):
                self._judge(self._filter, image_rgb, ridges)
            if self._filter is not None and search:
                self._compare(self._filter, ridges)
        return self._report(speed_mps, yaw_rate_radps)

    def carried(self, pose: Floats, speed_mps: float, yaw_rate_radps: float) -> RoadEdges:
        """The carriageway at `pose`, by the own motion alone: of a frame that is not looked at."""
        self._predict(pose)
        return self._report(speed_mps, yaw_rate_radps)

    @property
    def pitch(self) -> tuple[float, float] | None:
        """rad that the camera looks farther down, against the road, than it should, and the standard deviation.

        None while the road's lines do not tell: what is taken for lines on a road without them says anything.
        """
        if self._filter is None or self._pitch_rad is None or self._frame != self._pitch_frame:
            return None
        if self._lane_confidence(self._filter) < self.config.least_certain:
            return None
        return self._pitch_rad, self._filter.pitch_sigma_rad

    @property
    def _followed(self) -> LaneFilter | None:
        """The road that is followed, or was last."""
        return self._filter or self._lost

    def _predict(self, pose: Floats) -> None:
        followed = self._followed
        if followed is not None and self._pose is not None:
            step = (pose[:2] - self._pose[:2]) @ rotation(self._pose[2])
            self._travelled_m += float(np.hypot(*step))
            followed.predict(np.array([*step, wrap_angle(float(pose[2] - self._pose[2]))]))
        self._pose = pose

    def _look(self, tracked: LaneFilter, ridges: RidgeMap) -> bool:
        """Correct the state by the lines seen about their predicted places; whether there were enough."""
        served = self.matcher.correct(tracked, ridges, self._index.numbers)
        if served is not None:
            self._refuted = 0 if served else self._refuted + 1
            self._agreed_m = self._travelled_m if served else self._agreed_m
        if self._is_refuted or not self.matcher.is_sane(tracked.state) or tracked.sigma_m > self.config.lost_sigma_m:
            self._refuted = 0
            self._filter, self._lost = None, tracked
            return False
        if served:
            self._pitch_rad, self._pitch_frame = float(tracked.state[PITCH]), self._frame
        return bool(served)

    @property
    def _is_refuted(self) -> bool:
        """Whether other lines than the expected ones have been visible for long enough."""
        config = self.config.refutation
        if config is None:
            return False
        return self._refuted >= config.frames and self._travelled_m > self._agreed_m + config.way_m

    def _find(self, image_rgb: Image, ridges: RidgeMap) -> None:
        """The road that explains most ridges: in the lane where the own motion has led since it was lost, or, from
        nothing, in whichever lane the pose is."""
        config, lost = self.config, self._lost if self._is_known(self._lost) else None
        if lost is not None and abs(lost.state[1]) > config.comb.headings_rad[-1]:
            turn = config.turn_recovery
            if turn is not None and self._travelled_m < self._agreed_m + turn.way_m:
                self._find_again(lost, ridges)
                return
            lost = None  # a turn ends: it was wrong about the road
        widths = config.widths_m if lost is None or not config.keeps_width else lost.state[[WIDTH]]
        likely_m = config.lane_width_m if lost is None or config.keeps_width else float(lost.state[WIDTH])
        likely_rad = 0.0 if lost is None else float(lost.state[1])
        score, (y, heading, curvature, width) = comb(
            ridges, self.view, widths, likely_m, config.comb, likely_rad, unlikely_per_m=config.unlikely_per_m
        )
        if score < config.least_comb:
            return
        place = y % width if lost is None else y + width * round((lost.state[0] - y) / width)
        if lost is None:
            self._index = CarriagewayHypotheses.start(config.lanes, config.likely_lane, config.hypotheses)
        guess = state_of(place, heading, curvature, width)
        guess[PITCH] = self._pitch_rad or 0.0
        found = self.settled(guess, ridges)
        if found is None:
            self._lost = lost
            return
        self._follow(found)
        self._judge(found, image_rgb, ridges)

    def _compare(self, tracked: LaneFilter, ridges: RidgeMap) -> None:
        """Replace the tracked road by another one that explains more of the ridges."""
        if self._relocalisation is None:
            return
        picture = (ridges, self.view, self._index.numbers)
        rival = self._relocalisation.search(tracked.state, self._index.agreement or 0.0, *picture)
        settled = None if rival is None else self.settled(rival, ridges)
        if settled is not None and self._relocalisation.outdoes(settled.state, tracked.state, *picture):
            self._follow(settled)

    def settled(self, guess: Floats, ridges: RidgeMap) -> LaneFilter | None:
        """The road about a first guess; None without visible lines or where they lead away from the guess.

        Without a known road they may lead away: so bends are found that are tighter than any guess.
        """
        first, check = self.config.first_guess, self.config.guess_check
        pitch_sigma_rad = first.mounted_rad if self._pitch_rad is None else first.pitched_rad
        found = self.matcher.settle(guess, ridges, self._index.numbers, pitch_sigma_rad)
        if found is None or check is None or abs(found.state[1] - guess[1]) <= check.turned_rad:
            return found
        return None if self._is_known(self._followed) else found

    def _follow(self, found: LaneFilter) -> None:
        """Go on with a road that was found in this frame."""
        self._filter, self._lost = found, None
        self._refuted, self._agreed_m = 0, self._travelled_m
        self._pitch_rad, self._pitch_frame = float(found.state[PITCH]), self._frame

    def _find_again(self, lost: LaneFilter, ridges: RidgeMap) -> None:
        """The road that was lost, where it should be; other lines than its own lead where such a vehicle is headed."""
        if self.matcher.is_sane(lost.state) and self._look(lost, ridges):
            self._filter, self._lost = lost, None

    def _is_known(self, state: LaneFilter | None) -> bool:
        """Whether a road that was lost may still tell one lane from the next, however far the vehicle has turned."""
        if state is None or not self.matcher.is_sane(state.state, self.config.facing_rad):
            return False
        return bool(state.sigma_m < self.config.lost_share * state.state[WIDTH])

    def _judge(self, tracked: LaneFilter, image_rgb: Image, ridges: RidgeMap) -> None:
        self._judged_m = self._travelled_m
        colour = self._colour_view.warp(image_rgb)
        self._index.judge(tracked.state, self._travelled_m, ridges, self.view, colour, self._colour_view)

    def _report(self, speed_mps: float, yaw_rate_radps: float) -> RoadEdges:
        """The state as edges; its one curvature is the one that puts the road 10 m ahead where the state has it."""
        tracked = self._followed
        if tracked is None or not self._is_known(tracked):
            return self._likely(float(np.clip(yaw_rate_radps / max(speed_mps, 1.0), -0.05, 0.05)))
        state = tracked.state
        place, width = float(state[0]), float(state[WIDTH])
        left, right = self._index.edges
        bend = curvature_ahead(state, self.config.report_ahead_m)
        likely = self._index.probabilities(state)[self._index.believed]
        lane_certain = self._lane_confidence(tracked)
        return RoadEdges(
            left_m=left * width - place,
            right_m=right * width - place,
            heading_rad=float(state[1]),
            curvature_per_m=bend / (1.0 - bend * place),
            sigma_m=tracked.sigma_m,
            confidence=float(likely) * lane_certain,
            lane_m=0.5 * width - place,
            lane_width_m=width,
            lane_confidence=lane_certain,
        )

    def _lane_confidence(self, tracked: LaneFilter) -> float:
        """By how many of the expected lines are seen, lately, and how well the place is known; 0 of a lost road."""
        if self._filter is None:
            return 0.0
        least = self.config.least_agreement
        lines_seen = ((self._index.agreement or 0.0) - least) / (1.0 - 2.0 * least)
        return min(max(lines_seen, 0.0), 1.0) * float(np.exp(-tracked.sigma_m / self.config.confidence_sigma_m))

    def _likely(self, curvature_per_m: float) -> RoadEdges:
        """The middle of the likely lane, while no line has been seen."""
        width = self.config.lane_width_m
        right = (self.config.likely_lane - 0.5) * width
        return RoadEdges(right - self.config.lanes * width, right, 0.0, curvature_per_m, width, 0.0, 0.0, width)
