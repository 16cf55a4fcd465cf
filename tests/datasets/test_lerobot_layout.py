"""The layout of LeRobot v3, read with pyarrow, pandas and PyAV alone."""

import json
from pathlib import Path
from typing import Any

import av
import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from driven_short import STOPS_AT, Driven

CAMERA = "observation.images.front"
LEAST_PSNR_DB = 30.0


@pytest.fixture(scope="module")
def info(lerobot_set: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((lerobot_set / "meta" / "info.json").read_text())
    return content


@pytest.fixture(scope="module")
def episodes(lerobot_set: Path) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = pq.read_table(lerobot_set / "meta/episodes/chunk-000/file-000.parquet").to_pylist()
    return rows


def table_of(folder: Path, info: dict[str, Any], row: dict[str, Any]) -> Any:
    place = {"chunk_index": row["data/chunk_index"], "file_index": row["data/file_index"]}
    return pq.read_table(folder / info["data_path"].format(**place))


def column(table: Any, name: str) -> np.ndarray[Any, Any]:
    return np.array(table[name].to_pylist())


def test_actions_and_states_are_those_of_the_run_to_the_bit(
    driven: Driven, lerobot_set: Path, info: dict[str, Any], episodes: list[dict[str, Any]]
) -> None:
    table, steps = table_of(lerobot_set, info, episodes[0]), driven.table
    actions = np.column_stack([steps.throttle, steps.steering])[:-1]
    assert column(table, "action").tobytes() == actions.tobytes()
    states = column(table, "observation.state")
    names = info["features"]["observation.state"]["names"]
    for name in ("speed_mps", "yaw_rate_radps", "x_m", "y_m", "yaw_rad"):
        assert states[:, names.index(name)].tobytes() == getattr(steps, name)[:-1].tobytes(), name
    assert column(table, "next.reward").tolist() == driven.rewards


def test_the_episode_ends_at_its_last_step(
    lerobot_set: Path, info: dict[str, Any], episodes: list[dict[str, Any]]
) -> None:
    ends = []
    for row in episodes:
        table = table_of(lerobot_set, info, row)
        for name in ("next.done", "next.truncated", "next.success"):
            assert not column(table, name)[:-1].any()
        ends.append(tuple(bool(column(table, name)[-1]) for name in ("next.done", "next.truncated", "next.success")))
    assert [row["status"] for row in episodes] == ["success", "error"]
    assert ends == [(True, False, True), (True, True, False)]


def test_frames_are_numbered_through_the_set(
    driven: Driven, lerobot_set: Path, info: dict[str, Any], episodes: list[dict[str, Any]]
) -> None:
    tables = [table_of(lerobot_set, info, row) for row in episodes]
    lengths = [len(driven.table), STOPS_AT]
    assert [row["length"] for row in episodes] == [len(table) for table in tables] == lengths
    assert np.concatenate([column(table, "index") for table in tables]).tolist() == [*range(sum(lengths))]
    assert [(row["dataset_from_index"], row["dataset_to_index"]) for row in episodes] == [
        (0, lengths[0]),
        (lengths[0], sum(lengths)),
    ]
    for number, table in enumerate(tables):
        assert set(column(table, "episode_index")) == {number}
        assert column(table, "frame_index").tolist() == [*range(len(table))]
        assert column(table, "timestamp") == pytest.approx(np.arange(len(table)) / 60.0, abs=1e-6)


def test_the_description_is_of_what_is_stored(
    lerobot_set: Path, info: dict[str, Any], episodes: list[dict[str, Any]]
) -> None:
    assert info["codebase_version"] == "v3.0"
    assert (info["fps"], info["total_episodes"], info["total_tasks"]) == (60, 2, 1)
    assert info["total_frames"] == sum(row["length"] for row in episodes)
    table = table_of(lerobot_set, info, episodes[0])
    features = dict(info["features"])
    assert features.pop(CAMERA)["shape"] == [480, 640, 3]
    assert set(features) == set(table.column_names)
    for name, feature in features.items():
        values = column(table, name)
        assert [*values.shape[1:]] in (feature["shape"], []), name
        assert feature["dtype"] == {"bool": "bool"}.get(str(values.dtype), feature["dtype"])
        stored = table.schema.field(name).type
        element = stored.value_type if feature["shape"] != [1] else stored
        assert {"float": "float32", "double": "float64"}.get(str(element), str(element)) == feature["dtype"], name
    tasks = pd.read_parquet(lerobot_set / "meta" / "tasks.parquet")
    assert [*tasks.index] == episodes[0]["tasks"] == ["Drive to the goal. Road: short. Weather: rain."]
    assert [*tasks["task_index"]] == [0]


def test_the_videos_show_the_frames_of_the_run(
    driven: Driven, lerobot_set: Path, info: dict[str, Any], episodes: list[dict[str, Any]]
) -> None:
    row = episodes[0]
    place = {"chunk_index": row[f"videos/{CAMERA}/chunk_index"], "file_index": row[f"videos/{CAMERA}/file_index"]}
    with av.open(str(lerobot_set / info["video_path"].format(video_key=CAMERA, **place))) as container:
        shown = [(float(frame.time), frame.to_ndarray(format="rgb24")) for frame in container.decode(video=0)]
        stream = container.streams.video[0]
        assert (stream.codec_context.name, stream.codec_context.pix_fmt) == ("h264", "yuv420p")
    assert len(shown) == row["length"], "one for each action"
    assert [time for time, _ in shown] == pytest.approx(np.arange(len(shown)) / 60.0, abs=1e-4)
    assert (row[f"videos/{CAMERA}/from_timestamp"], row[f"videos/{CAMERA}/to_timestamp"]) == (0.0, len(shown) / 60.0)
    for (_, picture), frame in zip(shown, driven.frames, strict=False):
        error = np.mean((picture.astype(float) - frame) ** 2)
        assert 10.0 * np.log10(255.0**2 / error) > LEAST_PSNR_DB


def test_statistics_are_those_of_the_columns(
    driven: Driven, lerobot_set: Path, info: dict[str, Any], episodes: list[dict[str, Any]]
) -> None:
    stored = json.loads((lerobot_set / "meta" / "stats.json").read_text())
    assert set(stored) == set(info["features"])
    tables = [table_of(lerobot_set, info, row) for row in episodes]
    for found, values in (
        (stored["action"], np.concatenate([column(table, "action") for table in tables])),
        ({k: episodes[1][f"stats/action/{k}"] for k in stored["action"]}, column(tables[1], "action")),
    ):
        assert found["mean"] == pytest.approx(values.mean(axis=0))
        assert found["std"] == pytest.approx(values.std(axis=0))
        assert (found["min"], found["max"]) == (values.min(axis=0).tolist(), values.max(axis=0).tolist())
        assert found["q50"] == pytest.approx(np.median(values, axis=0))
        assert found["count"] == [len(values)]
    own = {key: episodes[0][f"stats/{CAMERA}/{key}"] for key in ("mean", "std", "q50")}
    pixels = np.array(driven.frames[:-1:10], float).reshape(-1, 3) / 255.0
    assert np.array(own["mean"])[:, 0, 0] == pytest.approx(pixels.mean(axis=0))
    assert np.array(own["std"])[:, 0, 0] == pytest.approx(pixels.std(axis=0))
    assert np.array(own["q50"])[:, 0, 0] == pytest.approx(np.median(pixels, axis=0), abs=1.0 / 255.0)
