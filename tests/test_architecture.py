"""The one-way flow: who may import whom, read from the sources without running them."""

import ast
import subprocess
import sys
from collections import defaultdict
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOLDERS = {"vpf_sim": "vpf_sim", "envs": "vpf_sim.envs", "controllers": "vpf_sim.controllers"}
FOLDERS["scenarios"] = "vpf_sim.scenarios"
LEAVES = {
    "types",
    "driver_interface",
    "geometry",
    "errors",
    "braking",
    "seeding",
    "configuration",
    "configuration_faults",
    "configuration_fields",
    "files",
    "system",
    "process_state",
    "pipeline",
    "policy_state",
    "timing",
    "window",
}
MAY_IMPORT = {
    **dict.fromkeys(LEAVES, LEAVES),
    "scenarios": LEAVES,
    "controllers": LEAVES,
    "envs": LEAVES | {"scenarios"},
    "perception": LEAVES,
    "scene": LEAVES | {"perception"},
    "planning": LEAVES | {"perception", "scene"},
    "drivers": LEAVES | {"perception", "scene", "planning", "controllers"},
}
MAY_IMPORT["evaluation"] = MAY_IMPORT["drivers"] | {"drivers", "envs", "scenarios"}
MAY_IMPORT["reporting"] = MAY_IMPORT["evaluation"] | {"evaluation"}
MAY_IMPORT["gallery"] = MAY_IMPORT["reporting"] | {"reporting"}
MAY_IMPORT["machine"] = MAY_IMPORT["evaluation"] | {"evaluation"}
MAY_IMPORT["replay"] = MAY_IMPORT["reporting"] | {"reporting"}
MAY_IMPORT["datasets"] = MAY_IMPORT["reporting"] | {"reporting"}
MAY_IMPORT["api"] = MAY_IMPORT["datasets"] | {"datasets"}
MAY_IMPORT["cli"] = MAY_IMPORT["api"] | {"replay", "gallery", "machine", "api"}
MAY_IMPORT["testing"] = MAY_IMPORT["api"] | {"api"}
PREFIX = "vpf_sim.evaluation."
# The packages of the evaluation: each imports only what is at its left, and the modules beside them.
EVALUATION = ["metrics", "truth", "episode", "sweeps", "analysis", "perception", "gate", "verification"]
# The sub-packages of perception and planning, and which of their neighbours each may import.
SUBPACKAGES: dict[str, dict[str, set[str]]] = {
    "perception": {"egomotion": set(), "road": set(), "obstacles": {"egomotion", "road"}, "paper": {"egomotion"}},
    "perception.obstacles": {"planar_parallax": set(), "moving": set()},
    "planning": {"paper": set(), "spacetime": set(), "variants": set()},
}
MOST_FILES = 16  # in a folder of perception


def modules() -> list[tuple[str, Path]]:
    """(name inside vpf_sim, file) of every source file."""
    found = []
    for folder, package in FOLDERS.items():
        for path in sorted((ROOT / folder).rglob("*.py")):
            parts = [*package.split("."), *path.relative_to(ROOT / folder).with_suffix("").parts]
            found.append((".".join(part for part in parts[1:] if part != "__init__"), path))
    return found


def imported(path: Path) -> set[str]:
    """The parts of vpf_sim that a file imports anywhere, by their first name."""
    return {name.split(".")[1] for name in imported_names(path) if name.startswith("vpf_sim.")}


@cache
def imported_names(path: Path) -> set[str]:
    """All that a file imports anywhere, by full names."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import; write vpf_sim.…"
            names.add(node.module or "")
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def test_a_part_imports_only_what_flows_into_it() -> None:
    assert {name.split(".")[0] for name, _ in modules() if name} <= MAY_IMPORT.keys(), "each module is of a part"
    wrong = {}
    for name, path in modules():
        part = name.split(".")[0]
        if name and (foreign := (imported(path) & MAY_IMPORT.keys()) - MAY_IMPORT[part] - {part}):
            wrong[name] = foreign
    assert wrong == {}


def test_the_packages_of_the_evaluation_are_all_in_its_order() -> None:
    assert set(EVALUATION) == {path.parent.name for path in (ROOT / "vpf_sim" / "evaluation").glob("*/__init__.py")}


def test_a_package_of_the_evaluation_imports_only_those_before_it() -> None:
    wrong = {}
    for name, path in modules():
        if name.startswith("evaluation."):
            package = name.split(".")[1]
            later = EVALUATION[EVALUATION.index(package) + 1 :] if package in EVALUATION else EVALUATION
            late = tuple(f"{PREFIX}{other}." for other in later)
            if found := {full for full in imported_names(path) if late and f"{full}.".startswith(late)}:
                wrong[name] = found
    assert wrong == {}


@pytest.mark.parametrize("package", SUBPACKAGES)
def test_subpackages_are_all_listed(package: str) -> None:
    folder = ROOT / "vpf_sim" / Path(*package.split("."))
    assert set(SUBPACKAGES[package]) == {path.parent.name for path in folder.glob("*/__init__.py")}


@pytest.mark.parametrize("package", SUBPACKAGES)
def test_a_subpackage_imports_only_those_it_may(package: str) -> None:
    for own, allowed in SUBPACKAGES[package].items():
        for name, path in modules():
            if name.startswith(f"{package}.{own}."):
                others = {f"vpf_sim.{package}.{other}." for other in SUBPACKAGES[package].keys() - allowed - {own}}
                wrong = {full for full in imported_names(path) if f"{full}.".startswith(tuple(others))}
                assert not wrong, f"{name} must not import {sorted(wrong)}"


def imports_between_neighbours() -> dict[str, dict[str, set[str]]]:
    """By package: which of the modules and packages directly in it imports which others of them."""
    names = {name for name, _ in modules() if name}
    edges: dict[str, dict[str, set[str]]] = defaultdict(lambda: defaultdict(set))
    for name, path in modules():
        own = name.split(".")
        for full in imported_names(path):
            other = full.removeprefix("vpf_sim.")
            if full == other or other not in names:
                continue  # nothing of ours, or a name inside a module, which is there as well
            target = other.split(".")
            depth = next((i for i, pair in enumerate(zip(own, target, strict=False)) if pair[0] != pair[1]), None)
            if depth is not None:
                edges[".".join(own[:depth])][own[depth]].add(target[depth])
    return edges


def test_neighbours_import_each_other_in_no_circle() -> None:
    circles = {}
    for package, graph in imports_between_neighbours().items():
        try:
            TopologicalSorter(graph).prepare()
        except CycleError as error:
            circles[f"vpf_sim.{package}"] = " <- ".join(error.args[1])
    assert circles == {}


def test_no_folder_of_perception_holds_too_many_files() -> None:
    for init in (ROOT / "vpf_sim" / "perception").rglob("__init__.py"):
        files = [path.name for path in init.parent.glob("*.py") if path != init]
        assert len(files) <= MOST_FILES, f"{init.parent}: {len(files)} files"


def test_importing_the_package_loads_nothing_heavy() -> None:
    heavy = "{'highway_env', 'cv2', 'scipy', 'pandas', 'pygame', 'pydantic'}"
    code = f"import sys, vpf_sim; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
