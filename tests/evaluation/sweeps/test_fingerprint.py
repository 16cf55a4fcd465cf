"""The fingerprint: any edit of the code changes it."""

import re
import tomllib
from pathlib import Path

import pytest

from vpf_sim.evaluation.sweeps import fingerprint as module
from vpf_sim.evaluation.sweeps.fingerprint import PACKAGES, fingerprint, hash_of_files, own_code, source

ROOT = Path(__file__).parents[3]


@pytest.fixture
def code(tmp_path: Path) -> dict[str, Path]:
    """A package with one folder inside it and one beside."""
    for name in ("package/__init__.py", "package/inside/a.py", "package/inside/gains.toml", "beside/b.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(f"# {name}\n")
    return {"package": tmp_path / "package", "package/beside": tmp_path / "beside"}


@pytest.mark.parametrize("name", ["package/inside/a.py", "package/inside/gains.toml", "beside/b.py"])
def test_an_edit_changes_the_hash(code: dict[str, Path], tmp_path: Path, name: str) -> None:
    before = hash_of_files(code)
    assert hash_of_files(code) == before
    (tmp_path / name).write_text("# edited\n")
    assert hash_of_files(code) != before


def test_a_new_name_and_a_new_file_change_the_hash(code: dict[str, Path], tmp_path: Path) -> None:
    hashes = {hash_of_files(code)}
    (tmp_path / "beside" / "b.py").rename(tmp_path / "beside" / "c.py")
    hashes.add(hash_of_files(code))
    (tmp_path / "package" / "new.py").write_text("")
    hashes.add(hash_of_files(code))
    assert len(hashes) == 3


def test_other_files_do_not_change_the_hash(code: dict[str, Path], tmp_path: Path) -> None:
    before = hash_of_files(code)
    (tmp_path / "package" / "__pycache__").mkdir()
    (tmp_path / "package" / "__pycache__" / "a.cpython-311.pyc").write_bytes(b"3")
    assert hash_of_files(code) == before


def test_a_checkout_and_an_installed_package_have_the_same_hash(code: dict[str, Path], tmp_path: Path) -> None:
    before = hash_of_files(code)
    (tmp_path / "beside").rename(tmp_path / "package" / "beside")
    installed = {"package": tmp_path / "package", "package/beside": tmp_path / "package" / "beside"}
    assert hash_of_files(installed) == before


def test_all_packages_are_in_the_fingerprint(monkeypatch: pytest.MonkeyPatch) -> None:
    mapped = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["package-dir"]
    assert set(PACKAGES) == set(mapped)
    hashed: dict[str, Path] = {}
    monkeypatch.setattr(module, "hash_of_files", lambda folders: hashed.update(folders) or "")
    source.__wrapped__()
    assert {name.replace("/", ".") for name in hashed} == set(mapped)
    assert all((folder / "__init__.py").exists() for folder in hashed.values())


def test_the_hash_is_in_the_fingerprint() -> None:
    assert fingerprint()["source"] == source()
    assert re.fullmatch("[0-9a-f]{64}", source())


def test_a_users_own_driver_is_hashed_with_its_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "hashed_package").mkdir()
    for name in ("__init__.py", "driver.py", "gains.toml"):
        (tmp_path / "hashed_package" / name).write_text("")
    (tmp_path / "hashed_module.py").write_text("")
    names = ("hashed_package.driver:Mine", "hashed_module:Mine")
    before = [own_code(name) for name in names]
    (tmp_path / "hashed_package" / "gains.toml").write_text("gain = 2.0")
    (tmp_path / "hashed_module.py").write_text("# edited")
    assert [own_code(name) for name in names] == before, "this process may have loaded them as they were"
    module._code_of.cache_clear()
    after = [own_code(name) for name in names]
    assert all(one not in (None, other) for one, other in zip(after, before, strict=True))


def test_a_variants_file_is_hashed_and_a_registered_driver_is_in_the_source(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('base = "paper"\n')
    before = own_code(f"vpf@{path}")
    path.write_text('base = "robust"\n')
    assert own_code(f"vpf@{path}") not in (None, before)
    assert own_code("vpf") is None
