"""A log whose numbers are known, and how other loggers would have written it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from gen.interface import Import, import_runs
from gen.runs import Run, read_run


def truth(rows: int = 120, step: float = 0.5) -> pd.DataFrame:
    """Run-file columns; temperatures in whole tenths, so that every way of writing them is exact."""
    time = np.arange(rows) * step
    pwm = np.where(np.arange(rows) < rows * 2 // 3, 204, 0)
    winding = np.round(21.5 + 40.0 * (1.0 - np.exp(-time / 20.0)), 1)
    casing = np.round(21.0 + 15.0 * (1.0 - np.exp(-time / 45.0)), 1)
    ambient = np.round(21.0 + 0.1 * (np.arange(rows) // 50), 1)
    return pd.DataFrame(
        {"time_s": time, "pwm": pwm, "winding_degC": winding, "casing_degC": casing, "ambient_degC": ambient}
    )


def take(path: Path, out: Path, **options: object) -> Import:
    """Import one file."""
    return import_runs([path], out, **options)  # type: ignore[arg-type]


def taken(path: Path, out: Path, **options: object) -> Run:
    """Import one file that becomes one run."""
    found = take(path, out, **options)
    assert len(found.runs) == 1
    return read_run(found.runs[0])


def same(run: Run, frame: pd.DataFrame, parts: dict[str, str] | None = None) -> None:
    """Every number of a frame, to the last digit that 1e-9 shows; `parts` gives other names of columns."""
    columns = run.columns()
    for name in frame:
        found = columns[(parts or {}).get(str(name), str(name))]
        np.testing.assert_allclose(found, frame[name].to_numpy(), rtol=0, atol=1e-9, err_msg=str(name))


TRUE = truth()


def csv(frame: pd.DataFrame = TRUE, **options: object) -> str:
    return str(frame.to_csv(index=False, lineterminator="\n", **options))  # type: ignore[call-overload]


def write(tmp_path: Path, text: str, encoding: str = "utf-8", name: str = "log.csv") -> Path:
    path = tmp_path / name
    path.write_bytes(text.encode(encoding))
    return path
