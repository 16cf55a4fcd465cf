"""Atomic writing and checked reading of numeric Parquet tables."""

import errno
import os
from collections.abc import Collection, Sequence
from glob import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.files import replacing
from vpf_sim.types import Floats

if TYPE_CHECKING:
    from duckdb import DuckDBPyConnection


def write(rows: Floats, names: Sequence[str], path: Path) -> None:
    """Write (N, C) rows with one named column each."""
    import duckdb

    with replacing(path) as draft, _database() as database:
        database.register("stored", dict(zip(names, rows.T.copy(), strict=True)))
        try:
            database.table("stored").write_parquet(str(draft), compression="zstd")
        except duckdb.Error as error:
            raise _as_os_error(error, draft) from None


def read(path: Path, names: Sequence[str], what: str, kind: str, later: Collection[str] = ()) -> Floats:
    """(N, C) rows that `write` stored; InputErrors call the content `what` and the table's format `kind`.

    The columns `later` were added after the first version of the format: nan where they are missing.
    """
    import duckdb

    if not path.is_file():
        raise InputError(f"{path}: expected {what}, found nothing")
    try:
        with _database() as database:
            stored = database.read_parquet(escape(str(path))).fetchnumpy()  # else a "*" in a name is a pattern
        unknown = np.full(len(next(iter(stored.values()), ())), np.nan)
        stored = dict.fromkeys(later, unknown) | stored
        missing = [name for name in names if name not in stored]
        if missing:
            raise ValueError(f"no column {missing[0]}")
        return np.column_stack([np.ma.filled(np.ma.asarray(stored[name], float), np.nan) for name in names])
    except (duckdb.Error, RuntimeError, ValueError) as error:  # RuntimeError: a column's name is no UTF-8
        reason = " ".join(str(error).split())[:120]
        raise InputError(f"{path}: expected a {kind} table of this version, got: {reason}") from None


def _database() -> "DuckDBPyConnection":
    """A database in memory; one thread, so that equal tables make equal files."""
    import duckdb

    return duckdb.connect(config={"threads": "1", "temp_directory": "", "autoinstall_known_extensions": "false"})


def _as_os_error(error: Exception, path: Path) -> OSError:
    """The reason of the operating system, which DuckDB has in its message alone."""
    codes = (code for code in errno.errorcode if os.strerror(code) in str(error))
    code = next(codes, errno.EIO)
    return OSError(code, os.strerror(code), str(path))
