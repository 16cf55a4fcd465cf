"""Compare two drivers on the same roads and seeds, and look at a drive that failed.

`stanley` is a baseline that knows the route. `slow` is our own: the same law, with a new command only once a second.
Neither uses frames, so this takes seconds. Prints

    curve-left  slow     arrives   0%
    curve-left  stanley  arrives 100%
    curve-right slow     arrives   0%
    curve-right stanley  arrives 100%
    success on curve-left, stanley minus slow: 1.00 (95 % interval -0.10 to 1.00)
"""

# %% A driver of our own
import tempfile

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


# %% A sweep
# Each driver drives each road with each seed. The run folder has records, steps and, later, the report.
drivers = {"stanley": "stanley", "slow": Slow}
folder = f"{tempfile.mkdtemp()}/run"
run = vpf_sim.sweep(["curve-left", "curve-right"], driver=drivers, seeds="0:3", out=folder, progress=False)
for row in run.table.to_dict("records"):
    print(f"{row['scenario']:11} {row['driver']:8} arrives {row['success_rate']:4.0%}")

# %% The difference, with its interval
# Both drove the same seeds, so they are compared in pairs.
pairs = run.comparisons.query("scenario == 'curve-left' and of == 'driver'").iloc[0]
low, high = pairs["success_rate.interval"]
print(
    f"success on {pairs['scenario']}, {pairs['driver']} minus {pairs['minus']}: {pairs['success_rate.difference']:.2f} "
    f"(95 % interval {low:.2f} to {high:.2f})"
)

# %% A drive that failed
# `vpf_sim.report(run)` writes all of it as a page, with videos.
failed = run.records.query("driver == 'slow'").iloc[0]
run.episode(failed["id"]).plot()
