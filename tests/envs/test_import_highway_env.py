"""highway-env without the imports that a drive does not need, and whole where they are used."""

import subprocess
import sys

DRIVE = "import sys, vpf_sim; vpf_sim.drive; print(*sorted({'matplotlib', 'pandas'} & set(sys.modules)))"
TABLE = """
import vpf_sim.envs
import gymnasium, pandas
table, _ = gymnasium.make("highway-v0").reset(seed=0)  # made by pandas
print(table.shape, isinstance(pandas.DataFrame(table), pandas.DataFrame))
"""
PLOTS = """
import matplotlib
matplotlib.use("agg")
import vpf_sim.envs
from highway_env.vehicle import dynamics
import matplotlib.pyplot
print(dynamics.plt.subplots is matplotlib.pyplot.subplots)
"""


def printed_by(code: str) -> str:
    run = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, timeout=120)
    return run.stdout.strip()


def test_a_drive_begins_without_pandas_and_matplotlib() -> None:
    assert printed_by(DRIVE) == ""


def test_highway_env_still_makes_its_tables() -> None:
    assert printed_by(TABLE) == "(5, 5) True"


def test_highway_env_still_plots() -> None:
    assert printed_by(PLOTS) == "True"
