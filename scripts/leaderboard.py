"""Write the leaderboard's page from run folders.

    python scripts/leaderboard.py leaderboard/entries/*/ --out docs/leaderboard.md

A driver is ranked by its mean driving score over the drives of leaderboard/plan.toml. A run that lacks one of them,
or was driven in other scenarios or weathers, is refused. Of a driver in several runs the one that was begun last
counts, and a verified one before others. `verification.json` in a run folder is what
`vpf-sim verify --json` printed; it counts while the records are those that it is of.
"""

import argparse
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path

import numpy as np
from complexity import Size, size_of

from vpf_sim import drivers, scenarios
from vpf_sim.errors import InputError
from vpf_sim.evaluation.analysis.abilities import AbilityRow, by_ability
from vpf_sim.evaluation.analysis.statistics import mean_interval, paired_difference
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record, Schema, checked
from vpf_sim.evaluation.metrics.registry import DRIVING_SCORE
from vpf_sim.evaluation.sweeps.plan import Plan, make_plan, read_plan
from vpf_sim.files import read_object, write_text
from vpf_sim.reporting.abilities import ALL, TITLES
from vpf_sim.reporting.kit.page import NONE, Cell, Table, Value, formatted, interval_text
from vpf_sim.reporting.run_data import StoredRun, open_run
from vpf_sim.types import Floats

ROOT = Path(__file__).parents[1]
PLAN = ROOT / "leaderboard" / "plan.toml"
VERIFICATION = "verification.json"
HEAD = """# Leaderboard

**Which driver does best in [a harder world](hard.md)?** Each drove the {drives} drives of
[leaderboard/plan.toml](../leaderboard/plan.toml): {scenarios} scenarios, each in {weathers}, seeds {seeds}.
Drivers are ranked by their mean driving score, CARLA's 2.1: the share of the route that was driven, reduced by the
share off the lanes and by collisions ([reference.md](reference.md#scores)). Lost drives count, and a run that lacks a
drive is refused. In brackets: 95 % intervals. Where the interval of a lead contains 0, the rank may be chance.

`python scripts/leaderboard.py leaderboard/entries/*/ --out docs/leaderboard.md` writes this page from the run folders.
"""
HOW_TO_ENTER = """
## How do I enter?
1. Put your driver into `leaderboard/drivers/my_driver.py`, or a policy with its manifest beside it, and drive:

   ```sh
   export PYTHONPATH=leaderboard/drivers
   vpf-sim sweep leaderboard/plan.toml --driver my_driver:MyDriver --out leaderboard/entries/my_driver
   vpf-sim verify leaderboard/entries/my_driver
   ```
2. Open a pull request with the driver and the run folder, without pictures. Its title is the driver's name.
3. The [workflow](../.github/workflows/leaderboard.yml) checks that the folder is complete and does not contradict
   itself, drives 5 % of the drives again, drawn at random, and writes the page. If you leave out `steps/`, some
   200 kB a drive, it drives all of them again. A run that differs by a bit fails, with the first difference
   ([verification.md](verification.md)).

A later run of a driver takes the place of an earlier one, once it is verified. The seeds are
public, so a driver can be tuned on them, and nothing stops that but your word. A new version of the
plan has new seeds, which all drivers drive again.
"""


class Verification(Schema):
    """What `vpf-sim verify --json` printed."""

    ok: bool
    planned: int
    driven: list[str]
    records_sha256: str


