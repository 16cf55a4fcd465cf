"""Tracker of the carriageway's edges by painted lines and the verges, without a map."""

from dataclasses import dataclass

import numpy as np

from vpf_sim.geometry import rotation, wrap_angle
from vpf_sim.perception.road.birds_eye import BirdsEye
from vpf_sim.perception.road.hypotheses import CarriagewayHypotheses
from vpf_sim.perception.road.line_matcher import BY_ANY, BY_LINES, LineMatcher, Match
from vpf_sim.perception.road.markings import RidgeMap, RoadFeatures, comb
from vpf_sim.perception.road.model import PITCH, WIDTH, curvature_ahead, state_of
from vpf_sim.perception.road.road_settings import RefutationConfig, RoadEdgeConfig, VergeConfig
from vpf_sim.perception.road.state_filter import LaneFilter
from vpf_sim.perception.schedule import Schedule
from vpf_sim.types import Camera, Floats, Image, Obstacles, RoadEdges


@dataclass(slots=True)
class Absence:
    """Whether what is expected has not been seen for long enough."""

    config: RefutationConfig
    frames: int = 0  # since it was last seen
    agreed_m: float = 0.0  # travelled until then

    def add(self, agrees: bool, travelled_m: float) -> None:
        """A frame in which it is seen where expected, or not."""
        self.frames = 0 if agrees else self.frames + 1
        self.agreed_m = travelled_m if agrees else self.agreed_m

    def holds(self, travelled_m: float) -> bool:
        return self.frames >= self.config.frames and travelled_m > self.agreed_m + self.config.way_m


