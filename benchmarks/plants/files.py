"""Run files, as a user's logger writes them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def write(
    path: Path, columns: Mapping[str, FloatArray | NDArray[np.int64]], comments: Mapping[str, str] | None = None
) -> None:
    """Write a run file.

    Parameters
    ----------
    path
        Where.
    columns
        By their names in the file; NaN is a missing sample.
    comments
        Lines `# key: value` at its head.
    """
    fields = [_fields(name, np.asarray(values)) for name, values in columns.items()]
    rows = "\n".join(map(",".join, zip(*fields, strict=True)))
    head = "".join(f"# {key}: {value}\n" for key, value in (comments or {}).items())
    path.write_text(f"{head}{','.join(columns)}\n{rows}\n", encoding="utf-8")


def _fields(name: str, values: NDArray[np.generic]) -> list[str]:
    """A column's fields; each value that occurs is printed once."""
    digits = ".2f" if name.endswith("_degC") else ".5g" if name != "time_s" else ".12g"
    distinct, where = np.unique(values, return_inverse=True)
    words = np.array(["" if value != value else format(value, digits) for value in distinct.tolist()], dtype=object)
    found: list[str] = words[where].tolist()
    return found
