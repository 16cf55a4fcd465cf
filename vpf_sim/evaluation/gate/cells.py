"""The cells (scenario, weather, driver) of a stored run, with the checked values of each planned episode."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import BaseModel, ConfigDict

from vpf_sim.errors import InputError
from vpf_sim.evaluation.gate.rules import Detail, Score
from vpf_sim.evaluation.sweeps.json_lines import read_lines
from vpf_sim.evaluation.sweeps.run_folder import read_manifest, stored_plan
from vpf_sim.evaluation.sweeps.schema import Numbers, Perception, checked

FAULTS = ("error", "invalid_frame")  # statuses of episodes that did not finish


class Cell(NamedTuple):
    scenario: str
    weather: str
    driver: str


class Comfort(BaseModel):
    comfortable: bool | None


class Episode(BaseModel):
    """The values of a record that rules check."""

    model_config = ConfigDict(frozen=True, strict=True, allow_inf_nan=False)

    id: str
    status: str
    collisions: int
    path_mse_m2: float | None
    min_clearance_m: float | None
    comfort: Comfort | None
    states_sha256: str | None
    path_mse_parts_m2: Numbers | None = None
    chattering: dict[str, Numbers] | None = None
    perception: Perception | None = None

    @property
    def succeeded(self) -> bool:
        return self.status == "success"


Episodes = Mapping[int, Episode | None]  # by seed, all planned ones; None without a record


@dataclass(frozen=True, slots=True)
class Run:
    """A run's episodes by cell, and the hashes of its scenarios and weathers."""

    path: Path
    cells: dict[Cell, Episodes]
    hashes: dict[str, Any]


def read_run(path: Path) -> Run:
    """The validated run in a folder."""
    if not path.is_dir():
        raise InputError(f"{path}: expected a run folder, got {'a file' if path.exists() else 'nothing of that name'}")
    manifest, jobs = read_manifest(path), stored_plan(path).jobs()
    hashes = {key: manifest[key] for key in ("scenarios", "weathers")}
    lines = path / "episodes.jsonl"
    episodes = (checked(Episode, row, f"{lines}: record {row.get('id')!r}") for row in read_lines(lines))
    found = {episode.id: episode for episode in episodes}
    cells: dict[Cell, dict[int, Episode | None]] = {}
    for job in jobs:
        cells.setdefault(Cell(job.scenario, job.weather, job.driver), {})[job.seed] = found.get(job.id)
    return Run(path, dict(sorted(cells.items())), hashes)


def value_of(score: Score | Detail, episode: Episode | None) -> float | None:
    """An episode's value in the mean of a score.

    A missing or unfinished episode counts as unsuccessful, uncomfortable, and a collision. All other scores are None
    for unsuccessful episodes, and where they were not measured, such as a clearance without obstacles.
    """
    if score == "collisions":
        return 1.0 if episode is None or episode.status in FAULTS else float(episode.collisions)
    succeeded = episode is not None and episode.succeeded
    if score == "success_rate":
        return float(succeeded)
    if score == "comfortable_share":
        return float(succeeded and episode is not None and bool(episode.comfort and episode.comfort.comfortable))
    if episode is None or not succeeded:
        return None
    return _measured(episode)[score]


def _measured(episode: Episode) -> dict[str, float | None]:
    """The scores that only successful episodes have; None where nothing was met, or the driver shows no perception."""
    chattering, perception = episode.chattering or {}, episode.perception or Perception()
    objects = perception.objects or {}
    return {
        "path_mse_m2": episode.path_mse_m2,
        "clearance_m": episode.min_clearance_m,
        "clear_path_mse_m2": (episode.path_mse_parts_m2 or {}).get("clear_of_obstacles"),
        "steering_rate_radps": chattering.get("steering_rate_radps", {}).get("p95"),
        "steering_reversals_per_s": chattering.get("steering", {}).get("direction_changes_per_s"),
        "edge_error_m": (perception.edge_error_10m_m or {}).get("median"),
        "foe_error_px": (perception.foe_median_error_px or {}).get("distance"),
        "recall": objects.get("recall"),
        "precision": objects.get("precision"),
        "false_positives_per_minute": objects.get("wrong_per_minute"),
    }


def values_of(score: Score | Detail, episodes: Episodes) -> dict[int, float]:
    """Values by seed of the episodes that count in a score."""
    values = {seed: value_of(score, episode) for seed, episode in episodes.items()}
    return {seed: value for seed, value in values.items() if value is not None}


def worst_first(losses: Mapping[int, float]) -> list[int]:
    """Seeds sorted by loss, largest first."""
    return sorted(losses, key=lambda seed: (-losses[seed], seed))