@dataclass(frozen=True)
class Entry:
    """One driver in one run, with a record for each drive of the plan."""

    driver: str
    run: StoredRun
    jobs: tuple[Job, ...]
    verified: str

    @property
    def records(self) -> list[Record]:
        return [self.run.records[job.id] for job in self.jobs]

    @cached_property
    def scores(self) -> Floats:
        """(drives,) driving scores."""
        return np.array([record[DRIVING_SCORE] or 0.0 for record in self.records], float)

    @property
    def privileged(self) -> str:
        return self.run.manifest.privileged.get(self.driver, "?")

    @cached_property
    def abilities(self) -> list[AbilityRow]:
        """Its successes by ability and weather."""
        of = {name: scenarios.load(name).abilities for name in {job.scenario for job in self.jobs}}
        return by_ability(self.jobs, self.run.records, of)

    @property
    def decision_ms(self) -> float | None:
        """The median time of the driver's part of a step."""
        times = [self.run.timing[job.id].stages_ms.get("driver") for job in self.jobs if job.id in self.run.timing]
        known = [time for time in times if time is not None]
        return float(np.median(known)) if known else None


def entries(path: Path, plan: Plan) -> Iterator[Entry]:
    """The drivers of a run; InputError where one lacks a drive of the plan, or drove in other scenarios or weathers."""
    run = open_run(path)
    _check_inputs(run, plan)
    for driver in run.plan().driver:
        jobs = tuple(Job(job.scenario, job.weather, driver, job.seed) for job in plan.jobs())
        missing = [job.id for job in jobs if job.id not in run.records]
        if missing:
            got = f"got {len(jobs) - len(missing)} of {driver}, without {missing[0]}"
            raise InputError(f"{path}: expected a record of each of the {len(jobs)} drives of the plan, {got}")
        yield Entry(driver, run, jobs, _verification(run))


def latest(found: Iterable[Entry]) -> list[Entry]:
    """Of each driver the verified run that was begun last; where none is verified, the last."""
    ordered = sorted(found, key=lambda entry: (entry.verified.startswith("yes"), entry.run.manifest.begun or ""))
    return [*{entry.driver: entry for entry in ordered}.values()]


def _check_inputs(run: StoredRun, plan: Plan) -> None:
    for kind in ("scenarios", "weathers"):
        for name, wanted in plan.hashes()[kind].items():
            if (found := run.manifest.hashes(kind).get(name)) != wanted:
                what = "none" if found is None else "another form of it"
                raise InputError(f"{run.path}: {kind}: {name}: expected that of this version, got {what}")


def _size(driver: str) -> Size | None:
    """None where it cannot be measured here."""
    try:
        drivers.create(driver)
    except InputError:
        return None
    return size_of(driver)


def _verification(run: StoredRun) -> str:
    """What the verification of a run says, in words."""
    file = run.path / VERIFICATION
    if not file.exists():
        return "no"
    content = read_object(file, "what `vpf-sim verify --json` printed")
    stored = checked(Verification, content, str(file))
    if stored.records_sha256 != sha256((run.path / "episodes.jsonl").read_bytes()).hexdigest():
        return "no, the records have changed since"
    return f"yes, {len(stored.driven)} of {stored.planned} driven again" if stored.ok else "**no, it differs**"


def page(found: Sequence[Entry], plan: Plan, sizes: bool = True) -> str:
    """The page of some entries."""
    ranked = sorted(found, key=lambda entry: (-entry.scores.mean(), entry.driver))
    counts = {"scenarios": len(plan.scenario), "drives": len(plan.jobs()), "seeds": plan.seeds}
    weathers = " and ".join(filter(None, (", ".join(plan.weather[:-1]), plan.weather[-1])))
    parts = [HEAD.format(weathers=weathers, **counts), *_ranks(ranked).markdown()]
    parts += ["\n## Abilities\nDrives that arrive, in all weathers.\n", *_abilities(ranked).markdown()]
    parts += ["\n## Weather\nThe change is that on the same scenarios and seeds, in percentage points.\n"]
    parts += [*_weathers(ranked, plan.weather).markdown()]
    parts += ["\n## Cost\nLines, settings and weights of the present sources (`python scripts/complexity.py`)."]
    parts += ["The time was measured on the run's machine, which may have been busy; it is not verified.\n"]
    return "\n".join([*parts, *_costs(ranked, sizes).markdown()]) + "\n" + HOW_TO_ENTER


