"""LeRobot's data sets, version 3.0: tables as Parquet, pictures as video, one file of each an episode.

https://huggingface.co/docs/lerobot/lerobot-dataset-v3
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vpf_sim.datasets import datasheet
from vpf_sim.datasets.datasheet import PixelCounts, Statistics
from vpf_sim.datasets.formats import Place, Written, missing
from vpf_sim.datasets.played_episode import ACTION, STATE, Contents, Episode
from vpf_sim.errors import InputError, option
from vpf_sim.evaluation.score_keys import Json
from vpf_sim.evaluation.sweeps.run_folder import write_json
from vpf_sim.files import replacing
from vpf_sim.reporting.video import Writer, is_available

VERSION = "v3.0"
CAMERA = "observation.images.front"
FILE = "chunk-{chunk_index:03d}/file-{file_index:03d}"
DATA, VIDEO = f"data/{FILE}.parquet", f"videos/{{video_key}}/{FILE}.mp4"
EPISODES, TASKS = f"meta/episodes/{FILE}.parquet", "meta/tasks.parquet"
FILES_A_CHUNK = 1000
GOP = 2  # LeRobot's: a frame that is read at random costs at most two
SAMPLED = 10  # every tenth picture counts in the statistics
HEAD = """---
tags:
- LeRobot
- vpf_sim
task_categories:
- robotics
configs:
- config_name: default
  data_files: data/*/*.parquet
---
"""
NAMES: dict[str, list[str] | None] = {"observation.state": [*STATE], "action": [*ACTION]}
Columns = dict[str, NDArray[Any]]


class LeRobot:
    """The format of the library `lerobot`, written without it."""

    head = HEAD

    def check(self, contents: Contents) -> None:
        if not is_available():
            raise missing("PyAV")
        try:
            import pyarrow  # noqa: F401
        except ImportError:
            raise missing("pyarrow") from None
        if contents.truth:
            remedy = f"{option('format')} minari holds them"
            raise InputError(f"{option('truth')}: expected none, since this format holds no arrays; {remedy}")
        if contents.width_px % 2 or contents.height_px % 2:
            got = f"{contents.width_px}x{contents.height_px}"
            raise InputError(f"{option('size')}: expected even sides, which its videos need, got {got}")

    def write(self, folder: Path, place: Place, episode: Episode) -> tuple[Columns, PixelCounts]:
        """Store the n frames that have an action; a grey picture has three equal channels."""
        size, counts = (episode.contents.width_px, episode.contents.height_px), PixelCounts()
        path = folder / VIDEO.format(video_key=CAMERA, **_file(place.episode))
        with Writer(path, size, episode.rate_hz, gop=GOP) as video:
            for frame in episode.frames():
                if frame.row == len(episode):  # the last state, in which the driver did nothing
                    continue
                picture = np.broadcast_to(frame.picture, (*frame.picture.shape[:2], 3))
                video.write(picture)
                if frame.row % SAMPLED == 0:
                    counts.add(picture)
        columns = _columns(place, episode)
        _write_table(folder / DATA.format(**_file(place.episode)), columns)
        return columns, counts

    def finish(self, folder: Path, name: str, episodes: Sequence[Written], contents: Contents) -> None:  # noqa: ARG002
        """Write what is in `meta`."""
        import pandas as pd

        tasks = [*dict.fromkeys(one.task for one in episodes)]
        with replacing(folder / TASKS) as draft:
            pd.DataFrame({"task_index": range(len(tasks))}, index=tasks).to_parquet(draft)
        _write_rows(folder / EPISODES.format(**_file(0)), [_episode_row(one) for one in episodes])
        columns = [one.details[0] for one in episodes]
        together = {key: np.concatenate([one[key] for one in columns]) for key in columns[0]}
        pixels = datasheet.combined([one.details[1] for one in episodes])
        write_json(folder / "meta/stats.json", _statistics(together, pixels))
        write_json(folder / "meta/info.json", _info(episodes, len(tasks), together, contents))


def _file(index: int) -> dict[str, int]:
    return {"chunk_index": index // FILES_A_CHUNK, "file_index": index % FILES_A_CHUNK}


def _columns(place: Place, episode: Episode) -> Columns:
    """The table of an episode, a row a step."""
    rows = np.arange(len(episode))
    return {
        "observation.state": np.array(episode.states[:-1]),
        "action": episode.actions,
        "next.reward": np.array(episode.rewards),
        "next.done": episode.terminations | episode.truncations,
        "next.truncated": episode.truncations,
        "next.success": episode.successes,
        "timestamp": (rows / episode.rate_hz).astype(np.float32),
        "frame_index": rows,
        "episode_index": np.full(len(rows), place.episode),
        "index": place.first_frame + rows,
        "task_index": np.full(len(rows), place.task_index),
    }


def _write_table(path: Path, columns: Columns) -> None:
    """Write columns of numbers; (n, k) ones as lists of k."""
    import pyarrow as pa

    arrays = {
        key: pa.FixedSizeListArray.from_arrays(values.ravel(), values.shape[1]) if values.ndim == 2 else values
        for key, values in columns.items()
    }
    _write(path, pa.table(arrays))


def _write_rows(path: Path, rows: list[Json]) -> None:
    import pyarrow as pa

    _write(path, pa.Table.from_pylist(rows))


def _write(path: Path, table: Any) -> None:
    """Write an Arrow table as Parquet."""
    import pyarrow.parquet as pq

    with replacing(path) as draft:
        pq.write_table(table, draft)


def _episode_row(one: Written) -> Json:
    """An episode in `meta/episodes`: where its frames are, their statistics, and what it was in the run."""
    file, end = _file(one.place.episode), one.place.first_frame + one.length
    where = {f"data/{key}": value for key, value in file.items()}
    where |= {f"videos/{CAMERA}/{key}": value for key, value in file.items()}
    where |= {f"meta/episodes/{key}": value for key, value in _file(0).items()}
    counted = _statistics(*one.details)
    return {
        "episode_index": one.place.episode,
        "tasks": [one.task],
        "length": one.length,
        "dataset_from_index": one.place.first_frame,
        "dataset_to_index": end,
        **where,
        f"videos/{CAMERA}/from_timestamp": 0.0,
        f"videos/{CAMERA}/to_timestamp": one.length / one.rate_hz,
        **{key: getattr(one.record, key) for key in ("id", "scenario", "weather", "driver", "seed", "status")},
        **{f"stats/{key}/{name}": value for key, table in counted.items() for name, value in table.items()},
    }


def _statistics(columns: Columns, pixels: PixelCounts) -> dict[str, Statistics]:
    """The statistics of each feature."""
    values = {key: datasheet.of_values(column) for key, column in columns.items()}
    return {CAMERA: pixels.statistics(), **values}


def _info(episodes: Sequence[Written], tasks: int, columns: Columns, contents: Contents) -> Json:
    """The content of `meta/info.json`."""
    rate_hz = round(episodes[0].rate_hz)
    features = {
        key: {"dtype": str(values.dtype), "shape": [*values.shape[1:]] or [1], "names": NAMES.get(key)}
        for key, values in columns.items()
    }
    return {
        "codebase_version": VERSION,
        "robot_type": "vpf_sim",
        "total_episodes": len(episodes),
        "total_frames": sum(one.length for one in episodes),
        "total_tasks": tasks,
        "chunks_size": FILES_A_CHUNK,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": rate_hz,
        "splits": {"train": f"0:{len(episodes)}"},
        "data_path": DATA,
        "video_path": VIDEO,
        "features": {CAMERA: _video_feature(contents, rate_hz), **features},
    }


def _video_feature(contents: Contents, rate_hz: int) -> Json:
    height_px, width_px = contents.height_px, contents.width_px
    of_video = {
        "video.height": height_px,
        "video.width": width_px,
        "video.codec": "h264",
        "video.pix_fmt": "yuv420p",
        "video.is_depth_map": False,
        "video.fps": rate_hz,
        "video.channels": 3,
        "has_audio": False,
    }
    names = ["height", "width", "channels"]
    return {"dtype": "video", "shape": [height_px, width_px, 3], "names": names, "info": of_video}
