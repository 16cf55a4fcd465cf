"""Step tables are ordinary Parquet files: pyarrow reads what is written here, and its files are read here."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from vpf_sim.errors import InputError
from vpf_sim.evaluation import parquet

NAMES = ["time_s", "x_m", "speed_mps"]
ROWS = np.array([[0.0, -0.0, np.nan], [0.1, 1e300, np.inf], [0.2, np.pi, -5e-324]])
WHAT = ("the steps of an episode", "step")


def equal_bits(one: np.ndarray, other: np.ndarray) -> bool:
    return np.ascontiguousarray(one).tobytes() == np.ascontiguousarray(other).tobytes()


@pytest.mark.parametrize("count", [0, 1, 3, 5000])
def test_other_readers_get_every_bit(count: int, tmp_path: Path) -> None:
    rows = np.resize(ROWS, (count, 3))
    parquet.write(rows, NAMES, tmp_path / "a.parquet")
    table = pq.read_table(tmp_path / "a.parquet")
    assert table.schema.names == NAMES
    assert {str(kind) for kind in table.schema.types} == {"double"}
    assert equal_bits(np.column_stack([column.to_numpy() for column in table.columns]), rows)
    assert equal_bits(parquet.read(tmp_path / "a.parquet", NAMES, *WHAT), rows)


@pytest.mark.parametrize("compression", ["zstd", "snappy", "none"])
def test_files_of_other_writers_are_read(compression: str, tmp_path: Path) -> None:
    table = pa.table(dict(zip(NAMES, map(pa.array, ROWS.T), strict=True)))
    pq.write_table(table, tmp_path / "a.parquet", compression=compression)
    assert equal_bits(parquet.read(tmp_path / "a.parquet", NAMES[::-1], *WHAT), ROWS[:, ::-1])


def test_a_missing_value_is_nan(tmp_path: Path) -> None:
    pq.write_table(pa.table({"time_s": pa.array([1.0, None])}), tmp_path / "a.parquet")
    assert np.isnan(parquet.read(tmp_path / "a.parquet", ["time_s"], *WHAT)).ravel().tolist() == [False, True]


def test_columns_that_came_later_are_nan_where_they_are_missing(tmp_path: Path) -> None:
    parquet.write(ROWS, NAMES, tmp_path / "a.parquet")
    found = parquet.read(tmp_path / "a.parquet", ["x_m", "cost"], *WHAT, later=["cost", "x_m"])
    assert equal_bits(found, np.column_stack([ROWS[:, 1], np.full(3, np.nan)]))


def test_equal_tables_make_equal_files(tmp_path: Path) -> None:
    rows = np.random.default_rng(0).normal(size=(5000, 3))
    for name in ("a", "b"):
        parquet.write(rows, NAMES, tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


@pytest.mark.parametrize("name", ["a*.parquet", "it's [1].parquet", "a?.parquet", "ä {b,c}.parquet"])
def test_a_name_is_no_pattern(name: str, tmp_path: Path) -> None:
    parquet.write(ROWS + 1.0, NAMES, tmp_path / "ab.parquet")
    parquet.write(ROWS, NAMES, tmp_path / name)
    assert equal_bits(parquet.read(tmp_path / name, NAMES, *WHAT), ROWS)
    (tmp_path / name).unlink()
    with pytest.raises(InputError, match="expected the steps of an episode, found nothing"):
        parquet.read(tmp_path / name, NAMES, *WHAT)


@pytest.mark.parametrize("values", [["a", "b"], [[1.0], [2.0]], [b"a", b"b"]])
def test_columns_that_are_no_numbers_are_refused(values: list[object], tmp_path: Path) -> None:
    pq.write_table(pa.table({"time_s": values}), tmp_path / "a.parquet")
    with pytest.raises(InputError, match="expected a step table of this version, got: "):
        parquet.read(tmp_path / "a.parquet", ["time_s"], *WHAT)


def test_a_damaged_file_is_refused_or_read_in_one_piece(tmp_path: Path) -> None:
    """Damage anywhere, in the footer above all, ends in one line or in a table: never in a crash."""
    chance = np.random.default_rng(0)
    parquet.write(np.resize(ROWS, (200, 3)), NAMES, tmp_path / "whole")
    whole, path = (tmp_path / "whole").read_bytes(), tmp_path / "a.parquet"
    footer = int.from_bytes(whole[-8:-4], "little") + 8
    refused: list[str] = []
    for number in range(45):
        damaged = bytearray(whole if number % 3 else whole[: chance.integers(len(whole))])
        first = len(whole) - footer if number % 3 == 1 else 0
        for place in chance.integers(first, len(whole), chance.integers(1, 9)) if number % 3 else ():
            damaged[place] = chance.integers(256)
        path.write_bytes(damaged)
        try:
            assert parquet.read(path, NAMES, *WHAT).shape[1] == len(NAMES)
        except InputError as error:
            refused.append(str(error))
    assert not any("\n" in line for line in refused)
    assert len(refused) > 25