def _ranks(ranked: Sequence[Entry]) -> Table:
    header = (
        "rank",
        "driver",
        "gets beyond its camera",
        "driving score",
        "lead over the next",
        "arrives",
        "verified",
        "version",
    )
    rows = []
    for place, entry in enumerate(ranked):
        total = entry.abilities[-1].all
        score = Value(f"{entry.scores.mean():.2f}", _brackets(interval_text(mean_interval(entry.scores), 2)))
        lead = _lead(entry, ranked[place + 1]) if place + 1 < len(ranked) else NONE
        arrives = Value(
            f"{total.successes} of {total.drives}", _brackets(interval_text(total.interval, 0, True) + " %")
        )
        version = entry.run.manifest.fingerprint
        made = f"{version.get('vpf_sim', '?')}, {version.get('source', '')[:8]}"
        privileged = "nothing" if entry.privileged == "none" else f"the {entry.privileged}"
        rows.append((str(place + 1), f"`{entry.driver}`", privileged, score, lead, arrives, entry.verified, made))
    return Table(header, tuple(rows), names=3)


def _brackets(text: str) -> str:
    return f"({text})" if text else ""


def _lead(entry: Entry, following: Entry) -> Cell:
    """The difference of the mean scores on the same drives."""
    change = paired_difference(entry.scores, following.scores)
    if change is None:
        return NONE
    return Value(formatted(change.difference, 2), _brackets(interval_text(change.interval, 2)))


def _abilities(ranked: Sequence[Entry]) -> Table:
    """A row for each ability, a column for each driver."""
    rows = []
    for number, row in enumerate(ranked[0].abilities):
        title = ALL if row.ability is None else TITLES[row.ability]
        cells = [entry.abilities[number].all for entry in ranked]
        rows.append((title, *(_share(one.successes, one.drives, one.interval) for one in cells)))
    return Table(("ability", *(f"`{entry.driver}`" for entry in ranked)), tuple(rows))


def _share(successes: int, drives: int, interval: tuple[float, float]) -> Value:
    return Value(f"{successes} of {drives}", f"({interval_text(interval, 0, True)} %)")


def _weathers(ranked: Sequence[Entry], weathers: Sequence[str]) -> Table:
    base, *others = weathers
    rows = []
    for entry in ranked:
        row = entry.abilities[-1]
        shares = [row.by_weather[weather] for weather in weathers]
        changes = [row.changes[weather] for weather in others]
        cells = [_share(one.successes, one.drives, one.interval) for one in shares]
        texts = [formatted(one.difference, 0, True) for one in changes]
        ends = [_brackets(interval_text(one.interval, 0, True)) for one in changes]
        rows.append((f"`{entry.driver}`", *cells, *map(Value, texts, ends)))
    return Table(("driver", *weathers, *(f"{weather} − {base}" for weather in others)), tuple(rows))


def _costs(ranked: Sequence[Entry], sizes: bool) -> Table:
    rows = []
    for entry in ranked:
        size = _size(entry.driver) if sizes else None
        counts = (
            (NONE,) * 3
            if size is None
            else (f"{size.lines:,}", f"{size.settings:,}", f"{size.weights:,}" if size.weights else NONE)
        )
        rows.append((f"`{entry.driver}`", *counts, formatted(entry.decision_ms, 2)))
    return Table(("driver", "lines of code", "settings", "weights", "ms a step"), tuple(rows))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN")
    parser.add_argument("--plan", type=Path, default=PLAN, help="the drives that count")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE")
    parser.add_argument("--no-sizes", action="store_true", help="leave out lines, settings and weights")
    options = parser.parse_args()
    try:
        plan = make_plan({"driver": ["-"], **read_plan(str(options.plan))}, str(options.plan))
        found = [one for path in options.runs for one in entries(path, plan)]
        write_text(options.out, page(latest(found), plan, not options.no_sizes))
    except (InputError, OSError) as error:
        sys.exit(f"leaderboard.py: {error}")


if __name__ == "__main__":
    main()
