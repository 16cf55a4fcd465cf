"""Properties of every input that a user writes: what is valid is read as it was written, what is not is one clear line.

Whatever is lost, doubled, renamed, mistyped, huge or torn, the answer is a result or an InputError: no other exception,
no warning, no hang, no file. Fifty examples each, and a thousand in the slow tests.
"""

import tomllib
import warnings
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import mutations
import numpy as np
import pytest
import recorded_layouts as layouts
from examples_of import MANY, check
from hypothesis import strategies as st
from malformed import RULES, SCENARIO, SWEEP, WEATHER
from systems import at_most

from vpf_sim import scenarios
from vpf_sim.envs.camera import weather
from vpf_sim.errors import InputError
from vpf_sim.evaluation.gate import rules
from vpf_sim.evaluation.sweeps.plan import make_plan, read_plan
from vpf_sim.planning import variant
from vpf_sim.replay import drive_file, plausible, readers
from vpf_sim.replay.recording import Recording

LONGEST_CPU_S = 20
LONGEST_LINE, MOST_LINES = 1000, 40
RANDOM_SCENARIO = "schema = 1\n[random]\nlength_m = [200.0, 250.0]\nrows = [1, 3]\n"
VARIANT = (
    'base = "robust"\n[flow]\npoints = 200\nwindow_px = 11\n'
    "[crossing]\nfarthest_m = 20.0\nleast_points = 4\n"
    "[scene.unseen]\npatience_s = 1.5\n"
)


def outcome(read: Callable[[], Any], folder: Path, most_lines: int = 1) -> Any:
    """What is read, or None where it is refused in clear lines; nothing is written either way."""
    before = sorted(folder.rglob("*"))
    result, refused = None, ""
    try:
        with at_most(LONGEST_CPU_S, computing=True), warnings.catch_warnings():
            warnings.simplefilter("error")
            result = read()
    except InputError as error:
        refused = str(error)
    assert sorted(folder.rglob("*")) == before
    if result is None:
        lines = refused.split("\n")
        assert len(lines) <= most_lines, refused
        assert all(line.isprintable() and 0 < len(line) < LONGEST_LINE for line in lines), repr(refused)
    return result


@dataclass(frozen=True)
class Kind:
    """A kind of file: a valid one, what reads it, and what writes it anew."""

    text: str
    read: Callable[[Path], Any]
    written: Callable[[Any], dict[str, Any]]


def without_none(value: Any) -> Any:
    """Keys that are left out stand for None."""
    if isinstance(value, dict):
        return {key: without_none(inner) for key, inner in value.items() if inner is not None}
    return [without_none(inner) for inner in value] if isinstance(value, list | tuple) else value


def with_none(value: Any) -> Any:
    """A variant says "none" for it."""
    if isinstance(value, dict):
        return {key: with_none(inner) for key, inner in value.items()}
    return "none" if value is None else value


KINDS = {
    "drive": Kind(layouts.DRIVE_TOML, drive_file.load, lambda one: without_none(asdict(one))),
    "scenario": Kind(
        SCENARIO, lambda path: scenarios.load(str(path)), lambda one: without_none(one.model_dump(by_alias=True))
    ),
    "random scenario": Kind(
        RANDOM_SCENARIO, lambda path: scenarios.load(str(path)), lambda one: without_none(one.model_dump(by_alias=True))
    ),
    "weather": Kind(WEATHER, lambda path: weather.load(str(path)), lambda one: without_none(one.model_dump())),
    "sweep": Kind(
        SWEEP,
        lambda path: make_plan(read_plan(path), str(path)),
        lambda one: {key: value for key, value in asdict(one).items() if key != "drives"},
    ),
    "rules": Kind(RULES, rules.read_rules, lambda found: {"rules": [without_none(asdict(one)) for one in found]}),
    "variant": Kind(VARIANT, lambda path: variant.load(str(path)), lambda one: with_none(asdict(one))),
}


@pytest.mark.parametrize("examples", MANY)
@pytest.mark.parametrize("name", KINDS)
def test_a_file_is_read_unchanged_or_refused(name: str, examples: int, tmp_path: Path) -> None:
    kind, path = KINDS[name], tmp_path / "file.toml"
    path.write_text(kind.text)
    assert outcome(lambda: kind.read(path), tmp_path) is not None

    def holds(content: bytes) -> None:
        path.write_bytes(content)
        found = outcome(lambda: kind.read(path), tmp_path, MOST_LINES)
        if found is not None:
            path.write_text(mutations.toml(kind.written(found)))
            assert kind.read(path) == found

    check(examples, mutations.spoiled_table(tomllib.loads(kind.text)), holds)


