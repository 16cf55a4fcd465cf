"""highway-env without the imports that a drive does not need, and whole where they are used."""

import subprocess
import sys

import pytest

DRIVE = """
import sys, vpf_sim
assert vpf_sim.drive("straight", driver="pid").status == "success"
print(*sorted({"matplotlib", "pandas"} & set(sys.modules)))
"""
TABLE = """
import sys, vpf_sim.envs.four_lane
assert "pandas" not in sys.modules
import gymnasium
table, _ = gymnasium.make("highway-v0").reset(seed=0)  # made by pandas
print(table.shape, hasattr(sys.modules["pandas"], "DataFrame"))
"""
PLOTS = """
import vpf_sim.envs.four_lane
from highway_env.vehicle import dynamics
plot = dynamics.plt.subplots
import matplotlib.pyplot
print(plot is matplotlib.pyplot.subplots)
"""
USED_AT_ONCE = """
import sys
from types import ModuleType
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == "highway_env.vehicle.dynamics":
            import pandas
            print(pandas.DataFrame.__name__)
sys.meta_path.insert(0, Finder())
import vpf_sim.envs.four_lane, pandas
print(type(pandas) is ModuleType and "matplotlib" not in sys.modules)
"""


@pytest.mark.parametrize(
    ("code", "printed"),
    [
        pytest.param(DRIVE, [], id="a drive imports neither"),
        pytest.param(TABLE, ["(5,", "5)", "True"], id="a table of highway-env"),
        pytest.param(PLOTS, ["True"], id="a plot of highway-env"),
        pytest.param(USED_AT_ONCE, ["DataFrame", "True"], id="used while highway-env is imported"),
    ],
)
def test_they_are_imported_where_they_are_used(code: str, printed: list[str]) -> None:
    run = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, timeout=120)
    assert run.stdout.split() == printed
