"""Settings of optical flow, focus of expansion, camera pitch and odometry."""

from typing import Literal

from vpf_sim.configuration import setting, settings


@settings
class NoiseModel:
    """Noise of a track: the window's follows the structure tensor, chaining adds to it frame by frame."""

    grey_levels: float = setting("Standard deviation of a pixel's noise, in grey levels.", default=5.0, ge=0.0)
    floor_px: float = setting("Noise of a track that texture cannot reduce.", default=0.1, ge=0.0)
    growth_s: float = setting("Time in which the variance of a track grows by its initial value.", default=0.17, gt=0.0)
    anisotropy: float = setting(
        "Share of a structure tensor's large eigenvalue that adds to its small one.", default=0.04, ge=0.0
    )
    pitch_rad: float = setting("Standard deviation of the camera's pitch.", default=0.0005, ge=0.0)


@settings
class Band:
    """A strip of the image with its own share of the corners, so that one strong edge does not starve the far road."""

    top: float = setting("Tangent of the angle below the horizon of the band's upper end.")
    bottom: float = setting("Tangent of the angle below the horizon of the band's lower end.")
    share: float = setting("Share of all points in the band.", gt=0.0, le=1.0)


@settings
class CornerTestConfig:
    texture_floor: float = setting("Least small eigenvalue of the structure tensor, grey levels^2 / px^2.", ge=0.0)
    corner_ratio: float = setting("Least ratio of the small to the large eigenvalue.", ge=0.0, lt=1.0)


@settings
class WiperConfig:
    hold_s: float = setting("Longest time for which an occluded point is predicted and searched for.", gt=0.0)
    swept_share: float = setting("Share of the points that must jump in one frame.", gt=0.0, lt=1.0)
    swept_least: int = setting("Least number of points that must jump in one frame.", ge=1)
    covered_levels: float = setting("Mean difference of the window from which a point is occluded.", gt=0.0)
    covered_ratio: float = setting(
        "Difference of the window from which a point counts as occluded, as a multiple of the median difference.",
        gt=1.0,
    )


@settings
class WindscreenPointConfig:
    still_px: float = setting("Largest motion of a windscreen point over its life; `still_share` adds to it.", gt=0.0)
    still_share: float = setting(
        "Share of the scene's motion that adds to the largest motion of a windscreen point.", ge=0.0
    )
    least_px: float = setting("Least motion of the scene for a decision.", gt=0.0)
    loose_px: float = setting("Motion in a window that frees a point.", gt=0.0)


@settings
class SettledPointConfig:
    kept_share: float = setting("Share of a band that old points may fill.", gt=0.0, le=1.0)
    age_windows: int = setting("Age of an old point in windows.", ge=1)
    residual_px: float = setting(
        "Largest residual of a settled point to the road's flow; `residual_share` adds to it.", ge=0.0
    )
    residual_share: float = setting(
        "Share of the road's flow that adds to the largest residual of a settled point.", ge=0.0
    )


@settings
class FlowConfig:
    """How corners are detected and tracked."""

    period_s: float = setting("Time between two tracked frames; the frames between are predicted by odometry.", ge=0.0)
    window_px: int = setting("Side of the Lucas-Kanade window, an odd number.", ge=3)
    epsilon_px: float = setting("Step at which Lucas-Kanade stops.", gt=0.0)
    window_s: float = setting("Time over which the points of frames are chained.", gt=0.0)
    points: int = setting("Largest number of tracked points.", ge=8)
    quality: float = setting("Least Shi-Tomasi response as a share of the best.", gt=0.0, lt=1.0)
    min_distance_px: float = setting("Least distance between two points.", gt=0.0)
    detect_period_s: float = setting("Time between two searches of a band for corners.", gt=0.0)
    reach_px_per_s: float = setting("Fastest motion that is tracked.", gt=0.0)
    windscreen_points: WindscreenPointConfig = setting("Marks drops and dirt on the windscreen.")
    settled_points: SettledPointConfig = setting("Drops old points of the flat road for new ones.")
    max_level: int | None = setting("Pyramid levels; none: as many as `reach_px_per_s` needs.", default=None, ge=0)
    forward_backward_px: float | None = setting(
        "Largest distance of a point after tracking it back.", default=None, gt=0.0
    )
    from_road: bool = setting("Begins the search where a point of the road would be now.", default=False)
    keyframe_s: float | None = setting("Age at which a first observation is renewed.", default=None, gt=0.0)
    bands: tuple[Band, ...] | None = setting(
        "Bands of the image that share the points; none: one band.", default=None, min_length=1
    )
    corner_test: CornerTestConfig | None = setting("Drops points where Lucas-Kanade slides.", default=None)
    wiper: WiperConfig | None = setting(
        "Predicts points that a wiper occludes, and searches for them afterwards.", default=None
    )

    def __post_init__(self) -> None:
        if self.window_px % 2 == 0:
            raise ValueError(f"window_px: expected an odd number, got {self.window_px}")
        if self.period_s > self.window_s:
            raise ValueError(f"period_s: expected <= window_s = {self.window_s}, got {self.period_s}")


@settings
class DirectionPriorConfig:
    side_sd_rad: float = setting("Standard deviation of the direction of motion to the side.", gt=0.0)
    height_sd_rad: float = setting("Standard deviation of the direction of motion up or down.", gt=0.0)


