"""Tables of numbers as Parquet files, whole or not at all, with their faults told in plain words."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vpf_sim.errors import InputError
from vpf_sim.files import replacing
from vpf_sim.types import Floats


def write(rows: Floats, names: Sequence[str], path: Path) -> None:
    """The columns of (N, C) rows under their names."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = [pa.array(column) for column in rows.T]
    with replacing(path) as draft:
        pq.write_table(pa.table(columns, names=list(names)), draft, compression="zstd")


def read(path: Path, names: Sequence[str], what: str, kind: str) -> Floats:
    """(N, C) of a file that `write` stored: `what` it has, in a table of this `kind`; else InputError."""
    import pyarrow.parquet as pq

    try:
        stored = pq.read_table(path)
        columns = [stored[name].to_numpy() for name in names]
    except FileNotFoundError:
        raise InputError(f"{path}: expected {what}, found nothing") from None
    except (OSError, ValueError, KeyError) as error:  # pyarrow's own are among them
        reason = " ".join(str(error.args[0] if error.args else error).split())[:120]
        raise InputError(f"{path}: expected a {kind} table of this version, got: {reason}") from None
    return np.column_stack(columns)
