"""The report of a run: one HTML file that needs nothing else, and no script to be read."""

from collections.abc import Callable
from importlib.resources import files
from typing import Any

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from vpf_sim.errors import InputError
from vpf_sim.report import accuracy, answer, cells, clips, dots, failures, figures, success_map, tables
from vpf_sim.report.cells import shown
from vpf_sim.report.chart import legend_key
from vpf_sim.report.clips import Clip
from vpf_sim.report.stored_run import StoredRun
from vpf_sim.report.subject import Subject
from vpf_sim.shell import command

MOST_LISTED = 40  # ways of failing
Tell = Callable[[str], None]


def make(run: StoredRun, clip_count: int, tell: Tell) -> str:
    """The page as HTML; `tell` hears what is being done."""
    subject = Subject.of(run)
    tell("drawing the paths and commands")
    content = {**_asked(subject), **_charts(subject), **_tables(subject), **_failures(subject)}
    return render({**content, "clips": _clips(subject, clip_count, tell)})


def render(content: dict[str, Any]) -> str:
    """The template filled."""
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.globals["key"] = legend_key
    environment.filters["shown"] = shown
    folder = files("vpf_sim.report")
    style = Markup(environment.from_string(folder.joinpath("report.css.jinja").read_text("utf-8")).render())
    template = environment.from_string(folder.joinpath("report.html.jinja").read_text("utf-8"))
    return template.render(style=style, **content)


def _asked(subject: Subject) -> dict[str, Any]:
    """The question, the answer, and where they come from."""
    return {
        "command": subject.command,
        "plan": subject.plan,
        "order": subject.order,
        "question": answer.question(subject.command, subject.order),
        "answers": answer.sentences(subject.command, subject.rows, subject.order),
        "driven": len(subject.records),
        "planned": len(subject.jobs),
        "folder": str(subject.run.path),
        "film_again": lambda episode: command("video", subject.run.path, id=episode),
        "fingerprint": subject.run.manifest["fingerprint"],
        "mixed": sorted({str(one["fingerprint"]) for one in subject.records.values() if "fingerprint" in one}),
        "changed": sorted(shown(name) for name in subject.changed()),
    }


def _charts(subject: Subject) -> dict[str, Any]:
    found = figures.sections(subject)
    return {
        "sections": found.drawn,
        "left_out": found.left_out,
        "dots": list(figures.scores(subject.rows, subject.order)),
        "marks": dots.SIGNS,
    }


def _tables(subject: Subject) -> dict[str, Any]:
    rows, order, records = subject.rows, subject.order, list(subject.records.values())
    compared = subject.summary.get("comparisons") or []
    return {
        "columns": cells.MAIN,
        "groups": cells.groups(rows, order),
        "has_paper": any(row.get("paper") for row in rows),
        "accuracies": [(name, accuracy.by_definition(rows, order, name)) for name in accuracy.SIGNALS],
        "parts": accuracy.by_part(rows, order),
        "map": list(success_map.rows(subject.jobs, subject.records, order)),
        "signs": success_map.signs(subject.jobs, subject.records),
        "sign_of": success_map.SIGNS,
        "weather_differences": tables.comparisons(compared, "weather", order),
        "driver_differences": tables.comparisons(compared, "driver", order),
        "seeds_needed": tables.seeds_needed(rows, order),
        "perception": tables.perception(rows, order, tables.PERCEPTION),
        "objects": tables.perception(rows, order, tables.OBJECTS),
        "comfort": tables.comfort(records, order),
        "compute": tables.compute(subject.run.timing, records, order),
        "hosts": sorted({str(time["host"]) for time in subject.run.timing.values() if "host" in time}),
    }


def _failures(subject: Subject) -> dict[str, Any]:
    found = failures.endings(subject.failures(), subject.run.reason)
    return {
        "failures": [(ending, failures.ranges(ending.seeds)) for ending in found[:MOST_LISTED]],
        "unlisted": sum(len(ending.seeds) for ending in found[MOST_LISTED:]),
    }


def _clips(subject: Subject, count: int, tell: Tell) -> list[Clip]:
    """Films of failures, but of those that cannot be drawn any more, such as without the scenario's file."""
    chosen = clips.choose(subject.failures(), subject.order.drivers, count)
    films = []
    for number, record in enumerate(chosen, start=1):
        tell(f"filming {record['id']}, clip {number} of {len(chosen)}")
        try:
            films.append(clips.make(subject.run, record))
        except InputError as error:
            tell(f"{record['id']} cannot be drawn again: {error}")
    return films
