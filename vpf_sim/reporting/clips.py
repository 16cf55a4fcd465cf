"""Short video clips of episodes, small enough to embed in a page."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from vpf_sim.evaluation.metrics.records import Record
from vpf_sim.reporting import episode_view
from vpf_sim.reporting.kit.clip import Clip
from vpf_sim.reporting.redraw import redrawing
from vpf_sim.reporting.run_data import StoredRun
from vpf_sim.reporting.video import Writer
from vpf_sim.types import Image

LENGTH_S, RATE_HZ = 6.0, 30.0
SCALE = 0.75
CRF = 27  # of x264: about half a megabyte a clip


@dataclass(frozen=True, slots=True)
class EpisodeClip:
    """A video of a part of an episode; its poster is the last frame."""

    episode: str
    ending: str
    remarks: tuple[str, ...]
    film: Clip


def choose(records: Iterable[Record], drivers: Sequence[str], count: int) -> list[Record]:
    """Up to `count` unsuccessful episodes, different kinds of failure and cells first; one success if there is none."""
    order = {driver: number for number, driver in enumerate(drivers)}
    driven = [record for record in records if record.steps > 0]
    driven.sort(key=lambda record: (order.get(record.driver, len(order)), record.seed, record.id))
    failed = [record for record in driven if not record.succeeded] or driven[:1]
    kinds: Counter[tuple[str, ...]] = Counter()
    cells: Counter[tuple[str, ...]] = Counter()
    ranked = []
    for number, record in enumerate(failed):
        kind = (record.driver, record.status)
        cell = (*kind, record.scenario, record.weather)
        ranked.append((0 if kinds[kind] == 0 else 1 + cells[cell], number, record))
        kinds[kind] += 1
        cells[cell] += 1
    return [record for *_, record in sorted(ranked, key=lambda item: item[:2])[:count]]


def make(run: StoredRun, record: Record, until_m: float | None = None) -> EpisodeClip:
    """Re-render the episode and encode its end, or the seconds before `until_m` of the route."""
    drawn = redrawing(run, record.id, replan=True)
    last = len(drawn.table)
    if until_m is not None and drawn.table.route_m[-1] > until_m:
        last = int(np.argmax(drawn.table.route_m > until_m))
    first, stride = max(0, last - round(LENGTH_S * drawn.rate_hz)), max(1, round(drawn.rate_hz / RATE_HZ))
    size = tuple(round(SCALE * side / 2) * 2 for side in episode_view.size_px(drawn.camera))
    width, height = size
    with TemporaryDirectory() as folder:
        path = Path(folder) / "clip.mp4"
        with Writer(path, (width, height), drawn.rate_hz / stride, CRF) as writer:
            for _, frame in episode_view.frames(drawn, lambda row: first <= row <= last and (last - row) % stride == 0):
                small: Image = cv2.resize(frame, (width, height), interpolation=cv2.INTER_AREA)  # type: ignore[assignment]
                writer.write(small)
        video = path.read_bytes()
    return EpisodeClip(record.id, episode_view.ending(drawn), tuple(drawn.remarks), Clip.embedded(video, small))