@settings
class TemporalPriorConfig:
    drift_sd_rad: float = setting("Change of the direction of motion in a second, as a random walk.", gt=0.0)
    accepted_share: float = setting("Share of the votes from which RANSAC is not needed.", gt=0.5, lt=1.0)


@settings
class RotationFitConfig:
    tilt_sd_radps: float = setting("Standard deviation of the pitch rate and the roll rate.", ge=0.0)
    yaw_sd_radps: float = setting("Standard deviation of the yaw rate's error.", ge=0.0)


@settings
class RansacConfig:
    hypotheses: int = setting("Number of pairs of flow lines that are tried.", ge=1)
    finalists: int = setting("Number of hypotheses that all sampled points vote on.", ge=1)
    sample: int = setting("Number of points that vote.", ge=4)
    prior_share: float = setting("Largest share of the votes that the prior can outweigh.", ge=0.0, le=1.0)


@settings
class FocusFitConfig:
    """Robust fit of the focus of expansion to derotated flow."""

    tolerance_px: float = setting(
        "Error of one step between frames across the radial direction; `tolerance_ratio` adds to it.", gt=0.0
    )
    tolerance_ratio: float = setting(
        "Share of the step's length that adds to its error; over n steps it grows with sqrt(n).", gt=0.0
    )
    min_flow_px: float = setting("Least motion of a point that votes.", gt=0.0)
    least_points: int = setting("Least number of voting points.", ge=2)
    sharp_rad: float = setting("Standard deviation of the direction that halves the confidence.", gt=0.0)
    temporal_prior: TemporalPriorConfig = setting("Takes the focus of the frame before as a prior.")
    rotation: RotationFitConfig = setting("Fits the rates of rotation that are not measured.")
    ransac: RansacConfig = setting("Finds the fit's start by RANSAC.")
    direction_prior: DirectionPriorConfig | None = setting(
        "Assumes that the vehicle moves nearly straight ahead.", default=None
    )


@settings
class ExpansionConfig:
    method: Literal["as_printed", "least_squares", "robust"] = setting("Method that finds the focus of expansion.")
    fit: FocusFitConfig | None = setting("Settings of the method `robust`, which needs them.", default=None)

    def __post_init__(self) -> None:
        if self.method == "robust" and self.fit is None:
            raise ValueError("fit: expected a section for the method 'robust', got none")


@settings
class MountPitchConfig:
    """Noise of the observations of the mount pitch, and when its estimate is applied."""

    first_sd_rad: float = setting("Standard deviation of the mount pitch before any observation.", gt=0.0)
    look_sd_rad: float = setting(
        "Noise of an observation in addition to its own, since consecutive ones are correlated.", gt=0.0
    )
    drift_sd_rad: float = setting("Change of the mount pitch in a second, as a random walk.", gt=0.0)
    least_rad: float = setting(
        "Least mount pitch that is applied; an applied one is kept down to half of this.", gt=0.0
    )
    step_rad: float = setting("Least change of the mount pitch that is applied.", gt=0.0)


@settings
class PitchSidesConfig:
    apart_rad: float = setting(
        "Largest difference in pitch between the left and the right half of the image; `apart_share` adds to it.",
        ge=0.0,
    )
    apart_share: float = setting(
        "Share of the pitch that adds to the largest difference between the two halves.", ge=0.0
    )


@settings
class DynamicPitchConfig:
    settle_s: float = setting("Time constant of the high-pass that removes the drift of the sum.", gt=0.0)
    smoothness: float = setting("Weight of a constant pitch rate within the window.", ge=0.0, lt=1.0)
    least_rad: float = setting(
        "Root mean square from which the pitch is compensated, until it falls below half of this.", gt=0.0
    )
    least_points: int = setting("Least number of points for an estimate.", ge=1)
    sides: PitchSidesConfig = setting("Takes the smaller pitch of two image halves that disagree.")


@settings
class PitchConfig:
    dynamic: DynamicPitchConfig = setting("Compensates the pitching on the springs by the flow.")
    mounting: MountPitchConfig = setting("Compensates the mount pitch by the road's lines.")


@settings
class OdometryCalibrationConfig:
    walk_m: float = setting("Random walk of the pose's position in a second.", gt=0.0)
    walk_rad: float = setting("Random walk of the pose's heading in a second.", gt=0.0)
    scale_sd: float = setting("Standard deviation of the speedometer's scale.", gt=0.0)
    bias_sd_radps: float = setting("Standard deviation of the yaw rate's bias.", gt=0.0)
    drift_share: float = setting(
        "Random walk of scale and bias in a second, as a share of their standard deviations.", gt=0.0
    )


@settings
class OdometryConfig:
    rough_m: float = setting("Random walk of the position in a second from which the pose is replaced.", gt=0.0)
    rough_rad: float = setting("Random walk of the heading in a second from which the pose is replaced.", gt=0.0)
    settle_s: float = setting("Time constant of the averages of position and heading.", gt=0.0)
    watched_s: float = setting("Time from the start before which the pose is not judged.", gt=0.0)
    standstill_mps: float = setting("Speed below which the vehicle is at standstill.", gt=0.0)
    calibration: OdometryCalibrationConfig = setting("Fits the speed's scale and the yaw rate's bias.")
