"""One import name is installed, with all it needs, and lives beside other people's `envs` and `controllers`."""

import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import venv
import zipfile
from email import message_from_bytes
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.version import Version

import vpf_sim

ROOT = Path(__file__).parents[1]
README_PYTHON = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text("utf-8"), re.DOTALL)
USER = """
import vpf_sim

class Own:  # the three members of a driver, without its base class
    privileged = "route"

    def reset(self, setup: vpf_sim.DriverSetup) -> None:
        self.rate_hz = setup.rate_hz

    def act(self, observation: vpf_sim.Observation) -> vpf_sim.Command:
        return vpf_sim.Command(throttle=self.rate_hz * observation.speed_mps, steering=0.0)

run = vpf_sim.sweep(["town04", "random"], driver={"slow": Own(), "fast": Own}, weather="rain", seeds=range(2))
seconds: float = vpf_sim.drive("town04", driver=Own).timing["wall_s"]
page = vpf_sim.report(run, clips=0).page
rig = vpf_sim.Rig(vpf_sim.Camera.of(84, 84, fov_deg=60.0))
"""
WRONG = """
import vpf_sim

vpf_sim.drive("town04", driver=5)
vpf_sim.Command(throttle="full", steering=0.0)
vpf_sim.sweep("town04").tabel
"""
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
MAPPED = PROJECT["tool"]["setuptools"]["package-dir"]
CORE = ROOT / "envs" / "camera" / "core"
BUILT = shutil.ignore_patterns("__pycache__", "*.so", "*.pyd")


def test_packages_are_the_folders_that_exist() -> None:
    found = set()
    for package, folder in MAPPED.items():
        for init in (ROOT / folder).rglob("__init__.py"):
            found.add(".".join([package, *init.parent.relative_to(ROOT / folder).parts]))
    assert set(PROJECT["tool"]["setuptools"]["packages"]) == found


def test_every_folder_with_code_is_a_package() -> None:
    for folder in MAPPED.values():
        for path in (ROOT / folder).rglob("*.py"):
            assert (path.parent / "__init__.py").exists(), f"{path.parent} has no __init__.py"


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the project, so that no build folder is left in the checkout."""
    source = tmp_path_factory.mktemp("source")
    for folder in (*MAPPED.values(), "building", "docs", "scripts", "tests"):
        shutil.copytree(ROOT / folder, source / folder, ignore=BUILT)
    for path in filter(Path.is_file, ROOT.iterdir()):
        shutil.copy(path, source)
    return source


@pytest.fixture(scope="module")
def built(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the project's sdist and wheel."""
    out = tmp_path_factory.mktemp("built")
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(out), str(source)]
    subprocess.run(command, check=True, capture_output=True)
    return out


@pytest.fixture(scope="module")
def wheel(built: Path) -> Path:
    return next(built.glob("*.whl"))


SOURCE_OF_PACKAGE = {"py", "pyi", "toml", "jinja", "onnx", "typed"}
COMPILED = "pyd" if os.name == "nt" else "so"


def test_the_wheel_has_no_tests_and_no_pictures(wheel: Path) -> None:
    names = [name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name]
    assert {name.rpartition(".")[2] for name in names} == SOURCE_OF_PACKAGE | {COMPILED}
    assert not [name for name in names if {"tests", "scripts", "docs"} & set(name.split("/"))]


def test_the_sdist_has_what_a_build_needs_and_no_more(built: Path) -> None:
    with tarfile.open(next(built.glob("*.tar.gz"))) as archive:
        names = {member.name.partition("/")[2] for member in archive.getmembers() if member.isfile()}
    folders = {name.partition("/")[0] for name in names if "/" in name}
    assert folders == {*MAPPED.values(), "building", "vpf_sim.egg-info"}
    assert names >= {"pyproject.toml", "setup.py", "README.md", "LICENSE", "CHANGELOG.md", "CITATION.cff"}
    built_from = [*(ROOT / "building").rglob("*.py"), *(ROOT / "building").rglob("*.h"), *CORE.rglob("*.[ch]")]
    assert names >= {path.relative_to(ROOT).as_posix() for path in built_from}
    inside = {name for name in names if name.partition("/")[0] in MAPPED.values()}
    assert {name.rpartition(".")[2] for name in inside} == SOURCE_OF_PACKAGE | {"c", "h"}


def test_one_wheel_serves_all_versions_of_python(wheel: Path) -> None:
    """Its tag is that of the stable ABI, and so is the name of the one compiled file."""
    assert wheel.name.split("-")[2:4] == ["cp311", "abi3"]
    compiled = [name for name in zipfile.ZipFile(wheel).namelist() if name.endswith((".so", ".pyd"))]
    assert compiled == [f"vpf_sim/envs/camera/core/_core.{'pyd' if os.name == 'nt' else 'abi3.so'}"]