DRIVE = {
    "schema": 1,
    "frames": "frames",
    "rate_hz": 20.0,
    "camera": {"field_of_view_deg": 70.0, "height_m": 1.4, "pitch_deg": 1.0, "yaw_deg": 0.0, "roll_deg": 0.0},
    "vehicle": {"wheelbase_m": 2.7, "steering_ratio": 15.0},
    "signals": {"offset_s": 0.0, "left_is_positive": ["steering"], "columns": {"speed_kmh": "v"}},
}
FRAMES = 6
NUMPY_HEAD = 128  # bytes


def rows() -> mutations.Rows:
    """A table of all kinds of signals, 20 rows a second, at 8 m/s in a bend of 80 m."""
    header = "time_s,v,yaw_rate_degps,steering_wheel_deg,acceleration_mps2,x_m,y_m,yaw_deg,obstacle,lead_gap_m,note"
    table = [header.split(",")]
    for k in range(FRAMES + 2):
        time = 0.05 * k
        yaw = 0.1 * time
        place = f"{80.0 * np.sin(yaw):.4f},{80.0 * (1.0 - np.cos(yaw)):.4f},{np.degrees(yaw):.4f}"
        table.append(f"{time:.2f},28.8,5.7296,-29.0,0.0,{place},0,30.0,x".split(","))
    return table


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A drive of a few small pictures."""
    layouts.pictures(tmp_path / "frames", [f"{k}.png" for k in range(FRAMES)], 64, 48)
    (tmp_path / "drive.toml").write_text(mutations.toml(DRIVE))
    (tmp_path / "signals.csv").write_text(mutations.csv(rows()))
    return tmp_path


def assert_possible(recording: Recording) -> None:
    """What a driver is shown is known at every frame, and a car can have it."""
    count = len(recording)
    assert (np.diff(recording.times_s) > 0.0).all()
    for name in ("speed_mps", "yaw_rate_radps"):
        limit, values = plausible.LIMITS[name], getattr(recording, name)
        assert values.shape == (count,)
        assert ((values >= limit.lowest) & (values <= limit.highest)).all(), name
    for name in ("steering_rad", "throttle", "obstacle", "lead_gap_m"):
        limit, values = plausible.LIMITS[name], getattr(recording, name)
        assert (np.isnan(values) | ((values >= limit.lowest) & (values <= limit.highest))).all(), name
    assert recording.poses.shape == (count, 3)
    assert np.isfinite(recording.poses).all()
    frames = list(recording.frames()) if not recording.no_images else []
    shape = (recording.camera.height_px, recording.camera.width_px, 3)
    assert all(frame.image is None or frame.image.shape == shape for frame in frames)
    assert all(note.isprintable() for note in recording.notes)


def assert_read_or_refused(folder: Path) -> None:
    """The recording with its frames."""

    def read() -> Recording:
        recording = readers.read(folder)
        assert_possible(recording)
        return recording

    outcome(read, folder, MOST_LINES)


@pytest.mark.parametrize("examples", MANY)
def test_a_mutated_signal_table_is_a_valid_recording_or_refused(folder: Path, examples: int) -> None:
    def holds(content: bytes) -> None:
        (folder / "signals.csv").write_bytes(content)
        assert_read_or_refused(folder)

    check(examples, mutations.spoiled_rows(rows()), holds)


@pytest.mark.parametrize("examples", MANY)
def test_a_mutated_drive_toml_is_a_valid_recording_or_refused(folder: Path, examples: int) -> None:
    def holds(content: bytes) -> None:
        (folder / "drive.toml").write_bytes(content)
        assert_read_or_refused(folder)

    check(examples, mutations.spoiled_table(DRIVE), holds)


@st.composite
def dress(draw: st.DrawFn) -> bytes:
    """The same table as loggers of other makes and lands would write it."""
    order = draw(st.permutations(range(len(rows()[0]))))
    table = [[row[k] for k in order] for row in rows()]
    delimiter = draw(st.sampled_from([",", ";", "\t"]))
    if delimiter != "," and draw(st.booleans()):
        table = [table[0], *([cell.replace(".", ",") for cell in row] for row in table[1:])]
    if draw(st.booleans()):
        table = [[f'"{cell}"' for cell in row] for row in table]
    space = draw(st.sampled_from(["", " "]))
    text = draw(st.sampled_from(["\n", "\r\n"])).join((delimiter + space).join(row) for row in table)
    return (draw(st.sampled_from(["", "\ufeff"])) + text + draw(st.sampled_from(["", "\n", "\n\n"]))).encode()


@pytest.mark.parametrize("examples", MANY)
def test_a_table_is_read_alike_in_every_format(folder: Path, examples: int) -> None:
    def holds(content: bytes) -> None:
        (folder / "signals.csv").write_bytes(content)
        found = readers.read(folder)
        assert found.speed_mps == pytest.approx(np.full(FRAMES, 8.0))
        assert found.yaw_rate_radps == pytest.approx(np.full(FRAMES, 0.1), rel=1e-4)
        assert found.steering_rad == pytest.approx(np.full(FRAMES, np.radians(29.0 / 15.0)))
        assert found.notes == ("signals.csv: not used: note",)

    check(examples, dress(), holds)


SMALL_PX = (64, 48)
CALIBRATION = """left_cam_calib:
    res: [64, 48]
    fx: 40.0
    fy: 40.0
    cx: 31.5
    cy: 23.5
    k1: -0.1
    k2: 0.02
    k3: 0.0
    p1: 0.0
    p2: 0.0
