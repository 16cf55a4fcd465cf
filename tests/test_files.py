"""Names that fit every system, and files that are whole or not there; no other place of the project opens one."""

import ast
import errno
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from little_room import limited
from systems import POSIX_ONLY

from vpf_sim.evaluation.gate.checks import Check
from vpf_sim.evaluation.gate.run_cells import Cell
from vpf_sim.evaluation.job import Job
from vpf_sim.evaluation.steps import Step, StepTable
from vpf_sim.evaluation.steps import write as write_steps
from vpf_sim.evaluation.sweeps.run_folder import JsonLines, write_json
from vpf_sim.files import file_name, replacing, write_text
from vpf_sim.reporting.check_files import write_junit
from vpf_sim.reporting.video import Writer

ROOT = Path(__file__).parents[1]
ROOM = 200  # bytes
ODD = [
    *("", " ", ".", "..", "../outside", "../../outside", "/etc/passwd", "town/north", "a\\b", "C:\\drive", "c:drive"),
    *("commute 08:30", "what?", "*", 'say "hi"', "it's", "a|b", "<b>", "a\nb", "a\rb", "a\tb", "\0", "\x1b[31m", "%41"),
    *(".hidden", "-rf", "--out", "~", "$HOME", "`id`", "$(id)", "a;b", "a&b", "end.", "end ", "a  b", "#1", "a.b"),
    *("con", "CON", "nul", "Aux", "prn", "com1", "LPT9", "com¹", "x" * 300, "ä" * 100, "通" * 100, "\udcff", "e\u0301"),
]
PLAIN = [
    "town04",
    "HardRainNoon",
    "vpf-paper",
    "vpf@flow",
    "home to work",
    "2011_09_26_drive_0001_sync",
    "Köln",
    "通勤",
]
RESERVED = {"con", "prn", "aux", "nul", *(f"{port}{number}" for port in ("com", "lpt") for number in range(10))}


@pytest.mark.parametrize("text", [*ODD, *PLAIN])
def test_any_text_becomes_a_name_that_every_system_takes(text: str) -> None:
    name = file_name(text)
    assert name.isprintable()
    assert not set(name) & set('/\\:*?"<>|\0')
    assert name.strip(" .") == name
    assert not name.startswith("-")
    assert name.casefold() not in RESERVED
    assert 0 < len(name.encode()) <= 80


@pytest.mark.parametrize("text", PLAIN)
def test_a_plain_name_stays_as_it_is(text: str) -> None:
    assert file_name(text) == text


def test_different_texts_have_different_names() -> None:
    texts = {*ODD, *PLAIN, *(f"{'x' * 300}{number}" for number in range(20)), *(f"a{char}b" for char in ':?*"<>|/\\')}
    assert len({file_name(text) for text in texts}) == len(texts)
    by_case = {text.casefold(): text for text in texts}
    assert len({file_name(text).casefold() for text in by_case.values()}) == len(by_case)


@pytest.mark.parametrize("text", ["../x.toml", "/tmp/a b/x.toml", "x?.toml", "pkg.module:Class", "vpf@/tmp/mine.toml"])
def test_an_episodes_id_is_one_name_whatever_its_parts_are(text: str) -> None:
    job = Job(text, text, text, 3)
    assert not set(job.id) & set('/\\:*?"<>|\n')
    assert job.id.count(".") == 3
    assert len(job.id) < 240


def film(path: Path) -> None:
    noise = np.random.default_rng(0).integers(0, 255, (48, 64, 3), dtype=np.uint8)
    with Writer(path, (64, 48), 10.0) as writer:
        for _ in range(5):
            writer.write(noise)


def lines(path: Path) -> None:
    rows = JsonLines(path)
    try:
        rows.rewrite([{"row": "x" * ROOM}])
    finally:
        rows.close()


def junit(path: Path) -> None:
    write_junit([Check(Cell("town04", "clear", "vpf"), "a", "b" * ROOM, "failed")], path)


