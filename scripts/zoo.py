"""Write the zoo's page, a row and a section for each driver, and its pictures, from run folders.

    python scripts/zoo.py RUN... --out docs/zoo.md --pictures docs/pictures/zoo

Drivers are those of the runs. A picture is of the first run with steps: the moment before the driver is nearest to
anything, with what it perceives and plans where it shows that. Where no run has steps, the picture of before is kept.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path

import cv2
import numpy as np
from complexity import Size, size_of

from vpf_sim import drivers
from vpf_sim.drivers.learned import manifest
from vpf_sim.drivers.learned.manifest import Training
from vpf_sim.errors import InputError
from vpf_sim.evaluation.analysis.statistics import mean_interval, share_interval
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.evaluation.metrics.registry import CLEARANCE, DRIVING_SCORE
from vpf_sim.evaluation.sweeps.plan import SHIPPED, Plan, read_plan
from vpf_sim.files import write_bytes, write_text
from vpf_sim.reporting import overlay
from vpf_sim.reporting.kit.clip import jpeg
from vpf_sim.reporting.kit.page import NONE, Table, Value, interval_text
from vpf_sim.reporting.redraw import redrawing
from vpf_sim.reporting.run_data import StoredRun, open_run
from vpf_sim.types import Image

SIZE_PX, QUALITY = (480, 360), 80
BEFORE_S = 1.0  # the least clearance: the obstacle is then in the picture
BARS = "▁▂▃▄▅▆▇█"
MOST_BARS = 24
HEAD = """# Zoo

