"""One import name is installed, with all it needs, and lives beside other people's `envs` and `controllers`."""

import os
import subprocess
import sys
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
MAPPED = PROJECT["tool"]["setuptools"]["package-dir"]


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
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The project's wheel, built from a copy, so that no build folder is left in the checkout."""
    source = tmp_path_factory.mktemp("source")
    for name in ["pyproject.toml", "README.md", "LICENSE", *MAPPED.values()]:
        (source / name).symlink_to(ROOT / name)
    out = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(out), str(source)]
    subprocess.run(command, check=True, capture_output=True)
    return next(out.glob("*.whl"))


def test_the_wheel_has_one_top_level_name_and_all_data(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.split("/")[0] for name in names if ".dist-info" not in name} == {"vpf_sim"}
    for package, folder in MAPPED.items():
        for path in (path for suffix in ("jinja", "toml", "py") for path in (ROOT / folder).rglob(f"*.{suffix}")):
            inside = "/".join([*package.split("."), *path.relative_to(ROOT / folder).parts])
            assert inside in names
    assert "vpf_sim/py.typed" in names


def test_an_episode_runs_from_the_wheel_in_a_project_with_its_own_envs(wheel: Path, tmp_path: Path) -> None:
    """A clean environment outside the checkout; the dependencies are lent to it, so that nothing is downloaded."""
    environment = tmp_path / "environment"
    venv.create(environment, with_pip=False)
    python = environment / "bin" / "python"
    install = [sys.executable, "-m", "pip", "--python", str(python), "install", "--no-deps", "--no-index", str(wheel)]
    subprocess.run(install, check=True, capture_output=True)
    site = next(environment.glob("lib/python*/site-packages"))
    (site / "zz_lent.pth").write_text("\n".join(path for path in sys.path if path.endswith("site-packages")))

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
    command = [environment / "bin" / "vpf-sim", "drive", "short.toml", "--driver", "pid", "--json", "--out", "run"]
    done = subprocess.run(command, cwd=project, env=clean, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert '"status": "success"' in done.stdout
