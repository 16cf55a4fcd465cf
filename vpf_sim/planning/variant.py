"""A variant of the method: the configuration of every stage, read from a TOML file in variants/, or from a user's own.

A file may say with `base` which variant it starts from, and then only what it changes; one's own starts from `robust`
if it does not. A section given as the name of a variant, `flow = "robust"`, is that variant's.
"""

from functools import cache
from importlib.resources import files
from pathlib import Path

from vpf_sim import configuration
from vpf_sim.configuration import TomlTable, setting, settings
from vpf_sim.configuration_fields import keys, sections
from vpf_sim.errors import InputError, unknown_name
from vpf_sim.perception.egomotion.egomotion_settings import ExpansionConfig, FlowConfig, OdometryConfig, PitchConfig
from vpf_sim.perception.frame_gate import FrameGateConfig
from vpf_sim.perception.obstacles.crossing import CrossingConfig
from vpf_sim.perception.obstacles.moving.moving_obstacle_settings import MovingObstacleConfig
from vpf_sim.perception.obstacles.static_obstacle_settings import StaticObstacleConfig
from vpf_sim.perception.paper.paper_settings import ContactConfig, ObstacleMapConfig
from vpf_sim.perception.plausible import PlausibilityConfig
from vpf_sim.perception.road.road_settings import RoadEdgeConfig, VergeConfig
from vpf_sim.planning.paper.planner import PaperPlannerConfig
from vpf_sim.planning.visibility import VisibilityConfig
from vpf_sim.scene.scene_settings import SceneConfig

PACKAGE = "vpf_sim.planning.variants"
BASE = "robust"


@settings
class FrameConfig:
    """What is done about frames that are late or missing."""

    remembered_s: float = setting("Time for which the car's own motion is kept, for frames that arrive late.", gt=0.0)
    longest_gap_s: float = setting("Longest time between two frames over which points are followed.", gt=0.0)
    blind_s: float = setting("Time without a new frame after which the car brakes to a stop.", gt=0.0)
    latest_share: float = setting("Largest delay that the flow allows for, as a share of a period.", ge=0.0, le=1.0)


@settings
class Variant:
    """One section for each stage; the planner is `paper_planner` or `scene`."""

    gains: str = setting("Set [gtsmc.NAME] of controllers/gains.toml that the controller uses.")
    frames: FrameConfig = setting("What is done about late and missing frames.")
    frame_gate: FrameGateConfig = setting("Which frames are left out, as they show nothing new or nothing true.")
    plausibility: PlausibilityConfig = setting("Which sensor values count as impossible.")
    flow: FlowConfig = setting("Sparse optical flow.")
    focus_of_expansion: ExpansionConfig = setting("Focus of expansion.")
    time_to_contact: ContactConfig = setting("Time to contact.")
    obstacle_map: ObstacleMapConfig = setting("Obstacle map.")
    road_edges: RoadEdgeConfig = setting("Edges and lanes of the road.")
    odometry: OdometryConfig | None = setting("Odometry by speed and yaw rate, in place of a rough pose.", default=None)
    camera_pitch: PitchConfig | None = setting(
        "Estimate of pitch and mounting, which is taken out of flow and frames.", default=None
    )
    static_obstacles: StaticObstacleConfig | None = setting("Static obstacle tracker.", default=None)
    moving_obstacles: MovingObstacleConfig | None = setting("Moving-object tracker.", default=None)
    verges: VergeConfig | None = setting("Tracks where the road's surface ends, beside its lines.", default=None)
    crossing: CrossingConfig | None = setting("Actors that cross.", default=None)
    scene: SceneConfig | None = setting(
        "Tracks of all that is on the road, in which the scene planner plans.", default=None
    )
    paper_planner: PaperPlannerConfig | None = setting("The paper's potential fields.", default=None)
    visibility: VisibilityConfig | None = setting("Speed where little is seen.", default=None)

    def __post_init__(self) -> None:
        if (self.paper_planner is None) == (self.scene is None):
            raise ValueError("expected exactly one of [paper_planner] and [scene]")
        for key in "scene", "moving_obstacles", "crossing":
            if getattr(self, key) is not None and self.static_obstacles is None:
                raise ValueError(f"[{key}] needs [static_obstacles]")
        if self.scene is not None and self.visibility is None:
            raise ValueError("[scene] needs [visibility]")
        if self.verges is not None:
            half_m = self.road_edges.half_width_m + self.road_edges.verge_m
            for key, share in ("beside_m", 0.9), ("surface_m", 0.2), ("column_m", 0.1), ("on_verge_m", 0.2):
                if (got := getattr(self.verges, key)) > share * half_m:
                    expected = f"at most {share * half_m:g}, {share:g} of half the patch's width"
                    raise ValueError(f"verges.{key}: expected {expected}, got {got:g}")


SECTIONS = [key for key, hint in keys(Variant).items() if sections(hint)]


def names() -> list[str]:
    """The variants there are."""
    return sorted(item.name.removesuffix(".toml") for item in files(PACKAGE).iterdir() if item.name.endswith(".toml"))


def load(name: str) -> Variant:
    """The variant of that name, or of that TOML file."""
    if not name.endswith(".toml"):
        return configuration.build(Variant, _table(name), f"{name}.toml")
    own = {"base": BASE, **configuration.read_file(Path(name), "variant")}
    return configuration.build(Variant, _whole(own, name), name, also=("base",))


@cache
def _table(name: str) -> TomlTable:
    """The whole table of a variant, read once: it must not be changed."""
    if name in names():
        return _whole(configuration.read(PACKAGE, f"{name}.toml"), f"{name}.toml")
    raise unknown_name("variant", name, names())


def _whole(own: TomlTable, file: str) -> TomlTable:
    """A file's table laid over its base, with the sections that it takes from other variants."""
    named = {key: name for key, name in own.items() if key in SECTIONS and isinstance(name, str) and name != "none"}
    below = _of_variant(own["base"], file, "base") if "base" in own else {}
    rest = {key: value for key, value in own.items() if key != "base" and key not in named}
    return {**configuration.laid_over(below, rest), **{key: _section(key, name, file) for key, name in named.items()}}


def _section(key: str, name: str, file: str) -> TomlTable:
    """A section of the variant `name`."""
    found: TomlTable | None = _of_variant(name, file, key).get(key)
    if found is None:
        raise InputError(f"{file}: {key}: expected a variant with [{key}], got '{name}'")
    return found


def _of_variant(name: object, file: str, key: str) -> TomlTable:
    if not isinstance(name, str) or name.endswith(".toml"):
        raise InputError(f"{file}: {key}: expected the name of a variant, got {name!r}")
    try:
        return _table(name)
    except InputError as error:
        raise InputError(f"{file}: {key}: {error}") from None