**What are the main drivers made of, and how do I make or drive one?** [reference.md](reference.md#driver) lists
all. What each costs and scores is on the pages [Leaderboard](leaderboard.md) and [Which driver?](comparison.md).
Intervals are of 95 %.

`python scripts/zoo.py RUN... --out docs/zoo.md --pictures docs/pictures/zoo` writes this page from run folders and from
the manifests of the networks.
"""


@dataclass(frozen=True)
class Animal:
    """A driver with what the runs say of it."""

    name: str
    runs: tuple[StoredRun, ...]
    size: Size
    training: Training | None
    picture: Path  # may be missing

    def jobs(self, run: StoredRun) -> list[Job]:
        """Its planned episodes in a run."""
        return [job for job in run.plan().jobs() if job.driver == self.name]

    def records(self, run: StoredRun) -> list[Record]:
        """Its records in a run."""
        return [run.records[job.id] for job in self.jobs(run) if job.id in run.records]


def animals(runs: Sequence[StoredRun], pictures: Path) -> Iterator[Animal]:
    """The drivers of the runs, in the registry's order, then the others."""
    found = dict.fromkeys(driver for run in runs for driver in run.plan().driver)
    for name in sorted(found, key=[*drivers.names(), *found].index):
        model = drivers.model_of(name)
        training = None if model is None else manifest.load(model).training
        its = tuple(run for run in runs if name in run.plan().driver)
        file = pictures / f"{name.replace(':', '-').replace('/', '-')}.jpg"
        yield Animal(name, its, size_of(name), training, file)


def draw(animal: Animal) -> Image | None:
    """The driver's view at the least clearance of a drive that arrived, else of any; None without steps."""
    for run in animal.runs:
        stored = [one for one in animal.records(run) if (run.path / "steps" / f"{one.id}.parquet").exists()]
        if stored:
            nearest = min(
                stored, key=lambda one: (not one.succeeded, one[CLEARANCE] if one[CLEARANCE] is not None else inf)
            )
            return _frame(run, nearest.id)
    return None


def _frame(run: StoredRun, episode: str) -> Image:
    drawn = redrawing(run, episode, replan=True)
    nearest = int(np.argmin(drawn.table.clearance_m))
    index = max(0, nearest - round(BEFORE_S * drawn.rate_hz))
    moment = next(one for one in drawn.moments() if one.index >= index and one.image.size)
    shown = overlay.draw(moment.image, moment.plan, drawn.camera)
    return np.asarray(cv2.resize(shown, SIZE_PX, interpolation=cv2.INTER_AREA), np.uint8)


def page(found: Sequence[Animal], out: Path) -> str:
    """The page, which lies at `out`."""
    header = ("driver", "is", "gets beyond its camera", "made of", "arrives", "driving score")
    rows = []
    for one in found:
        described = drivers.description(one.name)
        link = f"[`{one.name}`](#{_anchor(one.name)})"
        privileged = "nothing" if described.privileged == "none" else f"the {described.privileged}"
        rows.append((link, described.summary, privileged, _made_of(one.size), *_results(one, one.runs[0])))
    table = Table(header, tuple(rows), names=4)
    return "\n".join([HEAD, *table.markdown(), *(line for one in found for line in section(one, out))]) + "\n"


def section(one: Animal, out: Path) -> Iterator[str]:
    """A driver's own lines."""
    yield f"\n## {one.name}\n"
    if one.picture.exists():
        picture = one.picture.resolve().relative_to(out.resolve().parent).as_posix()
        yield f"![What {one.name} sees and plans]({picture})\n"
    yield f"{_sentence(drivers.description(one.name).summary)}\n"
    yield f"- Made of {_made_of(one.size)}"
    if one.training is not None:
        yield from trained(one.training)
    yield f"- Drive it: `vpf-sim drive crossing --driver {one.name}`"
    for run in one.runs:
        arrives, score = (
            f"{value.text} ({value.beside})" if value.beside else value.text for value in _results(one, run)
        )
        yield f"- Results: arrives in {arrives}, driving score {score} (`{_command(one, run.plan())}`)"


def _command(one: Animal, plan: Plan) -> str:
    """The command that drives the run's episodes of a driver."""
    known = next((name for name in SHIPPED if tuple(read_plan(name)["scenario"]) == plan.scenario), None)
    grid = [known] if known else [f"--scenario {name}" for name in plan.scenario]
    grid += [f"--weather {name}" for name in plan.weather]
    return f"vpf-sim sweep {' '.join(grid)} --driver {one.name} --seeds {plan.seeds}"


def trained(training: Training) -> Iterator[str]:
    """How a network was trained."""
    teacher = f"Teacher: {training.expert}" if training.expert else "Teacher: none, it learned by reward"
    made = f"{training.frames:,} decisions, {training.driven_h:g} h of driving, {training.wall_h:g} h of training"
    yield f"- {teacher}; {made}"
    yield f"- Training curve: {curve(training.curve)}"
    at = f", at commit {training.commit[:8]}" if training.commit else ""
    yield f"- Make it again: `{training.command}`{at}"


def curve(values: Sequence[float]) -> str:
    """A curve as bars, with its first and last value."""
    if not values:
        return "not recorded"
    places = np.unique(np.linspace(0, len(values) - 1, min(len(values), MOST_BARS)).round().astype(int))
    chosen = np.array(values)[places]
    share = (chosen - chosen.min()) / (np.ptp(chosen) or 1.0)
    bars = "".join(BARS[int(one)] for one in np.round(share * (len(BARS) - 1)))
    return f"{bars}, loss {values[0]:.3g} to {values[-1]:.3g} in {len(values)} epochs"


def _results(one: Animal, run: StoredRun) -> tuple[Value, Value]:
    """Arrivals and driving score in a run, with their intervals."""
    records = one.records(run)
    planned = one.jobs(run)
    arrived = sum(record.succeeded for record in records)
    share = interval_text(share_interval(arrived, len(planned)), 0, percent=True)
    scores = np.array([record[DRIVING_SCORE] or 0.0 for record in records], float)
    mean = f"{scores.mean():.2f}" if len(scores) else NONE
    return Value(f"{arrived} of {len(planned)}", f"{share} %"), Value(mean, interval_text(mean_interval(scores), 2))


def _made_of(size: Size) -> str:
    return f"{size.weights:,} weights, {size.lines:,} lines" if size.weights else f"{size.lines:,} lines"


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}."


def _anchor(name: str) -> str:
    return "".join(letter for letter in name.lower() if letter.isalnum() or letter in "-_")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE")
    parser.add_argument("--pictures", type=Path, required=True, metavar="FOLDER", help="below the page's folder")
    options = parser.parse_args()
    try:
        if not options.pictures.resolve().is_relative_to(options.out.resolve().parent):
            raise InputError(f"--pictures: expected a folder below that of {options.out}, got {options.pictures}")
        found = [*animals([open_run(path) for path in options.runs], options.pictures)]
        for one in found:
            if (picture := draw(one)) is not None:
                one.picture.parent.mkdir(parents=True, exist_ok=True)
                write_bytes(one.picture, jpeg(picture, QUALITY))
        write_text(options.out, page(found, options.out))
    except (InputError, OSError) as error:
        sys.exit(f"zoo.py: {error}")


if __name__ == "__main__":
    main()
