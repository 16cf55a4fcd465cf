"""The libraries of the formats themselves read what is written; they are not among the project's dependencies."""

from pathlib import Path

import numpy as np
import pytest
from driven_short import STOPS_AT, Driven


def test_minari_loads_the_set(driven: Driven, minari_set: Path) -> None:
    minari = pytest.importorskip("minari", reason="minari is not installed: pip install 'minari[hdf5]'")
    found = minari.MinariDataset(minari_set / "data")
    assert (found.total_episodes, found.total_steps) == (2, len(driven.table) + STOPS_AT)
    assert found.observation_space["image"].shape == (480, 640, 3)
    first, second = found.iterate_episodes()
    assert np.array_equal(first.observations["image"], driven.frames)
    assert found.observation_space.contains({key: value[0] for key, value in first.observations.items()})
    assert all(found.action_space.contains(action) for action in first.actions)
    assert (first.terminations[-1], second.truncations[-1]) == (True, True)
    assert [one["status"] for one in found.storage.get_episode_metadata([0, 1])] == ["success", "error"]


def test_minari_finds_the_set_by_its_name(minari_set: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    minari = pytest.importorskip("minari", reason="minari is not installed: pip install 'minari[hdf5]'")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(minari_set.parent))
    assert minari.load_dataset("drives-v2").total_episodes == 2


def test_minari_reads_small_grey_pictures_and_ground_truth(driven: Driven, small_set: Path) -> None:
    minari = pytest.importorskip("minari", reason="minari is not installed: pip install 'minari[hdf5]'")
    episode = minari.MinariDataset(small_set / "data")[0]
    assert episode.observations["image"].shape == (len(driven.frames), 48, 64, 1)
    assert episode.infos["depth"].shape == (len(driven.frames), 48, 64)


def test_lerobot_loads_the_set(driven: Driven, lerobot_set: Path) -> None:
    lerobot = pytest.importorskip(
        "lerobot.datasets.lerobot_dataset", reason="lerobot is not installed: pip install lerobot"
    )
    window = {"observation.images.front": [-1.0 / 60.0, 0.0], "action": [0.0, 1.0 / 60.0]}
    found = lerobot.LeRobotDataset("local/short", root=lerobot_set, delta_timestamps=window)
    assert (found.num_episodes, len(found), found.fps) == (2, len(driven.table) + STOPS_AT, 60)
    sample = found[10]
    steps = driven.table
    actions = np.column_stack([steps.throttle, steps.steering])[10:12]
    assert sample["action"].numpy() == pytest.approx(actions, abs=1e-6)
    assert sample["task"] == "Drive to the goal. Road: short. Weather: rain."
    for picture, frame in zip(sample["observation.images.front"].numpy(), driven.frames[9:11], strict=True):
        assert np.abs(picture.transpose(1, 2, 0) - frame / 255.0).mean() < 0.02
    last = found[len(driven.table) - 1]
    assert (bool(last["next.done"]), bool(last["next.success"])) == (True, True)
    assert set(found.meta.stats) == set(found.features)
