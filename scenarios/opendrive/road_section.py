"""The section `[road]` of a scenario file that takes its road from an OpenDRIVE map."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from vpf_sim.configuration import settings
from vpf_sim.scenarios.parts import RoadAppearance, Section

Direction = Literal["forward", "backward"]


class OpenDriveRoad(Section):
    """The road of a map, in place of segments, lanes, their width, start and heading."""

    opendrive: str = Field(description="Map file, relative to the file of the scenario.")
    route: Annotated[tuple[str, ...], Field(strict=False)] = Field(
        default=(), description="Ids of connected roads, those of junctions too."
    )
    start: str | None = Field(default=None, alias="from", description="Id of the first road, in place of `route`.")
    to: str | None = Field(default=None, description="Id of the last road; the route has the fewest roads.")
    direction: Direction | None = Field(
        default=None,
        description="Direction on the first road, along or against its s; by default the one that the route allows.",
    )
    look: RoadAppearance = Field(
        default=RoadAppearance(), description="Appearance of the road; it overrides what the map says of its markings."
    )

    @model_validator(mode="after")
    def _has_one_route(self) -> Self:
        if self.route and (self.start or self.to):
            raise ValueError("route: expected either route or from and to, got both")
        if not self.route and (self.start is None or self.to is None):
            raise ValueError("route: expected the ids of one or more roads, or from and to, got none")
        return self


@settings
class OpenDriveFile:
    """What a scenario file with a map has and others have not."""

    road: OpenDriveRoad
