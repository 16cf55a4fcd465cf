"""A variant of the method: the configuration of every stage, read from one TOML file in variants/."""

from dataclasses import dataclass
from importlib.resources import files

from vpf_sim import tables
from vpf_sim.errors import unknown_name
from vpf_sim.perception.contact import ContactConfig
from vpf_sim.perception.expansion import ExpansionConfig
from vpf_sim.perception.flow import FlowConfig
from vpf_sim.perception.landmarks import LandmarkConfig
from vpf_sim.perception.movers import MoverConfig
from vpf_sim.perception.obstacles import ObstacleMapConfig
from vpf_sim.perception.road_edges import RoadEdgeConfig
from vpf_sim.planning.gradient_line import GradientLineConfig
from vpf_sim.planning.valley import ValleyConfig

PACKAGE = "vpf_sim.planning.variants"


@dataclass(frozen=True, slots=True)
class Variant:
    """One section a stage. The way through the field is the paper's `gradient_line` or the `valley`, never both."""

    flow: FlowConfig
    expansion: ExpansionConfig
    contact: ContactConfig
    obstacle_map: ObstacleMapConfig
    road_edges: RoadEdgeConfig
    landmarks: LandmarkConfig | None = None  # without it, no bodies: only the obstacle map
    movers: MoverConfig | None = None  # without it, all bodies stand
    gradient_line: GradientLineConfig | None = None
    valley: ValleyConfig | None = None

    def __post_init__(self) -> None:
        if (self.gradient_line is None) == (self.valley is None):
            raise ValueError("expected exactly one of [gradient_line] and [valley]")
        if self.valley is not None and self.landmarks is None:
            raise ValueError("[valley] needs [landmarks]: it goes by the bodies on the road")
        if self.movers is not None and self.landmarks is None:
            raise ValueError("[movers] needs [landmarks]: it sees what these cannot be")


def names() -> list[str]:
    """The variants there are."""
    return sorted(item.name.removesuffix(".toml") for item in files(PACKAGE).iterdir() if item.name.endswith(".toml"))


def load(name: str) -> Variant:
    """The variant of that name."""
    if name not in names():
        raise unknown_name("variant", name, names())
    return tables.build(Variant, tables.read(PACKAGE, f"{name}.toml"), f"{name}.toml")