def test_the_citation_is_of_the_last_release_and_of_the_paper() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    released = re.search(r"^## (\S+) - (\S+)$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.M)
    assert released is not None
    assert (citation["version"], citation["date-released"]) == released.groups()
    assert Version(citation["version"]) <= Version(PROJECT["project"]["version"])
    assert citation["license"] == PROJECT["project"]["license"]
    (paper,) = citation["references"]
    assert paper["url"] == PROJECT["project"]["urls"]["Paper"]
    assert [author["family-names"] for author in paper["authors"]] == ["Capito", "Ozguner", "Redmill"]


@pytest.mark.parametrize("path", sorted((ROOT / ".github").rglob("*.yml")), ids=lambda path: path.name)
def test_forms_and_workflows_are_yaml(path: Path) -> None:
    content = yaml.safe_load(path.read_text("utf-8"))
    if "body" in content:
        assert content.keys() >= {"name", "description"}
        assert all(field["attributes"]["label"] for field in content["body"])


def test_each_dependency_is_explained() -> None:
    """The table in CONTRIBUTING.md has each required package and each extra that is not for development."""
    section = (ROOT / "CONTRIBUTING.md").read_text("utf-8").partition("## What is each dependency for?")[2]
    explained = set(re.findall(r"^\| `([\w-]+)`", section.partition("\n## ")[0], re.M))
    extras = PROJECT["project"]["optional-dependencies"]
    asked = PROJECT["project"]["dependencies"] + [one for name, them in extras.items() if name != "dev" for one in them]
    assert explained == {Requirement(one).name for one in asked}


def test_the_development_extra_installs_what_tests_of_other_extras_need() -> None:
    (own,) = [one for one in PROJECT["project"]["optional-dependencies"]["dev"] if one.startswith("vpf_sim[")]
    assert Requirement(own).extras == {"cluster", "export", "onnx", "video"}


def test_the_base_installation_leaves_the_heavy_libraries_out(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        (name,) = [name for name in archive.namelist() if name.endswith(".dist-info/METADATA")]
        asked = message_from_bytes(archive.read(name)).get_all("Requires-Dist") or []
    base = {Requirement(one).name for one in asked if "extra ==" not in one}
    assert "numpy" in base
    assert not base & {"av", "dask", "h5py", "onnxruntime", "pyarrow", "rerun-sdk", "torch"}


def test_the_wheel_has_one_top_level_name_and_all_data(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.split("/")[0] for name in names if ".dist-info" not in name} == {"vpf_sim"}
    for package, folder in MAPPED.items():
        for path in (
            path for suffix in ("jinja", "onnx", "toml", "py") for path in (ROOT / folder).rglob(f"*.{suffix}")
        ):
            inside = "/".join([*package.split("."), *path.relative_to(ROOT / folder).parts])
            assert inside in names
    assert "vpf_sim/py.typed" in names


def installed(environment: Path, *what: str) -> Path:
    """The interpreter of a clean environment; the dependencies are lent to it, so that nothing is downloaded."""
    venv.create(environment, with_pip=False)
    scripts = environment / ("Scripts" if os.name == "nt" else "bin")
    python = scripts / "python"
    site = next(environment.rglob("site-packages"))
    (site / "zz_lent.pth").write_text("\n".join(path for path in sys.path if path.endswith("site-packages")))
    pip = [sys.executable, "-m", "pip", "--python", str(python), "install"]
    subprocess.run([*pip, "--no-deps", "--no-index", "--no-build-isolation", *what], check=True, capture_output=True)
    return python


def test_an_episode_runs_from_the_wheel_in_a_project_with_its_own_envs(wheel: Path, tmp_path: Path) -> None:
    """Outside the checkout."""
    environment = tmp_path / "environment"
    python = installed(environment, str(wheel))
    site = next(environment.glob("lib/python*/site-packages"))

    project = tmp_path / "project"
    for folder in ("envs", "controllers", "scenarios"):
        (project / folder).mkdir(parents=True)
        (project / folder / "__init__.py").write_text("MINE = True\n")
    code = (
        "import envs, controllers, scenarios, vpf_sim, vpf_sim.envs\n"
        "assert envs.MINE and controllers.MINE and scenarios.MINE\n"
        f"assert vpf_sim.envs.__file__.startswith({str(site)!r}), vpf_sim.envs.__file__\n"
    )
    clean = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "VPF_SIM"))}
    subprocess.run([python, "-c", code], cwd=project, env=clean, check=True, capture_output=True)
    (project / "short.toml").write_text(
        "schema = 1\n[road]\nsegments = [{kind = 'line', length_m = 60}]\n[ego]\nlane = 2\ns_m = 10.0\n"
        "[goal]\ns_m = 14.0\n"
    )
    command = [python.parent / "vpf-sim", "drive", "short.toml", "--driver", "pid", "--json", "--out", "run"]
    done = subprocess.run(command, cwd=project, env=clean, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert '"status": "success"' in done.stdout


def mypy(python: Path, folder: Path, **sources: str) -> str:
    """What mypy says of files in strict mode, with the packages of an interpreter."""
    for name, source in sources.items():
        (folder / f"{name}.py").write_text(source)
    files = [f"{name}.py" for name in sources]
    command = [sys.executable, "-m", "mypy", "--strict", "--python-executable", str(python), *files]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False).stdout


@pytest.mark.slow
@pytest.mark.parametrize("how", ["wheel", "editable"])
def test_a_users_types_are_checked_against_ours(
    how: str, source: Path, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    """The README's code and a script pass in strict mode, and wrong calls do not; no name is Any."""
    strict = ("--config-settings", "editable_mode=strict", "--editable", str(source))
    what = strict if how == "editable" else (str(request.getfixturevalue("wheel")),)
    python = installed(tmp_path / "environment", *what)
    good = {f"readme_{number}": code for number, code in enumerate(README_PYTHON)}
    said = mypy(python, tmp_path, user=USER, **good)
    assert said.startswith("Success"), said
    shown = mypy(
        python, tmp_path, shown="import vpf_sim\n" + "".join(f"reveal_type(vpf_sim.{n})\n" for n in vpf_sim.__all__)
    )
    assert shown.count("Revealed type is") == len(vpf_sim.__all__)
    assert 'is "Any"' not in shown
    assert re.findall(r"wrong\.py:(\d+): error", mypy(python, tmp_path, wrong=WRONG)) == ["4", "5", "6"]
