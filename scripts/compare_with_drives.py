"""Compare frame statistics of recorded drives with rendered frames of the same camera, rate and speed.

python scripts/compare_with_drives.py [--drives DIR] [--only NAME ...] [--out DIR] [--json FILE] [--seeds 0 1 2]

Rendered values are means over the seeds. A ratio (rendered / real) outside 1/2 .. 2 is marked with a star. --out writes
images side by side: real left, rendered right.
"""

import argparse
import json
import os
from dataclasses import asdict
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from vpf_sim.evaluation.analysis.text_table import text_table
from vpf_sim.evaluation.processes.threads import limit_opencv
from vpf_sim.evaluation.rendering import reference_streets
from vpf_sim.evaluation.rendering.frame_statistics import FrameStatistics, measure, scaled_grey
from vpf_sim.replay import readers
from vpf_sim.replay.recording import Recording
from vpf_sim.types import Image

SAMPLES = 16  # sampled frames of a drive, about
LARGEST_RATIO = 2.0


def compare(name: str, recording: Recording, seeds: list[int], out: Path | None) -> list[dict[str, Any]]:
    """The rows real, rendered and ratio of one drive."""
    real = [frame.image for frame in recording.frames() if frame.image is not None]
    theirs = statistics(real)
    street = reference_streets.STREETS[name]
    drive = street.drive(recording.camera, recording.rate_hz, float(np.median(recording.speed_mps)))
    parts = []
    for seed in seeds:
        rendered = [shot.image for shot in drive.shots(street.modified_weather(), seed, len(real))]
        parts.append(statistics(rendered))
        if out is not None:
            save(out, f"{name}_seed{seed}", real, rendered)
    ours = FrameStatistics.mean(parts)
    ratio = {key: _starred(value) for key, value in ours.ratio(theirs).items()}
    return [
        {"frames": f"{name} real", **asdict(theirs)},
        {"frames": "  rendered", **asdict(ours)},
        {"frames": "  ratio", **ratio},
    ]


def statistics(images: list[Image]) -> FrameStatistics:
    """The statistics of consecutive frames, sampled about SAMPLES times."""
    return measure([scaled_grey(image) for image in images], every=max(1, len(images) // SAMPLES))


def save(out: Path, name: str, real: list[Image], rendered: list[Image]) -> None:
    """Write three pairs of images, real left, rendered right."""
    out.mkdir(parents=True, exist_ok=True)
    for k in (0, len(real) // 2, len(real) - 1):
        pair = np.hstack([real[k], rendered[k]])
        cv2.imwrite(str(out / f"{name}_{k:03d}.png"), cv2.cvtColor(pair, cv2.COLOR_RGB2BGR))


def _starred(ratio: float) -> str:
    within = 1.0 / LARGEST_RATIO <= ratio <= LARGEST_RATIO
    return f"{ratio:.2f}" + ("" if within else "*")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    shared = os.environ.get("VPF_SIM_SHARED", "../shared")
    parser.add_argument("--drives", type=Path, default=Path(shared) / "drives", help="folder of the drives")
    parser.add_argument("--only", nargs="*", choices=list(reference_streets.STREETS), help="drives; all by default")
    parser.add_argument("--out", type=Path, help="folder for images side by side")
    parser.add_argument("--json", type=Path, help="also write the table to this file")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    arguments = parser.parse_args()
    limit_opencv()
    rows: list[dict[str, Any]] = []
    for name in arguments.only or reference_streets.STREETS:
        new = compare(name, readers.read(arguments.drives / name), arguments.seeds, arguments.out)
        print(text_table(new, header=not rows), flush=True)
        rows.extend(new)
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
