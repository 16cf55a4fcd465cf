"""The data sheet of an exported set, after Gebru et al., "Datasheets for Datasets", CACM 64(12), 2021, in short."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence

from jinja2 import Environment, PackageLoader, StrictUndefined

from vpf_sim import __version__
from vpf_sim.datasets.contents import Contents
from vpf_sim.datasets.formats import Written
from vpf_sim.evaluation.sweeps.fingerprint import commit_of
from vpf_sim.reporting.cells import shown
from vpf_sim.reporting.run_data import StoredRun

MOST_LISTED = 20
TRUTHS = {
    "depth": "m along the optical axis, inf in the sky",
    "flow": "px from the frame before, x right, y down",
    "foe": "px, the image of the direction of motion, nan while the car stands",
    "ttc": "s until contact, inf if the gap does not close",
    "instance": "0 ground and sky, -1 scenery, from 1 on an object",
    "hidden": "whether water or a wiper hides the pixel",
}


def make(
    head: str,
    run: StoredRun,
    format_name: str,
    contents: Contents,
    episodes: Sequence[Written],
    left_out: Mapping[str, str],
    remarks: Sequence[str],
) -> str:
    """The sheet as Markdown, after the format's own head."""
    made = run.manifest.fingerprint
    environment = Environment(
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        loader=PackageLoader("vpf_sim.datasets", ""),
    )
    return environment.get_template("datasheet.md.jinja").render(
        head=head,
        run=run,
        made={"vpf_sim": made.get("vpf_sim"), "source": made.get("source")},
        commit=commit_of(made.get("source", "")),
        version=__version__,
        format_name=format_name,
        contents=contents,
        truths={name: TRUTHS[name] for name in contents.truth},
        episodes=episodes,
        frames=sum(one.length for one in episodes),
        rate_hz=episodes[0].rate_hz,
        drivers=", ".join(dict.fromkeys(f"`{one.record.driver}`" for one in episodes)),
        tasks=dict.fromkeys(one.task for one in episodes),
        cells=_cells(episodes),
        left_out=[*left_out.items()],
        verified=sum(one.is_verified for one in episodes),
        without_hash=sum(one.record.frames_sha256 is None for one in episodes),
        remarks=remarks,
        most=MOST_LISTED,
    )


def _cells(episodes: Sequence[Written]) -> Iterator[list[str]]:
    """A row for each scenario, weather and driver."""
    cells: dict[tuple[str, ...], list[Written]] = defaultdict(list)
    for one in episodes:
        cells[one.record.cell].append(one)
    for (scenario, weather, driver), some in cells.items():
        endings = Counter(one.record.status for one in some)
        ended = ", ".join(f"{count} {name}" for name, count in endings.most_common())
        frames = sum(one.length for one in some)
        row = (shown(scenario), shown(weather), driver, spans(one.record.seed for one in some))
        yield [str(value).replace("|", "\\|") for value in (*row, len(some), frames, ended)]


def spans(numbers: Iterable[int]) -> str:
    """Numbers as spans: "0 to 2, 5"."""
    found: list[list[int]] = []
    for number in sorted(set(numbers)):
        if found and number == found[-1][1] + 1:
            found[-1][1] = number
        else:
            found.append([number, number])
    return ", ".join(f"{first} to {last}" if last > first else str(first) for first, last in found)
