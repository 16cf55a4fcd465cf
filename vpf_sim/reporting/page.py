"""The report of a run: one self-contained HTML file without scripts."""

from collections.abc import Callable

from vpf_sim.errors import InputError
from vpf_sim.reporting import abilities, clips, endings, figures, headline, main_table, tables, video
from vpf_sim.reporting.clips import EpisodeClip
from vpf_sim.reporting.kit import interval_chart
from vpf_sim.reporting.kit.page import Content, render
from vpf_sim.reporting.main_table import shown
from vpf_sim.reporting.run_data import RunData, StoredRun
from vpf_sim.system import command

MOST_LISTED = 40  # groups of failures
MOST_OPEN = 6  # pairs of scenario and weather of a table that is not folded
Notify = Callable[[str], None]


def make(run: StoredRun, clip_count: int, notify: Notify) -> str:
    """The page as HTML; `notify` receives progress messages."""
    run_data = RunData.of(run)
    notify("drawing the paths and commands")
    content = {**_headline(run_data), **_charts(run_data), **_tables(run_data), **_failures(run_data)}
    return render("report.html.jinja", **content, clips=_clips(run_data, clip_count, notify))


def _headline(run_data: RunData) -> Content:
    """The title, the findings, and the run's plan and fingerprint."""
    against = headline.of_two(run_data.jobs, run_data.records, run_data.order)
    return {
        "command": run_data.command,
        "plan": run_data.plan,
        "order": run_data.order,
        "weathers": [*map(shown, run_data.order.weathers)],
        "title": headline.title(run_data.plan, run_data.run.begun),
        "findings": headline.sentences(run_data.rows, run_data.order, against, run_data.command),
        "driven": len(run_data.records),
        "planned": len(run_data.jobs),
        "folder": str(run_data.run.path),
        "video_command": lambda episode: command("video", run_data.run.path, id=episode),
        "fingerprint": run_data.run.manifest.fingerprint,
        "mixed": sorted({one.fingerprint for one in run_data.records.values() if one.fingerprint}),
        "changed": sorted(shown(name) for name in run_data.changed()),
    }


def _charts(run_data: RunData) -> Content:
    found = figures.sections(run_data)
    return {
        "sections": found.drawn,
        "commands": found.commands,
        "left_out": found.left_out,
        "dots": list(figures.scores(run_data.rows, run_data.order)),
        "marks": interval_chart.SIGNS,
    }


def _tables(run_data: RunData) -> Content:
    rows, order, records = run_data.rows, run_data.order, list(run_data.records.values())
    compared = run_data.summary.comparisons
    return {
        "abilities": abilities.abilities(run_data),
        "columns": main_table.DRIVING,
        "groups": main_table.groups(rows, order),
        "open_groups": MOST_OPEN,
        "has_paper": any(row.paper for row in rows),
        "accuracies": [(name, tables.by_definition(rows, order, name)) for name in tables.SIGNALS],
        "parts": tables.by_part(rows, order),
        "map": list(endings.rows(run_data.jobs, run_data.records, order)),
        "signs": endings.signs(run_data.jobs, run_data.records),
        "sign_of": endings.SIGNS,
        "weather_differences": tables.comparisons(compared, "weather", order),
        "driver_differences": tables.comparisons(compared, "driver", order),
        "seeds_needed": tables.seeds_needed(rows, order),
        "perception": tables.perception(rows, order, tables.PERCEPTION),
        "objects": tables.perception(rows, order, tables.OBJECTS),
        "comfort": tables.comfort(records, order),
        "compute": tables.compute(run_data.run.timing, records, order),
        "hosts": sorted({time.host for time in run_data.run.timing.values() if time.host}),
    }


def _failures(run_data: RunData) -> Content:
    found = endings.endings(run_data.failures(), run_data.run.reason)
    example = found[0].example if found else ""
    return {
        "video_remedy": "" if video.is_available() else video.INSTALL,
        "example": example if example and run_data.run.steps(example) is not None else "",
        "failures": endings.table(found[:MOST_LISTED]),
        "classes": abilities.failure_classes(run_data),
        "failed": len(run_data.failures()),
        "unlisted": sum(len(ending.seeds) for ending in found[MOST_LISTED:]),
    }


def _clips(run_data: RunData, count: int, notify: Notify) -> list[EpisodeClip]:
    """Clips of failures, or of a success; those that cannot be re-rendered are skipped."""
    if not video.can_film(count, notify):
        return []
    chosen = clips.choose(run_data.records.values(), run_data.order.drivers, count)
    made = []
    for number, record in enumerate(chosen, start=1):
        notify(f"rendering {record.id}, clip {number} of {len(chosen)}")
        try:
            made.append(clips.make(run_data.run, record))
        except InputError as error:
            notify(f"{record.id} cannot be re-rendered: {error}")
    return made
