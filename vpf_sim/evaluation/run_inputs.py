"""The scenario and weather files of a run: it keeps their content, so that it can be opened from any folder."""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from vpf_sim.errors import InputError
from vpf_sim.evaluation.score_keys import Json

if TYPE_CHECKING:
    from vpf_sim.configuration import TomlTable
    from vpf_sim.envs.camera.weather import Weather
    from vpf_sim.scenarios import AnyScenario

INPUTS = "inputs.json"  # in a run folder


def contents(scenario: Iterable[str], weathers: Iterable[str]) -> dict[str, Json]:
    """What the scenario and weather files of a run say, by their names; those of the package are left out."""
    from vpf_sim import scenarios
    from vpf_sim.envs.camera import weather

    own = {"scenarios": {*scenario} - {*scenarios.names()}, "weathers": {*weathers} - {*weather.names()}}
    return {
        "scenarios": {name: scenarios.as_table(scenarios.load(name)) for name in sorted(own["scenarios"])},
        "weathers": {name: weather.load(name).model_dump(mode="json") for name in sorted(own["weathers"])},
    }


@dataclass(frozen=True, slots=True)
class RunInputs:
    """What a stored run was driven with, wherever it is opened."""

    folder: Path | None = None  # the run's; none: names are looked up from the working folder
    made_in: Path | None = None  # the working folder of the run; none for one of an earlier version

    @classmethod
    def of(cls, folder: Path, made_in: str | None) -> "RunInputs":
        """The inputs of the run in a folder; `made_in` is its manifest's."""
        return cls(folder, None if made_in is None else Path(made_in))

    def scenario(self, name: str) -> "AnyScenario":
        """The scenario of this name, as the run read it."""
        from vpf_sim import scenarios

        kept = self._kept("scenarios", name)
        return scenarios.load(name) if kept is None else scenarios.of_table(kept, f"{self._file}: {name}")

    def weather(self, name: str) -> "Weather":
        """The weather of this name, as the run read it."""
        from vpf_sim import configuration
        from vpf_sim.envs.camera import weather

        kept = self._kept("weathers", name)
        return (
            weather.load(name) if kept is None else configuration.build(weather.Weather, kept, f"{self._file}: {name}")
        )

    def driver(self, name: str) -> str:
        """The driver's name, whose file is looked up from here, then from where the run was made."""
        from vpf_sim import drivers

        for prefix in (drivers.VARIANT_PREFIX, drivers.MODEL_PREFIX):
            file = name.removeprefix(prefix)
            if file != name and self.made_in and not Path(file).exists() and (self.made_in / file).is_file():
                return f"{prefix}{self.made_in / file}"
        return name

    @property
    def place(self) -> str:
        """Where the run was made, as the end of a message; empty if that is here or unknown."""
        elsewhere = self.made_in is not None and self.made_in != Path.cwd()
        return f"; the run was made in {self.made_in}" if elsewhere else ""

    def check_here(self, what: str, driver_names: Iterable[str]) -> None:
        """InputError where a file or driver of the run, which `what` needs, is not found from the working folder."""
        from vpf_sim import drivers

        for name in (name for kind in ("scenarios", "weathers") for name in self._all().get(kind, ())):
            if not Path(name).exists():
                raise InputError(f"{self.folder}: {what}: expected the file {name}, got none of that name{self.place}")
        for name in driver_names:
            try:
                drivers.create(name)
            except InputError as error:
                raise InputError(f"{self.folder}: {what}: {error}{self.place}") from None

    @property
    def _file(self) -> Path:
        return (self.folder or Path()) / INPUTS

    def _kept(self, kind: str, name: str) -> "TomlTable | None":
        table = self._all().get(kind, {})
        if not isinstance(table, dict) or not isinstance(kept := table.get(name), dict | None):
            raise InputError(f"{self._file}: {kind}: {name}: expected a table, got something else")
        return kept

    def _all(self) -> "TomlTable":
        if self.folder is None or not self._file.exists():
            return {}
        try:
            stored = json.loads(self._file.read_text("utf-8"))
        except (OSError, ValueError, RecursionError):
            stored = None
        if not isinstance(stored, dict):
            raise InputError(f"{self._file}: expected a JSON object, got something else")
        return stored
