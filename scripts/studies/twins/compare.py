"""Compare recorded drives with their rendered twins: same camera, rate, speed, traffic, and gap to the lead vehicle.

python scripts/studies/twins/compare.py [--drives DIR] [--seeds 0 1 2] [--perception] [--driver NAME] [--out DIR]

Prints frame statistics: a ratio (rendered / real) outside 1/2 .. 2 is marked with a star. With --perception a driver
is replayed on recording and twin, in open loop, and its reports are measured on both (docs/twins.md). Values of the
twin are means over the seeds. --out keeps the twins as recordings for `vpf-sim replay`, with the frames of the driver
and images side by side: real left, rendered right.
"""

import argparse
import os
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pandas as pd
import reference_streets
import twin
from frame_statistics import FrameStatistics, measure, scaled_grey
from measures import Measures

from vpf_sim import drivers
from vpf_sim.errors import InputError
from vpf_sim.replay import frame_table, open_loop
from vpf_sim.replay.frame_table import FrameTable, table_path
from vpf_sim.replay.recording import Recording
from vpf_sim.system import limit_opencv
from vpf_sim.types import Image

SAMPLES = 16  # sampled frames of a drive, about
LARGEST_RATIO = 2.0
Rows = list[dict[str, Any]]


def compare(drive: Path, seeds: list[int], driver: str | None, out: Path) -> tuple[Rows, Rows]:
    """The rows real, rendered and ratio of a drive's frame statistics, and a row for each measure of the driver."""
    recording = twin.recorded(drive, out / "recorded")
    twins = [twin.rendered(recording, seed, out / f"twin-{seed}") for seed in seeds]
    save(out, recording, twins[0])
    ours, theirs = FrameStatistics.mean([statistics(one) for one in twins]), statistics(recording)
    ratio = {key: _starred(value) for key, value in ours.ratio(theirs).items()}
    frames: Rows = [
        {"frames": f"{drive.name} real", **asdict(theirs)},
        {"frames": "  rendered", **asdict(ours)},
        {"frames": "  ratio", **ratio},
    ]
    if driver is None:
        return frames, []
    real = Measures.of(replayed(recording, driver, out / "driver"))
    seen = Measures.mean([Measures.of(replayed(one, driver, out / f"driver-{one.name}")) for one in twins])
    return frames, real.rows(seen)


def replayed(recording: Recording, driver: str, out: Path) -> FrameTable:
    """Replay a driver on a recording and read its frames; InputError where the driver fails."""
    record, _ = open_loop.run(recording, driver, out, with_video=False)
    if record.error:
        raise InputError(f"{recording.name}: the driver '{driver}' failed: {record.error.what}")
    return frame_table.read(table_path(out, recording.name))


def statistics(recording: Recording) -> FrameStatistics:
    """The statistics of consecutive frames, sampled about SAMPLES times."""
    greys = [scaled_grey(image) for image in images(recording)]
    return measure(greys, every=max(1, len(greys) // SAMPLES))


def images(recording: Recording) -> list[Image]:
    """The frames without gaps."""
    return [frame.image for frame in recording.frames() if frame.image is not None]


def save(out: Path, recording: Recording, rendered: Recording) -> None:
    """Write three pairs of images, real left, rendered right."""
    real, ours = images(recording), images(rendered)
    for k in (0, len(ours) // 2, len(ours) - 1):
        pair = np.hstack([real[k], ours[k]])
        cv2.imwrite(str(out / f"pair_{k:03d}.png"), cv2.cvtColor(pair, cv2.COLOR_RGB2BGR))


def _starred(ratio: float) -> str:
    within = 1.0 / LARGEST_RATIO <= ratio <= LARGEST_RATIO
    return f"{ratio:.2f}" + ("" if within else "*")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    shared = os.environ.get("VPF_SIM_SHARED", "../shared")
    parser.add_argument("--drives", type=Path, default=Path(shared) / "drives", help="folder of the drives")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2], help="of the twins, each once")
    parser.add_argument("--perception", action="store_true", help="replay a driver on recording and twin")
    parser.add_argument("--driver", default="vpf", help="that is replayed; vpf by default")
    parser.add_argument("--out", type=Path, help="new folder for twins, images and the driver's frames")
    arguments = parser.parse_args()
    if arguments.out is not None and arguments.out.exists():
        parser.error(f"--out: expected a new folder, found {arguments.out}")
    if len(set(arguments.seeds)) < len(arguments.seeds):
        parser.error(f"--seeds: expected each once, got {' '.join(map(str, arguments.seeds))}")
    limit_opencv()
    try:
        if arguments.perception:
            drivers.create(arguments.driver)
        with tempfile.TemporaryDirectory() as scratch:
            compare_all(arguments, arguments.out or Path(scratch))
    except InputError as error:
        parser.error(str(error))


def compare_all(arguments: argparse.Namespace, out: Path) -> None:
    """Print the tables of all drives."""
    for number, name in enumerate(reference_streets.STREETS):
        driver = arguments.driver if arguments.perception else None
        frames, perception = compare(arguments.drives / name, arguments.seeds, driver, out / name)
        print(_text(frames, header=number == 0 or arguments.perception), flush=True)
        if perception:
            print(f"\n{_text(perception)}\n", flush=True)


def _text(rows: Rows, header: bool = True) -> str:
    """The rows as aligned columns with three digits."""
    return pd.DataFrame(rows).to_string(index=False, header=header, col_space=12, float_format="{:.3g}".format)


if __name__ == "__main__":
    main()