"""


def radiate(folder: Path) -> Path:
    """With small pictures, since the readers look at them for a mounting."""
    layouts.radiate(folder)
    layouts.pictures(folder / "zed_left", [f"{k + 1:06d}.png" for k in range(FRAMES)], *SMALL_PX)
    (folder / "calib.yaml").write_text(CALIBRATION)
    return folder


def udacity(folder: Path) -> Path:
    """Likewise."""
    layouts.udacity(folder)
    layouts.pictures(folder / "center", [file.name for file in (folder / "center").iterdir()], *SMALL_PX)
    return folder


WRITERS: dict[str, Callable[[Path], Path]] = {
    "KITTI raw": layouts.kitti_raw,
    "KITTI odometry": layouts.kitti_odometry,
    "comma2k19": lambda folder: layouts.comma2k19(folder, with_video=False),
    "RADIATE": radiate,
    "Udacity": udacity,
}


@pytest.mark.slow
@pytest.mark.parametrize("examples", [1000])
@pytest.mark.parametrize("name", WRITERS)
def test_a_recording_with_a_mutated_file_is_valid_or_refused(
    name: str, examples: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(layouts, "FRAMES", FRAMES)
    path = WRITERS[name](tmp_path / "drive")
    files = sorted(file for file in tmp_path.rglob("*") if file.is_file() and file.suffix not in (".png", ".jpg"))
    kept = {file: file.read_bytes() for file in files}
    spoiled = st.sampled_from(files).flatmap(lambda file: st.tuples(st.just(file), spoiled_bytes(kept[file])))

    def holds(change: tuple[Path, bytes]) -> None:
        file, content = change
        file.write_bytes(content)
        try:
            assert_read_or_refused(path)
        finally:
            file.write_bytes(kept[file])

    check(examples, spoiled, holds)


def spoiled_bytes(content: bytes) -> st.SearchStrategy[bytes]:
    """A text with cells changed, an array with numbers changed, and either of them torn."""
    if content.startswith(b"\x93NUMPY"):
        numbers = np.frombuffer(content[NUMPY_HEAD:])
        return (
            st.tuples(st.integers(0, len(numbers) - 1), mutations.NUMBERS.map(float))
            .map(
                lambda change: (
                    content[:NUMPY_HEAD] + np.where(np.arange(len(numbers)) == change[0], change[1], numbers).tobytes()
                )
            )
            .flatmap(mutations.torn)
        )
    text = content.decode()
    delimiter = "," if "," in text else " "
    table = [line.split(delimiter) for line in text.splitlines()]
    return mutations.spoiled_rows(table).map(lambda spoiled: spoiled.replace(b",", delimiter.encode()))
