"""Sweeps of learned drivers: by a relative file in worker processes, resumed, scored elsewhere, and hashed."""

import json
import shutil
from pathlib import Path

import policies
import pytest
from one_process import one_process
from short_scenario import write_short

import vpf_sim
from vpf_sim import cli, drivers
from vpf_sim.drivers.learned import driver as learned
from vpf_sim.evaluation.sweeps.fingerprint import own_code
from vpf_sim.evaluation.sweeps.run_folder import read_lines

NAME = "onnx:models/policy.onnx"


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A working directory with a policy in models/ that steers by the picture, and its run in this process."""
    folder = tmp_path_factory.mktemp("driven")
    (folder / "models").mkdir()
    manifest = policies.MANIFEST.partition("[state]")[0].replace("[image]", "[image]\ndeviation = 2550.0")
    policies.write(folder / "models", policies.ends_of_the_picture(), manifest, inputs=[("image", policies.IMAGE)])
    write_short(folder)
    with pytest.MonkeyPatch.context() as patch, one_process():
        patch.chdir(folder)
        assert sweep("--workers", "1", "--out", "run") == 0
    return folder


@pytest.fixture
def folder(driven: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy that may be changed, as the working directory."""
    monkeypatch.chdir(shutil.copytree(driven, tmp_path / "copy"))
    return Path.cwd()


def sweep(*more: str) -> int:
    return cli.run(["sweep", "--scenario", "short.toml", "--driver", NAME, "--seeds", "0:2", *more])


def lines(folder: str) -> list[str]:
    return sorted(Path(folder, "episodes.jsonl").read_text().splitlines())


def test_a_worker_finds_a_relative_file_and_repeats_the_drive_to_the_bit(folder: Path) -> None:  # noqa: ARG001
    assert sweep("--workers", "1", "--out", "worker") == 0
    assert lines("worker") == lines("run")
    assert len({json.loads(line)["states_sha256"] for line in lines("run")}) == 2, "the seeds' drives differ"


def test_a_run_is_scored_from_any_directory_and_without_the_model(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = lines("run")
    for path in (folder / "models").iterdir():
        path.unlink()
    (folder / "elsewhere").mkdir()
    monkeypatch.chdir(folder / "elsewhere")
    assert cli.run(["score", "../run"]) == 0
    assert lines("../run") == before
    (row,) = vpf_sim.Run("../run").table.to_dict("records")
    assert (row["driver"], row["privileged"]) == (NAME, "none")


@pytest.mark.usefixtures("in_one_process")
def test_a_stopped_run_is_resumed(folder: Path) -> None:
    whole = lines("run")
    (folder / "run" / "episodes.jsonl").write_text(whole[0] + "\n")
    assert sweep("--workers", "1", "--out", "run", "--resume") == 0
    assert lines("run") == whole


@pytest.mark.parametrize("suffix", [".onnx", ".toml"])
def test_a_run_is_not_resumed_with_another_policy(
    suffix: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = folder / "models" / "policy.onnx"
    if suffix == ".onnx":
        inputs = [("image", policies.IMAGE)]
        policies.write(path.parent, policies.constant(0.5, 0.0), path.with_suffix(".toml").read_text(), inputs=inputs)
    else:
        path.with_suffix(suffix).write_text(path.with_suffix(suffix).read_text().replace("20.0", "10.0"))
    assert sweep("--workers", "1", "--out", "run", "--resume") == 2
    assert f"drivers changed: {NAME}: was" in capsys.readouterr().err


def test_the_hash_of_a_policy_is_that_of_model_manifest_and_runtime(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    absolute = f"onnx:{folder / 'models' / 'policy.onnx'}"
    before = own_code(NAME)
    assert before == own_code(absolute) is not None
    monkeypatch.setattr(learned, "version", lambda name: f"another {name}")
    assert own_code(NAME) != before
    assert own_code("learned-bc") is not None


def test_names_of_models_lead_to_drivers_in_any_process() -> None:
    assert drivers.has_name(NAME)
    assert drivers.is_importable(NAME)
    assert drivers.model_of(NAME) == Path("models/policy.onnx")
    assert drivers.model_of("vpf") is None


def test_a_policy_is_described_by_its_manifest(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = folder / "models" / "policy.toml"
    path.write_text(path.read_text().replace("schema = 1", 'schema = 1\nsummary = "steers by the sky"'))
    assert cli.run(["drivers", "show", NAME]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert (shown["summary"], shown["privileged"], shown["uses_images"]) == ("steers by the sky", "none", True)
    assert cli.run(["drivers", "validate", NAME]) == 0


@pytest.mark.usefixtures("in_one_process")
def test_a_policy_is_compared_with_other_drivers_from_python(folder: Path) -> None:  # noqa: ARG001
    run = vpf_sim.sweep("short.toml", driver=[NAME, "pid"], seeds="0:1", workers=1, progress=False)
    assert sorted(run.table["driver"]) == [NAME, "pid"]
    assert len(read_lines(run.path / "episodes.jsonl")) == 2
