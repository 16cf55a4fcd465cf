"""The pytest plugin, in projects of its own: drivers found, episodes told, and no cost where it is not used."""

import tomllib
from importlib import import_module
from pathlib import Path

import pytest
from short_scenario import write_short

pytest_plugins = ["pytester"]
PLUGIN = ("-p", "vpf_sim.testing", "-p", "no:cacheprovider")
DRIVER = """
from vpf_sim import Command

class Straight:
    privileged, uses_images = "none", False
    def reset(self, setup): pass
    def act(self, observation): return Command(0.2, 0.0)

class Lost(Straight):
    def act(self, observation): raise KeyError("no such road")
"""
TESTS = """
import cv2

def test_good(drive):
    threads = cv2.getNumThreads()
    record = drive("short.toml", driver="my_driver:Straight", weather="clear", seed=3)
    assert record["status"] == "success"
    assert (record["driver"], record["seed"]) == ("my_driver:Straight", 3)
    assert cv2.getNumThreads() == threads

def test_lost(drive):
    assert drive("short.toml", driver="my_driver:Lost", weather="rain", seed=7)["status"] == "success"

def test_misspelt(drive):
    drive("shrot", driver="my_driver:Straight")
"""


def test_a_projects_own_driver(pytester: pytest.Pytester) -> None:
    write_short(pytester.path)
    pytester.makepyfile(my_driver=DRIVER)
    (pytester.mkdir("tests") / "test_driver.py").write_text(TESTS)
    done = pytester.runpytest_subprocess(*PLUGIN, "tests")
    done.assert_outcomes(passed=1, failed=2)
    done.stdout.fnmatch_lines(
        [
            "*KeyError: 'no such road'*",
            "error; again: vpf-sim drive short.toml --weather rain --driver my_driver:Lost --seed 7",
            "*vpf_sim.errors.InputError: unknown scenario 'shrot': known: blocked*",
        ]
    )


def test_fixtures_of_any_scope_drive(pytester: pytest.Pytester) -> None:
    write_short(pytester.path, goal_m=6.0)
    pytester.makepyfile(my_driver=DRIVER)
    scopes = ("function", "class", "module", "package", "session")
    pytester.makeconftest(
        "import pytest\n"
        + "".join(
            f'@pytest.fixture(scope="{scope}")\n'
            f'def of_{scope}(drive): return drive("short.toml", driver="my_driver:Straight", seed=3)\n'
            for scope in scopes
        )
    )
    pytester.makepyfile(
        "".join(
            f"def test_{scope}(of_{scope}, drive):\n"
            f'    assert of_{scope} == drive("short.toml", driver="my_driver:Straight", seed=3)\n'
            for scope in scopes
        )
    )
    pytester.runpytest_subprocess(*PLUGIN).assert_outcomes(passed=len(scopes))


def test_where_nobody_drives_nothing_is_loaded(pytester: pytest.Pytester) -> None:
    heavy = {"highway_env", "cv2", "scipy", "pandas", "duckdb", "pygame", "av", "pydantic", "vpf_sim.evaluation"}
    pytester.makepyfile(f"""
        import sys

        def test_nothing(pytestconfig):
            assert pytestconfig.pluginmanager.has_plugin("vpf_sim.testing")
            assert not {heavy} & set(sys.modules)
    """)
    pytester.runpytest_subprocess(*PLUGIN).assert_outcomes(passed=1)


def test_pytest_finds_it_by_its_entry_point() -> None:
    project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]
    (path,) = project["entry-points"]["pytest11"].values()
    assert hasattr(import_module(path), "drive")
