"""What to write in the place of a file or a module that a user gives as a driver."""

import sys
from pathlib import Path

import pytest

from vpf_sim import cli, drivers
from vpf_sim.errors import InputError

SOURCE = """
import vpf_sim
raise_if_run = 1 / 0

class Helper: pass

class Student(vpf_sim.Driver):
    def act(self, observation): return vpf_sim.Command(0.1, 0.0)
"""
FILE, MODULE = "expected package.module:Class, got a file; ", "expected package.module:Class, got a module; "


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder, in which modules are found, too."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])
    for name in ("student_one.py", "inner/student_two.py", "student_pack/__init__.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(SOURCE)
    (tmp_path / "student_two_of_them.py").write_text(SOURCE + SOURCE.replace("Student", "Pupil"))
    (tmp_path / "student_none.py").write_text("class Helper: pass")
    (tmp_path / "student_broken.py").write_text("def (")
    return tmp_path


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("student_one.py:Student", f"{FILE}write student_one:Student"),
        ("student_one.py", f"{FILE}write student_one:Student"),
        ("student_one", f"{MODULE}write student_one:Student"),
        ("./student_one.py:Student", f"{FILE}write student_one:Student"),
        ("student_one.Student", f"{MODULE}write student_one:Student"),
        ("student_one.py::Student", f"{FILE}write student_one:Student"),
        ("inner/student_two.py:Student", f"{FILE}write inner.student_two:Student"),
        ("inner\\student_two.py:Student", f"{FILE}write inner.student_two:Student"),
        ("inner.student_two", f"{MODULE}write inner.student_two:Student"),
        ("student_pack", f"{MODULE}write student_pack:Student"),
        ("student_two_of_them", f"{MODULE}write student_two_of_them:Student or student_two_of_them:Pupil"),
        ("student_two_of_them.py:Pupil", f"{FILE}write student_two_of_them:Pupil"),
        ("student_none.py", f"{FILE}write student_none:CLASS"),
        ("student_broken.py:Mine", f"{FILE}write student_broken:Mine"),
        ("student_far.py:Student", "expected package.module:Class, got a file that was not found"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_message_says_what_to_write(name: str, message: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(InputError) as caught:
        drivers.create(name)
    assert str(caught.value) == f"driver '{name}': {message}"
    assert cli.run(["drive", "straight", "--driver", name]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_folder_without_the_module_is_named(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "elsewhere").mkdir()
    monkeypatch.chdir(folder / "elsewhere")
    monkeypatch.setattr(sys, "path", [entry for entry in sys.path if entry != str(folder)])
    for name in ("../student_one.py:Student", f"{folder}/student_one.py:Student"):
        with pytest.raises(InputError, match=rf"; write student_one:Student, with {folder} in PYTHONPATH$"):
            drivers.create(name)


@pytest.mark.parametrize("name", ["numpy", "json.decoder", "json.decoder.JSONDecoder", "vpff"])
def test_modules_of_libraries_are_unknown_drivers(name: str) -> None:
    with pytest.raises(InputError, match=rf"^unknown driver '{name}': "):
        drivers.create(name)
