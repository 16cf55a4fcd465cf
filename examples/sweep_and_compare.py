"""Sweep three drivers over two roads and three seeds, compare them on the same seeds, and write the run as a page.

`pid` and `stanley` are baselines that know the route. `slow` is our own driver: Stanley's law, with a new command only
once a second. None of them uses frames, so this takes seconds. Prints

    curve-left  pid      arrives 100%
    curve-left  slow     arrives   0%
    curve-left  stanley  arrives 100%
    curve-right pid      arrives 100%
    curve-right slow     arrives   0%
    curve-right stanley  arrives 100%
    path MSE on curve-left, stanley minus pid: -0.0087 m2 (95 % interval -0.0089 to -0.0084)

python sweep_and_compare.py [FOLDER] stores the run in FOLDER/run, otherwise in a temporary folder.
"""

import sys
import tempfile
from pathlib import Path

import vpf_sim
from vpf_sim.drivers import RouteDriver


class Slow(RouteDriver):
    """Stanley's law with a new command every second."""

    def __init__(self) -> None:
        super().__init__("stanley")

    def reset(self, setup: vpf_sim.DriverSetup) -> None:
        super().reset(setup)
        self.next_s = 0.0

    def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:
        command = super().act(observation)
        if observation.time_s >= self.next_s:
            self.next_s, self.held = observation.time_s + 1.0, command
        return self.held


def main(folder: Path) -> None:
    drivers = {"slow": Slow, "pid": "pid", "stanley": "stanley"}
    run = vpf_sim.sweep(["curve-left", "curve-right"], driver=drivers, seeds="0:3", out=folder / "run", progress=False)
    for row in run.table.to_dict("records"):
        print(f"{row['scenario']:11} {row['driver']:8} arrives {row['success_rate']:4.0%}")
    pairs = run.comparisons.query("scenario == 'curve-left' and driver == 'stanley' and minus == 'pid'")
    difference, (low, high) = pairs.iloc[0][["path_mse_m2.difference", "path_mse_m2.interval"]]
    print(f"path MSE on curve-left, stanley minus pid: {difference:.4f} m2 (95 % interval {low:.4f} to {high:.4f})")
    vpf_sim.report(run, clips=0)
    if sys.argv[1:]:  # otherwise the folder is about to go
        print(f"page: {run.path / 'report.html'}")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as temporary:
        main(Path(sys.argv[1] if sys.argv[1:] else temporary))
