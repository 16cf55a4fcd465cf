"""Train a driver that looks through the camera alone, by cloning a driver with privilege, and export it to ONNX.

python train_bc.py FOLDER writes FOLDER/policy.onnx and FOLDER/policy.toml. Then

    vpf-sim drive town04-clean --driver onnx:FOLDER/policy.onnx

It needs `pip install 'vpf_sim[learn,onnx]'`. docs/learning.md explains the method.
"""

import argparse
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np

try:
    import torch
except ModuleNotFoundError as missing:
    sys.exit(f"train_bc.py: {missing}: pip install 'vpf_sim[learn,onnx]'")

from behaviour_cloning import scenes
from behaviour_cloning.collect import Drive, Settings, collect
from behaviour_cloning.export import commit, export
from behaviour_cloning.fit import Answers, Decisions, answers, fit, unsure_ratio
from behaviour_cloning.network import Network
from vpf_sim import drivers
from vpf_sim.drivers.learned.familiarity import learned_from
from vpf_sim.drivers.learned.manifest import Crop, Manifest, PictureInput, StateInput, Training, Uncertainty
from vpf_sim.policy_state import SPEED_SCALE_MPS

LEARNER_SHARES = (0.0, 0.5, 0.8, 1.0)  # of the turns at the wheel, by round; the last share holds for later rounds
EVERY = 20  # which pictures of a drive describe what the policy learned from
FIRST_ROUND, LAST_EPOCHS = 2, 3  # times as many drives in the first round, and epochs in the last
SURE_SHARE = 0.95  # of the decisions of the last round, which the learner drove alone, that it is to be sure of
MANIFEST = Manifest(
    schema=1,
    rate_hz=20.0,
    summary="a small network that was cloned from a driver with privilege",
    image=PictureInput(
        width_px=160, height_px=64, frames_ago=(40, 20, 8, 3, 0), crop=Crop(top_share=0.46666666666666667)
    ),
    state=StateInput(values=("speed",)),
)


def main(options: argparse.Namespace) -> None:
    began_s, made_from = perf_counter(), commit()
    torch.set_num_threads(1)  # another thread makes the batches
    torch.manual_seed(options.seed)
    assert MANIFEST.image is not None
    network, ago = Network(*MANIFEST.image.shape[1:]), MANIFEST.image.frames_ago
    options.out.mkdir(parents=True, exist_ok=True)
    model, drives, curve = options.out / "policy.onnx", [], []
    for number in range(options.rounds):
        new = gathered(options, number, model if number else None, began_s)
        if number:  # the network has not learned from these
            ratio = unsure_ratio(answers(network, Decisions(new, ago)))
            print(f"round {number}: where it is most unsure, it errs {ratio:.1f} times as much as elsewhere")
        drives += new
        epochs = options.epochs * (LAST_EPOCHS if number == options.rounds - 1 else 1)
        for loss in fit(network, Decisions(drives, ago), epochs, options.seed + number):
            curve.append(round(loss, 4))
            print(f"round {number}: loss {loss:.4f}, {minutes(began_s):.1f} min", flush=True)
        found = answers(network, Decisions(new, ago))
        export(network, recorded(options, drives, found, curve, made_from, minutes(began_s) / 60.0), model)
    print(f"written: {model}")


def gathered(options: argparse.Namespace, number: int, model: Path | None, began_s: float) -> list[Drive]:
    """The drives of a round."""
    first = options.seed + (0 if number == 0 else (number - 1 + FIRST_ROUND) * options.drives)
    seeds = range(first, first + options.drives * (FIRST_ROUND if number == 0 else 1))
    share = LEARNER_SHARES[min(number, len(LEARNER_SHARES) - 1)]
    settings = Settings(options.teacher, MANIFEST, options.decisions, share, model)
    found = [*collect(seeds, settings, options.workers)]
    ends = ", ".join(f"{count} {status}" for status, count in Counter(one.status for one in found).most_common())
    driven = f"{sum(map(len, found))} decisions, {minutes(began_s):.1f} min"
    print(f"round {number}: seeds {seeds.start}:{seeds.stop}, learner {share:.0%}, {ends}, {driven}", flush=True)
    return found


def recorded(
    options: argparse.Namespace, drives: list[Drive], found: Answers, curve: list[float], made_from: str, wall_h: float
) -> Manifest:
    """The manifest with the record of the training; `found` is of the drives of its last round."""
    frames = sum(map(len, drives))
    training = Training(
        command=f"python examples/train_bc.py FOLDER --teacher {options.teacher} --rounds {options.rounds} "
        f"--drives {options.drives} --decisions {options.decisions} --epochs {options.epochs} --seed {options.seed}",
        commit=made_from,
        expert=options.teacher,
        curve=tuple(curve),
        scenarios=tuple(dict.fromkeys((*scenes.ROADS, *scenes.OBSTACLES))),
        weathers=(*scenes.USUAL_WEATHERS, "all others"),
        seeds=f"{options.seed}:{options.seed + len(drives)}",
        frames=frames,
        driven_h=round(frames / MANIFEST.rate_hz / 3600.0, 2),
        wall_h=round(wall_h, 2),
    )
    speeds = np.concatenate([one.states[:, 0] for one in drives]) * SPEED_SCALE_MPS
    known = learned_from([picture for one in drives for picture in one.pictures[::EVERY]], speeds.tolist())
    unsure = Uncertainty(round(float(np.quantile(found.deviations, SURE_SHARE)), 5))
    return replace(MANIFEST, uncertainty=unsure, learned_from=known, training=training)


def minutes(began_s: float) -> float:
    return (perf_counter() - began_s) / 60.0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("out", type=Path, metavar="FOLDER")
    parser.add_argument(
        "--teacher",
        default="expert",
        choices=drivers.names(),
        metavar="DRIVER",
        help="a driver by name, which labels every decision",
    )
    parser.add_argument("--rounds", type=int, default=8, help="of collecting and fitting")
    parser.add_argument("--drives", type=int, default=70, help="of a round; the first has twice as many")
    parser.add_argument("--decisions", type=int, default=400, help="longest drive, at 20 a second")
    parser.add_argument("--epochs", type=int, default=2, help="of a round; the last has three times as many")
    parser.add_argument("--seed", type=int, default=0, help="first of the drives' seeds")
    parser.add_argument("--workers", type=int, default=2, help="processes that drive")
    main(parser.parse_args())
