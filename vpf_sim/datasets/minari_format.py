"""Minari's data sets as HDF5: `data/main_data.hdf5` with a group an episode, and `data/metadata.json`.

https://minari.farama.org/content/dataset_standards
"""

import json
import re
from collections.abc import Sequence
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vpf_sim.datasets.formats import Place, Written, missing
from vpf_sim.datasets.played_episode import ACTION, STATE, Contents, Episode
from vpf_sim.evaluation.score_keys import Json
from vpf_sim.evaluation.sweeps.run_folder import write_json
from vpf_sim.files import replacing

VERSION = "0.5.4"  # of Minari: the first that reads pictures without JPEG
MAIN, PART, METADATA = "data/main_data.hdf5", "data/part-{index}.hdf5", "data/metadata.json"
CHUNK_BYTES = 1 << 20  # of pictures, compressed as one
BYTES_A_MB = 1e6


class Minari:
    """The HDF5 layout of the library `minari`, written without it; pictures are lossless."""

    head = ""

    def check(self, contents: Contents) -> None:  # noqa: ARG002
        try:
            import h5py  # noqa: F401
        except ImportError:
            raise missing("h5py") from None

    def write(self, folder: Path, place: Place, episode: Episode) -> None:
        """Store an episode in a file of its own, since HDF5 has one writer at a time."""
        import h5py

        (folder / MAIN).parent.mkdir(exist_ok=True)
        with h5py.File(folder / PART.format(index=place.episode), "w") as file:
            pictures: dict[str, Any] = {}
            for frame in episode.frames():
                for key, value in {"observations/image": frame.picture, **_infos(frame.truths)}.items():
                    if key not in pictures:
                        pictures[key] = _new(file, key, len(episode) + 1, value)
                    pictures[key][frame.row] = value
            file["observations/state"] = np.array(episode.states)
            file["actions"] = episode.actions
            file["rewards"] = np.array(episode.rewards)
            file["terminations"] = episode.terminations
            file["truncations"] = episode.truncations
            record = episode.record
            named = {key: getattr(record, key) for key in ("scenario", "weather", "driver", "status")}
            numbers = {"id": place.episode, "seed": record.seed, "total_steps": len(episode)}
            file.attrs.update({**numbers, **named, "episode": record.id, "task": episode.task})

    def finish(self, folder: Path, name: str, episodes: Sequence[Written], contents: Contents) -> None:
        """Gather the episodes in one file, and describe them."""
        import h5py

        with replacing(folder / MAIN) as draft, h5py.File(draft, "w", track_order=True) as whole:
            for one in episodes:
                path = folder / PART.format(index=one.place.episode)
                with h5py.File(path) as part:
                    part.copy("/", whole, f"episode_{one.place.episode}")
                path.unlink()
        write_json(folder / METADATA, _metadata(folder, name, episodes, contents))


def _infos(truths: dict[str, NDArray[np.generic]]) -> dict[str, NDArray[np.generic]]:
    return {f"infos/{key}": value for key, value in truths.items()}


def _new(file: Any, key: str, length: int, value: NDArray[Any]) -> Any:
    """An empty table of `length` arrays like `value`, compressed without loss."""
    rows = max(1, min(length, CHUNK_BYTES // max(1, value.nbytes)))
    shape = (length, *value.shape)
    return file.create_dataset(
        key, shape, value.dtype, chunks=(rows, *value.shape), compression="gzip", compression_opts=1
    )


def _metadata(folder: Path, name: str, episodes: Sequence[Written], contents: Contents) -> Json:
    size_mb = (folder / MAIN).stat().st_size / BYTES_A_MB
    return {
        "dataset_id": dataset_id(name),
        "minari_version": VERSION,
        "data_format": "hdf5",
        "jpeg_encoding": False,
        "total_episodes": len(episodes),
        "total_steps": sum(one.length for one in episodes),
        "dataset_size": round(size_mb, 1),
        "observation_space": json.dumps(_observation_space(contents)),
        "action_space": json.dumps(_box("float64", [len(ACTION)], -1.0, 1.0)),
        "algorithm_name": ", ".join(dict.fromkeys(str(one.record.driver) for one in episodes)),
        "description": f"Drives of vpf_sim; state: {', '.join(STATE)}; action: {', '.join(ACTION)}. See README.md.",
        "requirements": [],
    }


def dataset_id(name: str) -> str:
    """The id by which Minari finds a folder of this name; it must end in a version."""
    plain = re.sub(r"[^\w-]", "_", name)
    return plain if re.search(r"-v\d+$", plain) else f"{plain}-v0"


def _observation_space(contents: Contents) -> Json:
    image = _box("uint8", [*contents.shape], 0, 255)
    state = _box("float64", [len(STATE)], -inf, inf)
    return {"type": "Dict", "subspaces": {"image": image, "state": state}}


def _box(dtype: str, shape: list[int], low: float, high: float) -> Json:
    """gymnasium's Box as Minari stores it."""
    bounds = {"low": np.full(shape, low).tolist(), "high": np.full(shape, high).tolist()}
    return {"type": "Box", "dtype": dtype, "shape": shape, **bounds}
