"""Settings of the scene by camera. Existence is in log-odds: 0 is as likely as not."""

from vpf_sim.configuration import setting, settings


@settings
class TrackerConfig:
    """Motion of tracks, and how long they last."""

    along_mps2: float = setting("Standard deviation of accelerations along the road.", gt=0.0)
    across_mps2: float = setting("Standard deviation of accelerations across it.", gt=0.0)
    standing_share: float = setting("Share of them for tracks that stand.", gt=0.0, le=1.0)
    unseen_s: float = setting("Time after which a track without detections is pruned.", gt=0.0)
    most: float = setting("Largest existence.", gt=0.0)
    most_standing: float = setting("Largest existence of what stands, so that evidence against it soon counts.", gt=0.0)
    unsure: float = setting("First existence of what stands and is not confirmed.", lt=0.0)


@settings
class ExistenceConfig:
    """What detections add to a track's existence, and what their lack takes from it."""

    look_m: float = setting("Way after which a detection is independent of the last.", gt=0.0)
    look_s: float = setting("Time after which it is.", gt=0.0)
    confirmed: float = setting("Existence that a confirmed obstacle adds.", gt=0.0)
    born_m: float = setting("Distance within which a new static obstacle should have been seen before.", ge=0.0)
    near: float = setting("Existence that it adds there where no points judge it.", ge=0.0)
    crossing: float = setting("Existence that an actor found in one frame adds.", gt=0.0)
    standing_per_s: float = setting("Loss of a standing track that is not detected in sight.", ge=0.0)
    moving_per_s: float = setting("Loss of a track that drives.", ge=0.0)
    crossing_per_s: float = setting("Loss of an actor that crosses.", ge=0.0)
    obstacle_points: float = setting("Points above the road that a frame shows of an obstacle.", gt=0.0)
    paint_points: float = setting("Points above the road that a frame shows of paint, by mistake.", gt=0.0)
    points_share: float = setting("Share of their log-likelihood that counts, since points stay.", gt=0.0, le=1.0)
    points_most: float = setting("Largest existence that the points of a frame add.", gt=0.0)
    flat: float = setting("Relief below which an obstacle lies in the plane of the road.", lt=0.0)
    per_relief: float = setting("Existence for each unit of that relief.", ge=0.0)

    def __post_init__(self) -> None:
        if not self.paint_points < self.obstacle_points:
            raise ValueError(
                f"paint_points: expected < obstacle_points = {self.obstacle_points}, got {self.paint_points}"
            )


@settings
class UnseenConfig:
    """Traffic beside the car and behind it, which the camera does not see."""

    remembered_s: float = setting("Time for which traffic that was seen counts.", gt=0.0)
    slower_share: float = setting("Share of the traffic's speed below which the car is overtaken.", gt=0.0)
    patience_s: float = setting("Time of standing after which the car no longer waits.", ge=0.0)


@settings
class SceneConfig:
    tracker: TrackerConfig = setting("Motion of tracks, and how long they last.")
    existence: ExistenceConfig = setting("What detections add to a track's existence.")
    unseen: UnseenConfig = setting("Traffic that the camera does not see.")
