"""A run as the bytes of a Parquet file, and back: columns as in its run file, all else in the file's metadata.

Any reader of Parquet sees the run file's columns under the run file's names. What a column means to the model
(component, ambient, other) and the comments stand as JSON under one key of the schema's metadata, so that what is read
back is the same run, every bit of every number included.
"""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Mapping
from typing import Any, BinaryIO

import numpy as np

from gen.errors import InputError
from gen.runs import AMBIENT, Run

KEY = b"gen.run"
VERSION = 1


def content_hash(run: Run) -> str:
    """Give the SHA-256 of a run's columns and comments: the same run has the same, whatever its file is called."""
    digest = hashlib.sha256(json.dumps(_said(run), sort_keys=True).encode())
    for name, values in run.columns().items():
        digest.update(f"{name}:{values.dtype.str}:{values.size};".encode())
        digest.update(np.ascontiguousarray(values).tobytes())
    return digest.hexdigest()


def to_bytes(run: Run) -> bytes:
    """Write a run; the same run gives the same bytes."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = run.columns()
    table = pa.table({name: pa.array(values, from_pandas=False) for name, values in columns.items()})
    table = table.replace_schema_metadata({KEY: json.dumps(_said(run), sort_keys=True).encode()})
    buffer = io.BytesIO()
    pq.write_table(table, buffer, compression="zstd")
    return buffer.getvalue()


def from_bytes(data: bytes, file: str) -> Run:
    """Read a run.

    Parameters
    ----------
    data
        What :func:`to_bytes` wrote.
    file
        Where it comes from, for messages.

    Raises
    ------
    InputError
        When it is no run of a store.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.ParquetFile(io.BytesIO(data)).read()
        said = json.loads((table.schema.metadata or {})[KEY])
        if said["version"] != VERSION:
            raise InputError(f"found version {said['version']}, expected {VERSION}", file=file, place=KEY.decode())
        return _run(said, {name: table.column(name).to_numpy() for name in table.column_names})
    except (pa.ArrowException, OSError, KeyError, ValueError, TypeError) as error:
        raise InputError(f"is no run of a store: {error}", file=file) from error


def comments_from(stream: BinaryIO, file: str) -> dict[str, str]:
    """Give a run's comments; of a file that can be sought in only its end is read.

    Raises
    ------
    InputError
        When it is no run of a store.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        return dict(json.loads((pq.read_schema(stream).metadata or {})[KEY])["comments"])
    except (pa.ArrowException, OSError, KeyError, ValueError, TypeError) as error:
        raise InputError(f"is no run of a store: {error}", file=file) from error


def _said(run: Run) -> dict[str, Any]:
    """What of a run stands beside its columns."""
    return {
        "version": VERSION,
        "components": list(run.temps),
        "ambient": run.ambient is not None,
        "comments": list(run.comments.items()),
        "rows_in_file": run.rows_in_file,
        "doubted": list(run.doubted),
    }


def _run(said: Mapping[str, Any], columns: dict[str, np.ndarray[Any, Any]]) -> Run:
    known = {name: np.array(values) for name, values in columns.items()}  # arrow's own memory is not writable
    time_s, pwm = known.pop("time_s"), known.pop("pwm")
    temps = {name: known.pop(f"{name}_degC") for name in said["components"]}
    ambient = known.pop(AMBIENT) if said["ambient"] else None
    return Run(
        time_s=time_s,
        pwm=pwm,
        temps=temps,
        ambient=ambient,
        extras=known,
        comments=dict(said["comments"]),
        rows_in_file=said["rows_in_file"],
        doubted=tuple(said["doubted"]),
    )
