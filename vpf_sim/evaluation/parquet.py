"""Atomic writing and checked reading of numeric Parquet tables."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.files import replacing
from vpf_sim.types import Floats


def write(rows: Floats, names: Sequence[str], path: Path) -> None:
    """Write (N, C) rows with one named column each."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = [pa.array(column) for column in rows.T]
    with replacing(path) as draft:
        pq.write_table(pa.table(columns, names=list(names)), draft, compression="zstd")


def read(path: Path, names: Sequence[str], what: str, kind: str) -> Floats:
    """(N, C) rows that `write` stored; InputErrors call the content `what` and the table's format `kind`."""
    import pyarrow.parquet as pq

    try:
        stored = pq.read_table(path)
        columns = [stored[name].to_numpy() for name in names]
    except FileNotFoundError:
        raise InputError(f"{path}: expected {what}, found nothing") from None
    except (OSError, ValueError, KeyError) as error:  # includes pyarrow's errors
        reason = " ".join(str(error.args[0] if error.args else error).split())[:120]
        raise InputError(f"{path}: expected a {kind} table of this version, got: {reason}") from None
    return np.column_stack(columns)
