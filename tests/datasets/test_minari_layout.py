"""The layout of Minari, read with h5py alone: arrays without loss."""

import json
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from typing import Any

import cv2
import h5py
import numpy as np
import pytest
from conftest import SIZE
from driven_short import SEED, STOPS_AT, Driven

from vpf_sim.reporting.run_data import open_run


@pytest.fixture
def stored(minari_set: Path) -> Iterator[Any]:
    with h5py.File(minari_set / "data" / "main_data.hdf5") as file:
        yield file


@pytest.fixture
def small(small_set: Path) -> Iterator[Any]:
    with h5py.File(small_set / "data" / "main_data.hdf5") as file:
        yield file


def test_the_pictures_are_the_frames_of_the_run_to_the_bit(driven: Driven, stored: Any) -> None:
    pictures = stored["episode_0/observations/image"][()]
    assert np.array_equal(pictures, driven.frames)
    looked = driven.table.looked > 0.0
    assert 0 < looked.sum() < len(looked), "the driver looked at some of them"
    record = open_run(driven.path).record(driven.ids["weaves"])
    assert sha256(np.ascontiguousarray(pictures[looked]).data).hexdigest() == record.frames_sha256


def test_actions_states_and_rewards_are_those_of_the_run_to_the_bit(driven: Driven, stored: Any) -> None:
    group, steps = stored["episode_0"], driven.table
    actions = np.column_stack([steps.throttle, steps.steering])[:-1]
    assert group["actions"][()].tobytes() == actions.tobytes()
    states = [steps.speed_mps, steps.yaw_rate_radps, steps.x_m, steps.y_m, steps.yaw_rad]
    assert group["observations/state"][:, :5].tobytes() == np.column_stack(states).tobytes()
    assert group["rewards"][()].tolist() == driven.rewards


def test_an_episode_has_one_frame_more_than_actions_and_ends_once(driven: Driven, stored: Any) -> None:
    assert [*stored] == ["episode_0", "episode_1"]
    for group, length, ends in (
        (stored["episode_0"], len(driven.table), (True, False)),
        (stored["episode_1"], STOPS_AT, (False, True)),
    ):
        assert group.attrs["total_steps"] == length
        assert len(group["observations/image"]) == len(group["observations/state"]) == length + 1
        for name, end in zip(("terminations", "truncations"), ends, strict=True):
            assert group[name][()].tolist() == [False] * (length - 1) + [end]
    named = stored["episode_1"].attrs
    assert (named["seed"], named["status"], named["driver"], named["weather"]) == (SEED, "error", "breaks", "rain")


def test_the_metadata_is_what_minari_asks_for(driven: Driven, minari_set: Path) -> None:
    metadata = json.loads((minari_set / "data" / "metadata.json").read_text())
    assert metadata["dataset_id"] == "drives-v2"
    assert (metadata["data_format"], metadata["jpeg_encoding"]) == ("hdf5", False)
    assert (metadata["total_episodes"], metadata["total_steps"]) == (2, len(driven.table) + STOPS_AT)
    spaces = json.loads(metadata["observation_space"])["subspaces"]
    assert (spaces["image"]["dtype"], spaces["image"]["shape"]) == ("uint8", [480, 640, 3])
    assert np.array(spaces["image"]["high"]).shape == (480, 640, 3)
    assert spaces["state"]["shape"] == [7]
    assert json.loads(metadata["action_space"])["low"] == [-1.0, -1.0]


def test_small_grey_pictures_are_means_of_what_they_cover(driven: Driven, small: Any) -> None:
    pictures = small["episode_0/observations/image"]
    assert pictures.shape == (len(driven.frames), SIZE[1], SIZE[0], 1)
    for index in (0, len(driven.frames) - 1):
        luma = cv2.cvtColor(driven.frames[index], cv2.COLOR_RGB2GRAY).astype(float)
        means = luma.reshape(SIZE[1], 480 // SIZE[1], SIZE[0], 640 // SIZE[0]).mean(axis=(1, 3))
        assert np.abs(pictures[index][..., 0] - means).max() <= 0.51


def test_ground_truth_has_the_units_of_the_small_pictures(driven: Driven, small: Any) -> None:
    infos, whole = small["episode_0/infos"], driven.truths[-1]
    step = 640 // SIZE[0]
    rows, columns = (np.arange(count) * step + step // 2 for count in (SIZE[1], SIZE[0]))
    chosen = np.ix_(rows, columns)
    assert np.array_equal(infos["depth"][-1], whole["depth"][chosen])
    assert infos["flow"][-1] == pytest.approx(whole["flow"][chosen] / step)
    assert infos["foe"][-1] == pytest.approx((whole["foe"] + 0.5) / step - 0.5)
    assert len(infos["depth"]) == len(driven.frames)