class RoadEdgeTracker:
    """Tracks the carriageway: corrected by the image every `update_period_s`, predicted by the own motion in between.

    `road.hypotheses` decides which of the lines are the edges. Lines 0 and 1 are those of the lane in which the road
    was found.
    """

    def __init__(
        self, camera: Camera, config: RoadEdgeConfig, rate_hz: float, verges: VergeConfig | None = None
    ) -> None:
        self.camera = camera
        self.config = config
        self.matcher = LineMatcher(camera, config, verges)
        self._colour_view = BirdsEye(camera, config.colour_patch)
        self._update = Schedule(config.update_period_s, rate_hz)
        self._judgement = Schedule(config.index_period_s, self._update.rate_hz)  # among the updates
        self._search = Schedule(config.search_period_s, rate_hz)
        self._road: LaneFilter | None = None
        self._is_lost = True  # the road is predicted by the own motion alone
        self._index = CarriagewayHypotheses.start(config.lanes, config.likely_lane, config.hypotheses)
        self._pose: Floats | None = None
        self._travelled_m, self._judged_m = 0.0, 0.0  # m, now and at the last judgement
        self._frame = -1
        self._refuted, self._unpainted = Absence(config.refutation), Absence(config.refutation)
        self._pitch_rad: float | None = None  # of the camera against the road, at the last correction
        self._pitch_frame = -1  # of that correction

    def update(
        self,
        image_rgb: Image,
        grey: Image,
        pose: Floats,
        speed_mps: float,
        yaw_rate_radps: float,
        obstacles: Obstacles | None,
    ) -> RoadEdges:
        """The carriageway at the frame taken at `pose`; the obstacles of the last frame hide lines."""
        self._frame += 1
        self._predict(pose)
        update, search = self._update.step(), self._search.step()
        judge = update and self._judgement.step()
        search = search and (self._is_lost or self._unpainted.holds(self._travelled_m))
        if search or (update and not self._is_lost):
            features = self.matcher.features(image_rgb, grey, obstacles, self._pitch_rad or 0.0)
            is_found = search and self._find(image_rgb, features)
            if self._road is not None and not is_found and not self._is_lost and update:
                has_moved = self._travelled_m >= self._judged_m + self.config.new_road_m
                if self._correct(self._road, features, judge) and judge and has_moved:
                    self._judge(self._road, image_rgb, features.ridges)
        return self._report(speed_mps, yaw_rate_radps)

    def predicted(self, pose: Floats, speed_mps: float, yaw_rate_radps: float) -> RoadEdges:
        """The carriageway at `pose` by the own motion alone, without a frame."""
        self._predict(pose)
        return self._report(speed_mps, yaw_rate_radps)

    @property
    def pitch(self) -> tuple[float, float] | None:
        """rad, pitch of the camera against the road (+ down), and its standard deviation; None without clear lines."""
        if self._road is None or self._pitch_rad is None or self._frame != self._pitch_frame:
            return None
        if self._is_lost or self._lane_confidence(self._road) < self.config.least_certain:
            return None
        return self._pitch_rad, self._road.pitch_sigma_rad

    def turn(self, down_rad: float) -> None:
        """Add a change of the camera's pitch since the last frame."""
        if self._pitch_rad is not None:
            self._pitch_rad += down_rad
        if self._road is not None:
            self._road.state[PITCH] += down_rad

    def _predict(self, pose: Floats) -> None:
        if self._road is not None and self._pose is not None:
            step = (pose[:2] - self._pose[:2]) @ rotation(self._pose[2])
            self._travelled_m += float(np.hypot(*step))
            self._road.predict(np.array([*step, wrap_angle(float(pose[2] - self._pose[2]))]))
        self._pose = pose

    def _correct(self, tracked: LaneFilter, features: RoadFeatures, judge: bool) -> bool:
        """Correct the state by lines and verges about their predicted places; the road may be lost.

        Whether its lines are seen: where only verges are, the lines cannot be distinguished.
        """
        match = self.matcher.correct(tracked, features, self._index.numbers)
        corrected = match in BY_ANY
        if judge and corrected:
            self.matcher.update_verges(tracked, features)
        if match is not Match.LITTLE:
            self._refuted.add(corrected, self._travelled_m)
        if corrected:
            self._unpainted.add(match is Match.LINES, self._travelled_m)
        is_refuted = self._refuted.holds(self._travelled_m)
        if is_refuted or not self.matcher.is_sane(tracked.state) or tracked.sigma_m > self.config.lost_sigma_m:
            self._is_lost = True
            return False
        if corrected:
            self._pitch_rad, self._pitch_frame = float(tracked.state[PITCH]), self._frame
        return match is Match.LINES

    def _find(self, image_rgb: Image, features: RoadFeatures) -> bool:
        """Track the road that explains most ridges: about the known road, or in any lane where none is known.

        Whether one was found. Verges show where a lost road leads, but not the place of its lines: that takes paint.
        """
        config, known = self.config, self._road if self._is_known(self._road) else None
        if known is not None and abs(known.state[1]) > config.comb.headings_rad[-1]:
            known = None
        if known is None and not self._is_lost:
            return False
        widths = config.widths_m if known is None or not config.keeps_width else known.state[[WIDTH]]
        found = comb(
            features.ridges,
            widths,
            config.lane_width_m if known is None or config.keeps_width else float(known.state[WIDTH]),
            config.comb,
            0.0 if known is None else float(known.state[1]),
            unlikely_per_m=config.unlikely_per_m,
            steps=features.steps,
            beside_m=0.0 if self.matcher.verges is None else self.matcher.verges.config.beside_m,
        )
        if known is None:
            self._index = CarriagewayHypotheses.start(config.lanes, config.likely_lane, config.hypotheses)
        road = None
        if found.painted >= config.least_comb:
            place = found.y % found.width
            if known is not None:
                place = found.y + found.width * round((known.state[0] - found.y) / found.width)
            guess = state_of(place, found.heading, found.curvature, found.width)
            road = self.settled(guess, features, config.first_guess.sigma_m, BY_LINES)
        is_led = features.steps is not None and self._is_lost and found.score >= config.least_comb
        if road is None and is_led and known is not None and known.sigma_m < config.lost_sigma_m:
            guess = state_of(float(known.state[0]), found.heading, found.curvature, float(known.state[WIDTH]))
            road = self.settled(guess, features, max(known.sigma_m, config.first_guess.sigma_m), BY_ANY)
        if road is not None:
            self._follow(road)
            self._judge(road, image_rgb, features.ridges)
        elif self._is_lost:
            self._road = known
        return road is not None

    def settled(
        self, guess: Floats, features: RoadFeatures, sigma_m: float, accepted: frozenset[Match]
    ) -> LaneFilter | None:
        """The road about a first guess; None where not what is accepted shows it, or turns a known road.

        An unknown road may turn: some bends are tighter than any guess.
        """
        first, check = self.config.first_guess, self.config.guess_check
        pitch_sigma_rad = first.mounted_rad if self._pitch_rad is None else first.pitched_rad
        guess[PITCH] = self._pitch_rad or 0.0
        found, match = self.matcher.settle(guess, features, self._index.numbers, sigma_m, pitch_sigma_rad)
        if match not in accepted:
            return None
        if abs(found.state[1] - guess[1]) <= check.turned_rad:
            return found
        return None if self._is_known(self._road) else found

    def _follow(self, found: LaneFilter) -> None:
        """Track a road that was found in this frame."""
        self._road, self._is_lost = found, False
        for absence in self._refuted, self._unpainted:
            absence.add(True, self._travelled_m)
        self._pitch_rad, self._pitch_frame = float(found.state[PITCH]), self._frame

    def _is_known(self, road: LaneFilter | None) -> bool:
        """Whether the place on a road is certain enough to tell one lane from the next."""
        if road is None or not self.matcher.is_sane(road.state, self.config.facing_rad):
            return False
        return bool(road.sigma_m < self.config.lost_share * road.state[WIDTH])

    def _judge(self, tracked: LaneFilter, image_rgb: Image, ridges: RidgeMap) -> None:
        self._judged_m = self._travelled_m
        colour = self._colour_view.warp(image_rgb)
        verges = [] if self.matcher.verges is None else self.matcher.verges.clear(tracked)
        self._index.judge(tracked.state, ridges, colour, self._colour_view, verges)

    def _report(self, speed_mps: float, yaw_rate_radps: float) -> RoadEdges:
        """The state as edges, with the curvature that is exact at `report_ahead_m`."""
        tracked = self._road
        if tracked is None or not self._is_known(tracked):
            return self._likely(float(np.clip(yaw_rate_radps / max(speed_mps, 1.0), -0.05, 0.05)))
        state = tracked.state
        place, width = float(state[0]), float(state[WIDTH])
        left, right = self._index.edges
        bend = curvature_ahead(state, self.config.report_ahead_m)
        likely = self._index.of_these_edges(state)
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
            oncoming_m=self._index.oncoming * width,
        )

    def _lane_confidence(self, tracked: LaneFilter) -> float:
        """0 .. 1, by the visible share of lines or verges and the standard deviation; 0 of a lost road."""
        if self._is_lost:
            return 0.0
        least = self.config.least_agreement
        visible = max(self._index.agreement or 0.0, *tracked.verges.values(), 0.0)
        visible = (visible - least) / (1.0 - 2.0 * least)
        return min(max(visible, 0.0), 1.0) * float(np.exp(-tracked.sigma_m / self.config.confidence_sigma_m))

    def _likely(self, curvature_per_m: float) -> RoadEdges:
        """The middle of the likely lane, before any line is visible."""
        width = self.config.lane_width_m
        right = (self.config.likely_lane - 0.5) * width
        return RoadEdges(right - self.config.lanes * width, right, 0.0, curvature_per_m, width, 0.0, 0.0, width)
