"""The edges of the carriageway, from the camera: painted lines found, fitted and followed; no map."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from vpf_sim.geometry import rotation, wrap_angle
from vpf_sim.perception.road.birds_eye import BirdsEye, Patch, ridge
from vpf_sim.perception.road.hypotheses import CarriagewayHypotheses
from vpf_sim.perception.road.markings import (
    CENTROID_M,
    HEADINGS_RAD,
    UNLIKELY_PER_M,
    RidgeMap,
    comb,
    noise_threshold,
    sight,
    sighting_variance,
)
from vpf_sim.perception.road.model import PITCH, WIDTH, curvature_ahead, rows_seen, state_of
from vpf_sim.perception.road.occlusion import OcclusionConfig
from vpf_sim.perception.road.relocalisation import outdoes, rival_of
from vpf_sim.perception.road.state_filter import (
    NEAR_M,
    REACH_M,
    TURNED_RAD,
    Expected,
    LaneFilter,
    Sightings,
    initial_covariance,
    is_sane,
)
from vpf_sim.types import Bools, Camera, Floats, Image, Obstacles, RoadEdges

RIDGE_REACH_M = 0.25
AHEAD_M = 10.0
BODY_MARGIN_M = 0.3
COVER = OcclusionConfig()  # how long what hides the lines may be
NEAREST_BODY_M = 0.5  # before the camera: what ends nearer hides nothing of the patch
LEAST_AGREEMENT = 0.3  # share of the expected lines without which the road is no more than a guess
LEAST_CERTAIN = 0.5  # of the lines, without which they do not tell where the camera looks
NEW_ROAD_M = 0.8  # that comes into view between two judgements: who stands sees the same again, errors and all
REFUTED_LOOKS, REFUTED_M = 10, 2.0  # in a row, on so much way, that show other lines: the road is another one
LOST_SHARE = 0.35  # of a lane's width: a lost road whose place is less sure is looked for from nothing
FACING_RAD = 1.5  # to a road: whoever is turned farther goes nowhere along it. A way out turns by 80 deg and swings
TURN_M = 20.0  # of way, in which a vehicle has turned across the road and back
FIRST_SIGMA_M, FIRST_SIGMA_RAD, FIRST_WIDTH_SIGMA_M, FIRST_LOOKS = 0.3, 0.04, 0.07, 3
SURE_AGREEMENT, STRAIGHT_RAD = 0.85, 0.15  # of lines seen, and heading: up to these a followed road may have rivals
SETTLES_RAD = 0.075  # about a first guess: roads do so within .05, what is none turns by .1 to .4
RIVAL_SEARCHES = 2  # in a row, that a road must have a rival to be left for it
MOUNTED_RAD = 0.006  # how far off a camera looks, usually, in pitch, before a road has been followed,
PITCHED_RAD = 0.0015  # and where one has been
NARROWEST_LANE_M, WIDTH_STEP_M = 2.75, 0.125  # looked for,
WIDER_M = 0.25  # and by how much wider than looked for a lane may turn out to be


@dataclass(frozen=True, slots=True)
class RoadEdgeConfig:
    """What is likely of the road beforehand (how many lanes, how wide) and how it is looked for."""

    lanes: int = 4  # solid lines at both edges, dashed lines within; taken where an edge is not seen
    lane_width_m: float = 3.5  # taken where a single line is seen
    likely_lane: int = 2  # from the right, taken while nothing is seen
    near_m: float = 3.0  # the patch of road looked at, from the pose
    far_m: float = 30.0
    half_width_m: float = 9.75
    row_m: float = 0.3
    column_m: float = 0.05
    update_period_s: float = 0.05  # between looks at the picture
    index_period_s: float = 0.2  # between judgements of which lane this is
    search_period_s: float = 0.5  # between searches from scratch
    least_contrast: float = 4.0  # grey levels by which a line stands out
    sigma_m: float = 0.02  # of one sighting, plus
    sigma_px: float = 0.2
    least_rows: int = 12  # sightings without which a look counts for nothing
    least_comb: float = 0.2  # of a road found from scratch: a line in a fifth of the rows
    lost_sigma_m: float = 0.8
    widest_lane_m: float = 4.25  # looked for
    unlikely_per_m: float = UNLIKELY_PER_M  # lines that a lane a metre off `lane_width_m` must explain more
    keeps_width: bool = True  # a road that was lost has lanes as wide as before

    def __post_init__(self) -> None:
        if self.lanes < 1 or self.lane_width_m <= 1.0:
            raise ValueError(f"lanes, lane_width_m: expected >= 1 and > 1, got {self.lanes}, {self.lane_width_m}")
        if not 1 <= self.likely_lane <= self.lanes:
            raise ValueError(f"likely_lane: expected 1 .. {self.lanes}, got {self.likely_lane}")
        if self.near_m >= self.far_m:
            raise ValueError(f"near_m: expected < far_m = {self.far_m}, got {self.near_m}")

        if self.widest_lane_m < NARROWEST_LANE_M:
            raise ValueError(f"widest_lane_m: expected >= {NARROWEST_LANE_M}, got {self.widest_lane_m}")

    @property
    def widths_m(self) -> Floats:
        """Of a lane, looked for."""
        return np.arange(NARROWEST_LANE_M, self.widest_lane_m + 0.01, WIDTH_STEP_M)

    @property
    def patch(self) -> Patch:
        return Patch(self.near_m, self.far_m, self.half_width_m, self.row_m, self.column_m)


class RoadEdgeTracker:
    """Follows the carriageway from frame to frame; looks at the picture every `update_period_s`, predicts in between.

    Bird's-eye patch, ridges, search about the predicted lines, robust least squares with the prediction as prior. Which
    of the lines are the edges comes from their kinds and the ground beside them (`road.hypotheses`). Lines 0 and 1 are
    those of the lane in which the road was found.
    """

    def __init__(self, camera: Camera, config: RoadEdgeConfig, rate_hz: float) -> None:
        self.camera = camera
        self.config = config
        self.view = BirdsEye(camera, config.patch)
        self._colour_view = BirdsEye(camera, Patch(config.near_m, config.far_m, config.half_width_m + 2.0, 0.6, 0.5))
        look = max(1, round(config.update_period_s * rate_hz))
        judge = look * max(1, round(config.index_period_s / config.update_period_s))
        self._periods = (look, judge, max(1, round(config.search_period_s * rate_hz)))
        margin = 2 * round((RIDGE_REACH_M + CENTROID_M) / config.column_m) + 1
        self._visible = cv2.erode(self.view.visible.astype(np.uint8), np.ones((1, margin), np.uint8)) > 0
        self._variance = sighting_variance(camera, self.view.forward_m, config.sigma_m, config.sigma_px)
        self._filter: LaneFilter | None = None
        self._lost: LaneFilter | None = None  # what was followed last, carried on by the own motion alone
        self._index = CarriagewayHypotheses.start(config.lanes, config.likely_lane)
        self._pose: Floats | None = None
        self._travelled_m, self._judged_m = 0.0, 0.0  # by the own motion; by the last judgement
        self._refuted, self._agreed_m = 0, 0.0  # looks since lines were last where they should be, and the way then
        self._outdone = 0  # searches in a row that found a road which explains more
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
        look, judge, search = (self._frame % period == 0 for period in self._periods)
        if self._filter is None and search:
            self._find(image_rgb, self._ridges(grey, obstacles))
        elif self._filter is not None and look:
            ridges = self._ridges(grey, obstacles)
            if self._look(self._filter, ridges) and judge and self._travelled_m >= self._judged_m + NEW_ROAD_M:
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
        if self._lane_confidence(self._filter) < LEAST_CERTAIN:
            return None
        return self._pitch_rad, self._filter.pitch_sigma_rad

    @property
    def _followed(self) -> LaneFilter | None:
        """The road that is followed, or was last."""
        return self._filter or self._lost

    def turn(self, down_rad: float) -> None:
        """The camera has come to look so much farther down since the last frame."""
        if self._pitch_rad is not None:
            self._pitch_rad += down_rad
        for followed in (self._filter, self._lost):
            if followed is not None:
                followed.turn(down_rad)

    def _predict(self, pose: Floats) -> None:
        followed = self._followed
        if followed is not None and self._pose is not None:
            step = (pose[:2] - self._pose[:2]) @ rotation(self._pose[2])
            self._travelled_m += float(np.hypot(*step))
            followed.predict(np.array([*step, wrap_angle(float(pose[2] - self._pose[2]))]))
        self._pose = pose

    def _ridges(self, grey: Image, obstacles: Obstacles | None) -> RidgeMap:
        response = ridge(self.view.warp(grey), round(RIDGE_REACH_M / self.config.column_m))
        visible = self._visible & ~self._hidden(obstacles)
        return RidgeMap(response, noise_threshold(response, self.config.least_contrast), visible)

    def _hidden(self, obstacles: Obstacles | None) -> Bools:
        """(rows, columns) behind bodies, their flanks and all, as the camera sees them."""
        hidden = np.zeros(self.view.visible.shape, np.bool_)
        if obstacles is None or not len(obstacles):
            return hidden
        seen_m, _ = rows_seen(self._pitch_rad or 0.0, self.view.forward_m, self.camera)
        ahead = (self.view.forward_m - self.camera.forward_m)[:, None]
        bearing = self.view.right_m / ahead
        sides = zip(obstacles.forward_m, obstacles.left_m, obstacles.right_m, strict=True)
        for (face, left, right), length in zip(sides, COVER.lengths_m(obstacles.width_m), strict=True):
            depth = float(face) - self.camera.forward_m
            beside = left > 0.0 or right < 0.0
            if depth + beside * length < NEAREST_BODY_M:  # behind, where a mover that was passed is still predicted
                continue
            rows = seen_m > face - BODY_MARGIN_M
            # Where sight of a place passes the face, and the far end of the flank that is turned to us.
            at_face = bearing[rows] * max(depth, NEAREST_BODY_M)
            at_end = bearing[rows] * np.minimum(ahead[rows], depth + length)
            left_of = (at_end if left > 0.0 else at_face) > left - BODY_MARGIN_M
            hidden[rows] |= left_of & ((at_end if right < 0.0 else at_face) < right + BODY_MARGIN_M)
        return hidden

    def _look(self, tracked: LaneFilter, ridges: RidgeMap) -> bool:
        """Correct the state by the lines seen about their predicted places; whether there were enough."""
        served = self._take_in(tracked, ridges)
        if served is not None:
            self._refuted = 0 if served else self._refuted + 1
            self._agreed_m = self._travelled_m if served else self._agreed_m
        refuted = self._refuted >= REFUTED_LOOKS and self._travelled_m > self._agreed_m + REFUTED_M
        if refuted or not self._is_sane(tracked.state) or tracked.sigma_m > self.config.lost_sigma_m:
            self._refuted = 0
            self._filter, self._lost = None, tracked
            return False
        if served:
            self._pitch_rad, self._pitch_frame = float(tracked.state[PITCH]), self._frame
        return bool(served)

    def _take_in(self, tracked: LaneFilter, ridges: RidgeMap) -> bool | None:
        """Whether the lines seen about their predicted places served to correct the state; None: too few were seen."""
        numbers = self._index.numbers
        expected = tracked.expected(numbers, self.view.forward_m)
        found = sight(ridges, self.view, expected.right_m, expected.reached, numbers, REACH_M, self._variance)
        if np.count_nonzero(found.seen) < self.config.least_rows:
            return None
        return self._correct(tracked, found, expected)

    def _correct(self, tracked: LaneFilter, found: Sightings, expected: Expected) -> bool:
        """Take in a look, or its near part where far mirror images or drops were taken for lines; whether it served."""
        known = (tracked.state, tracked.covariance)
        for reach_m in (np.inf, NEAR_M):
            near = replace(found, seen=found.seen & (found.forward_m < reach_m))
            tracked.correct(near, expected)
            if self._is_sane(tracked.state) and tracked.agrees(near):
                return True
            tracked.state, tracked.covariance = known
        return False

    def _find(self, image_rgb: Image, ridges: RidgeMap) -> None:
        """The road that explains most ridges: in the lane where the own motion has led since it was lost, or, from
        nothing, in whichever lane the pose is."""
        config, lost = self.config, self._lost if self._is_known(self._lost) else None
        if lost is not None and abs(lost.state[1]) > HEADINGS_RAD[-1]:
            if self._travelled_m < self._agreed_m + TURN_M:
                self._find_again(lost, ridges)
                return
            lost = None  # a turn ends: it was wrong about the road
        widths = config.widths_m if lost is None or not config.keeps_width else lost.state[[WIDTH]]
        likely_m = config.lane_width_m if lost is None or config.keeps_width else float(lost.state[WIDTH])
        likely_rad = 0.0 if lost is None else float(lost.state[1])
        score, (y, heading, curvature, width) = comb(
            ridges, self.view, widths, likely_m, likely_rad, unlikely_per_m=config.unlikely_per_m
        )
        if score < config.least_comb:
            return
        place = y % width if lost is None else y + width * round((lost.state[0] - y) / width)
        if lost is None:
            self._index = CarriagewayHypotheses.start(config.lanes, config.likely_lane)
        guess = state_of(place, heading, curvature, width)
        guess[PITCH] = self._pitch_rad or 0.0
        found = self._settled(guess, ridges)
        if found is None:
            self._lost = lost
            return
        self._follow(found)
        self._judge(found, image_rgb, ridges)

    def _compare(self, tracked: LaneFilter, ridges: RidgeMap) -> None:
        """Go over to a road that explains more of the ridges than the one that is followed, and goes on to."""
        state, sure = tracked.state, (self._index.agreement or 0.0) > SURE_AGREEMENT
        picture = (ridges, self.view, self._index.numbers)
        rival = None if sure or abs(state[1]) > STRAIGHT_RAD else rival_of(state, *picture, self.config.least_comb)
        self._outdone = 0 if rival is None else self._outdone + 1
        if rival is None or self._outdone < RIVAL_SEARCHES:
            return
        self._outdone = 0
        settled = self._settled(rival, ridges)
        if settled is not None and outdoes(settled.state, state, *picture):
            self._follow(settled)

    def _settled(self, state: Floats, ridges: RidgeMap) -> LaneFilter | None:
        """The road about a first guess, as a few looks at the same frame tell it; None where its lines are not seen.

        Nor where a road is known, and they lead away from the guess: from line to grain to mirror image. From nothing
        that is how bends are found that are tighter than any guess.
        """
        found = LaneFilter(state, np.empty(0), self.camera)
        pitch_sigma_rad = MOUNTED_RAD if self._pitch_rad is None else PITCHED_RAD
        for _ in range(FIRST_LOOKS):
            found.covariance = initial_covariance(FIRST_SIGMA_M, FIRST_SIGMA_RAD, FIRST_WIDTH_SIGMA_M, pitch_sigma_rad)
            if not self._take_in(found, ridges):
                return None
        leads_away = abs(found.state[1] - state[1]) > SETTLES_RAD
        return None if leads_away and self._is_known(self._followed) else found

    def _follow(self, found: LaneFilter) -> None:
        """Go on with a road that was found in this frame."""
        self._filter, self._lost = found, None
        self._refuted, self._agreed_m = 0, self._travelled_m
        self._pitch_rad, self._pitch_frame = float(found.state[PITCH]), self._frame

    def _find_again(self, lost: LaneFilter, ridges: RidgeMap) -> None:
        """The road that was lost, where it should be; other lines than its own lead where such a vehicle is headed."""
        if self._is_sane(lost.state) and self._look(lost, ridges):
            self._filter, self._lost = lost, None

    def _is_known(self, state: LaneFilter | None) -> bool:
        """Whether a road that was lost may still tell one lane from the next, however far the vehicle has turned."""
        if state is None or not self._is_sane(state.state, FACING_RAD):
            return False
        return bool(state.sigma_m < LOST_SHARE * state.state[WIDTH])

    def _is_sane(self, state: Floats, turned_rad: float = TURNED_RAD) -> bool:
        return is_sane(state, turned_rad, self.config.widest_lane_m + WIDER_M)

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
        bend = curvature_ahead(state, AHEAD_M)
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
        lines_seen = ((self._index.agreement or 0.0) - LEAST_AGREEMENT) / (1.0 - 2.0 * LEAST_AGREEMENT)
        return min(max(lines_seen, 0.0), 1.0) * float(np.exp(-tracked.sigma_m / 0.3))

    def _likely(self, curvature_per_m: float) -> RoadEdges:
        """The middle of the likely lane, while no line has been seen."""
        width = self.config.lane_width_m
        right = (self.config.likely_lane - 0.5) * width
        return RoadEdges(right - self.config.lanes * width, right, 0.0, curvature_per_m, width, 0.0, 0.0, width)
