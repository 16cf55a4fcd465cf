"""Settings of the paper's time to contact and obstacle map."""

from typing import Literal

from vpf_sim.configuration import setting, settings

Shape = Literal["full_frame", "below_horizon", "road_corridor", "horizon_corridor"]


@settings
class ContactConfig:
    method: Literal["as_printed", "robust"] = setting("Method that finds the time to contact.")
    floor_px: float = setting("Least motion of a point that counts.", gt=0.0)
    cap_s: float = setting("Longest finite time to contact.", gt=0.0)
    least_points: int = setting("Least number of points of a cluster with a time to contact of its own.", ge=1)


@settings
class RegionConfig:
    """Region of interest A of the obstacle force."""

    shape: Shape = setting(
        "Shape of the region: `road_corridor`, between the road's edges, or `horizon_corridor`, also within `reach_m`."
    )
    margin_m: float = setting("Margin of the region inside the edges.")
    near_m: float = setting("Least depth of the region, from the camera.", gt=0.0)
    reach_m: float = setting("Largest depth of the region.", gt=0.0)
    height_m: tuple[float, float] = setting("Least and largest height of the region above the road.")

    def __post_init__(self) -> None:
        if not self.near_m < self.reach_m:
            raise ValueError(f"near_m: expected < reach_m = {self.reach_m}, got {self.near_m}")
        if not self.height_m[0] < self.height_m[1]:
            raise ValueError(f"height_m: expected the lower limit first, got {list(self.height_m)}")


@settings
class ObstacleMapConfig:
    method: Literal["otsu_flow", "otsu_residual", "absolute"] = setting(
        "Method: `otsu_flow`, as printed; `otsu_residual`, the dominant plane of the cited source; `absolute`, robust."
    )
    reduction: int = setting("Factor by which the image is reduced.", ge=1)
    disc_px: float = setting("Radius of the disc that a point marks.", gt=0.0)
    normalisation: Literal["as_printed", "proper"] = setting("Normalisation of the Gaussian.")
    noise_px: float = setting("Standard deviation of a displacement.", ge=0.0)
    ratio: float = setting("Share of the road's flow that the residual must exceed as well.", ge=0.0)
    min_points: int = setting("Marked points that a cluster needs.", ge=1)
    weight: Literal["none", "ttc"] = setting("Weight of a point: 1, or 1 - TTC / `horizon_s`.")
    horizon_s: float = setting("Time to contact at which the weight of a point is 0.", gt=0.0)
    sigma_px: float | None = setting(
        "Standard deviation of the Gaussian in the full image; none: no gradient.", default=None, gt=0.0
    )
    region: RegionConfig | None = setting("Keeps the points of a region; none: those of the full frame.", default=None)

    @property
    def needs_surroundings(self) -> bool:
        """Whether the road, the speed or the points' time to contact change the map."""
        return self.weight != "none" or (self.region is not None and self.region.shape != "full_frame")