WRITERS: dict[str, Callable[[Path], None]] = {
    "film.mp4": film,
    "steps.parquet": lambda path: write_steps(StepTable(np.ones((50, len(Step._fields)))), path),
    "junit.xml": junit,
    "episodes.jsonl": lines,
    "summary.json": lambda path: write_json(path, {"x": "y" * ROOM}),
    "report.html": lambda path: write_text(path, "x" * 2 * ROOM),
}


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("room", [0, ROOM])
def test_a_disk_without_room_leaves_the_former_file(name: str, room: int, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text("the former one\n")
    with limited(room), pytest.raises(OSError, match="File too large") as caught:
        WRITERS[name](path)
    assert caught.value.filename == str(path)
    assert path.read_text() == "the former one\n"
    assert list(tmp_path.iterdir()) == [path], "no draft is left"
    WRITERS[name](path)
    assert path.stat().st_size > ROOM
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("fault", [KeyboardInterrupt, ValueError])
def test_what_goes_wrong_on_the_way_leaves_the_former_file(fault: type[BaseException], tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    path.write_text("the former one")

    def half_a_file() -> None:
        with replacing(path) as draft:
            draft.write_text("half")
            raise fault

    def half_a_film() -> None:
        with Writer(path, (64, 48), 10.0) as writer:
            writer.write(np.zeros((48, 64, 3), np.uint8))
            raise fault

    for begin in (half_a_file, half_a_film):
        with pytest.raises(fault):
            begin()
    assert path.read_text() == "the former one"
    assert list(tmp_path.iterdir()) == [path]


def test_the_fault_of_another_file_keeps_its_name(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as caught, replacing(tmp_path / "a"):
        (tmp_path / "other").read_text()
    assert caught.value.filename == str(tmp_path / "other")


@POSIX_ONLY
def test_a_link_goes_on_leading_to_the_file(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "file").write_text("before")
    (tmp_path / "link").symlink_to(tmp_path / "there" / "file")
    write_text(tmp_path / "link", "after")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "there" / "file").read_text() == "after"


@POSIX_ONLY
def test_a_device_is_written_as_it_is() -> None:
    write_text(Path("/dev/null"), "nobody reads this")
    assert Path("/dev/null").is_char_device()
    with pytest.raises(OSError, match="No space left on device") as caught:
        write_text(Path("/dev/full"), "x")
    assert (caught.value.errno, caught.value.filename) == (errno.ENOSPC, "/dev/full")


def test_a_folder_is_refused_before_any_work(tmp_path: Path) -> None:
    with pytest.raises(IsADirectoryError), replacing(tmp_path):
        pytest.fail("it was begun")


# Calls that write a file, by the file of ours that may have them: each hands a draft to a library, or appends lines.
ALLOWED = {
    "vpf_sim/files.py": {"open", "write_bytes", "replace", "rename"},
    "vpf_sim/evaluation/sweeps/run_folder.py": {"os.open"},  # appended to, and cut back where there is no room
    "vpf_sim/evaluation/pool.py": {"mkstemp", "os.open"},  # a worker's log, appended to by its watchdog
    "vpf_sim/cli/output.py": {"os.open"},  # the null device
    "vpf_sim/evaluation/parquet.py": {"write_parquet"},
    "vpf_sim/datasets/lerobot.py": {"write_table", "to_parquet"},
    "vpf_sim/reporting/paper_page.py": {"savefig"},  # into memory
    "vpf_sim/reporting/video.py": {"open"},
    "vpf_sim/reporting/viewers.py": {"save"},
}
WRITING = {"write_bytes", "imwrite", "VideoWriter", "savez", "savez_compressed", "savetxt", "to_csv", "to_parquet"}
WRITING |= {
    "to_json",
    "to_excel",
    "write_parquet",
    "write_table",
    "savefig",
    "copyfile",
    "copy2",
    "copytree",
    "move",
    "rename",
    "mkstemp",
}
WRITING |= {"NamedTemporaryFile", "FileHandler", "save", "symlink_to", "write_html"}


def writes(call: ast.Call) -> str | None:
    """How this call writes a file, if it does."""
    owner = ast.unparse(call.func.value) if isinstance(call.func, ast.Attribute) else ""
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    texts = [arg.value for arg in [*call.args, *(k.value for k in call.keywords)] if isinstance(arg, ast.Constant)]
    if name == "open":
        modes = [text for text in texts if isinstance(text, str) and set(text) <= set("rwxabt+") and text]
        return "os.open" if owner == "os" else name if any(set(mode) & set("wxa+") for mode in modes) else None
    if name == "write_text":  # that of Path: ours takes the path first, and has no owner
        return name if owner else None
    if name == "move":  # that of shutil, not of a road
        return name if owner in ("shutil", "") else None
    if name == "write_bytes":
        return name if owner else None
    if name == "replace" and owner not in ("dataclasses",):  # Path.replace and os.replace; that of str takes two
        count = len(call.args) + len(call.keywords)
        return name if (owner == "os" or (owner and count == 1)) else None
    return name if name in WRITING else None


SOURCES = [path for folder in ("vpf_sim", "envs", "controllers", "scenarios") for path in (ROOT / folder).rglob("*.py")]


def test_no_other_place_writes_a_file() -> None:
    wrong = {}
    for path in SOURCES:
        calls = [node for node in ast.walk(ast.parse(path.read_text("utf-8"))) if isinstance(node, ast.Call)]
        name = path.relative_to(ROOT).as_posix()
        if found := {how for call in calls if (how := writes(call))} - ALLOWED.get(name, set()):
            wrong[name] = found
    assert wrong == {}, "write it by vpf_sim.files"


@pytest.mark.parametrize(
    "code",
    [
        "open(path, 'w')",
        "path.open('ab')",
        "path.open(mode='x')",
        "path.write_text('x')",
        "path.write_bytes(b'')",
        "draft.replace(path)",
        "os.replace(a, b)",
        "cv2.imwrite(path, image)",
        "table.to_csv(path)",
        "av.open(path, 'w', format='mp4')",
    ],
)
def test_the_search_finds_what_writes(code: str) -> None:
    (call,) = [node for node in ast.walk(ast.parse(code)) if isinstance(node, ast.Call)]
    assert writes(call)
