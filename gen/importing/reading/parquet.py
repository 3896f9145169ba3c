"""Files of Parquet to tables, whose columns have types."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gen.errors import InputError
from gen.importing.clock import in_nanoseconds
from gen.importing.reading.rows.delimited import MOST_COLUMNS
from gen.importing.table import Cells, Column, InstantArray, Reading, Table, unique_names

if TYPE_CHECKING:
    import pyarrow as pa


def read_parquet(file: Path, data: bytes) -> Table:
    """Read a Parquet file; an index that pandas left in it is a column like the others.

    Raises
    ------
    InputError
        Without a file name: it is broken, or empty.
    """
    import pyarrow as pa  # slow to import
    import pyarrow.parquet as pq

    try:
        found = pq.read_table(io.BytesIO(data))
    except (pa.ArrowException, OSError) as error:
        raise InputError(f"cannot be read as Parquet ({str(error)[:80]})") from None
    if found.num_columns > MOST_COLUMNS:
        raise InputError(f"found {found.num_columns} columns, expected {MOST_COLUMNS} at most")
    names = ["" if name.startswith("__index_level_") else name for name in found.column_names]
    columns = [
        Column(name, _of_arrow(found.column(i)))
        for i, name in enumerate(unique_names(names))
        if not _nested(found.schema.field(i).type)
    ]
    if not found.num_rows or not columns:
        raise InputError("there are no rows; expected at least one")
    return Table(file, columns, np.arange(1, found.num_rows + 1), "row", reading=Reading())


def _nested(kind: pa.DataType) -> bool:
    import pyarrow as pa

    return bool(pa.types.is_nested(kind))


def _of_arrow(column: pa.ChunkedArray[Any]) -> Cells:
    import pandas as pd
    import pyarrow as pa

    kind = column.type
    if pa.types.is_timestamp(kind):
        plain = column.cast(pa.timestamp(kind.unit))  # of a zone: in UTC
        stamps = in_nanoseconds(plain.to_numpy(zero_copy_only=False))
        known = stamps[~np.isnat(stamps)]
        return stamps if (known != known.astype("datetime64[D]")).any() else _days(stamps)
    if pa.types.is_date(kind):
        return _days(in_nanoseconds(column.cast(pa.date32()).to_numpy(zero_copy_only=False)))
    if pa.types.is_duration(kind):
        return np.asarray(pd.to_timedelta(column.to_pandas()).dt.total_seconds(), dtype=np.float64)
    if (
        pa.types.is_integer(kind)
        or pa.types.is_floating(kind)
        or pa.types.is_boolean(kind)
        or pa.types.is_decimal(kind)
    ):
        numbers = column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False)
        return np.asarray(numbers, dtype=np.float64)
    return ["" if entry is None else str(entry) for entry in column.to_pylist()]


def _days(stamps: InstantArray) -> list[str]:
    """Dates, as they stand beside times of day."""
    return ["" if np.isnat(stamp) else str(stamp.astype("datetime64[D]")) for stamp in stamps]
