"""Reading coefficient files and runs, and runs that were made in memory."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gen.errors import InputError
from gen.interface.arguments import a_path
from gen.interface.model import Model

if TYPE_CHECKING:
    import pandas as pd

RunLike = Any
"""A run file's path, or a frame as :func:`read_run` gives it."""


def load(path: Path | str) -> Model:
    """Read and check a coefficient file.

    Parameters
    ----------
    path
        The JSON file.

    Raises
    ------
    InputError
        With the file, the JSON path (or line and column), what was found and what was expected.

    Examples
    --------
    >>> import gen
    >>> gen.load("examples/my1016/coeffs.json")
    Model('my1016', 4 parts: brush, bearing, magnet, casing)
    """
    from gen.coefficients import load as read

    file = a_path("path", path)
    coefficients = read(file)
    return Model(coefficients, file.read_text(encoding="utf-8-sig"), file)


def read_run(path: Path | str) -> pd.DataFrame:
    """Read a run file as a frame with the run file's own columns.

    Parameters
    ----------
    path
        The CSV file.

    Returns
    -------
    pandas.DataFrame
        Indexed by ``time_s`` (s): ``pwm`` (counts, -255..255, held until the next row), ``<component>_degC`` (degC) and
        the other columns of the file with their units in the names; NaN where a sample is missing. ``attrs`` holds the
        comment lines, and the file's name as ``name``.

    Raises
    ------
    InputError
        With file, line and column of the first fault.

    Examples
    --------
    >>> import gen
    >>> run = gen.read_run("examples/measured/tclab/apm_2nd_mimo_heater1.csv")
    >>> list(run.columns)
    ['pwm', 'sensor1_degC', 'ambient_degC', 'heater2_percent']
    """
    import pandas as pd

    from gen.runs import read_run as read

    run = read(a_path("path", path))
    frame = pd.DataFrame(run.columns()).set_index("time_s")
    frame.attrs |= {**run.comments, "name": Path(path).stem}
    return frame


@contextmanager
def run_files(runs: Sequence[RunLike]) -> Iterator[list[Path]]:
    """Run files of runs that may be frames: these are written for as long as the context lasts.

    A frame goes through the reader like any file, so that one definition of what a run is holds for both.

    Parameters
    ----------
    runs
        Paths, or frames indexed by ``time_s`` (or with a column of that name) that have ``pwm``.

    Raises
    ------
    InputError
        If something is neither, or a frame has no time.
    """
    with tempfile.TemporaryDirectory(prefix="gen-") as folder:
        paths = []
        for number, run in enumerate(runs, start=1):
            if isinstance(run, (str, Path)):
                paths.append(Path(run))
                continue
            path = Path(folder) / f"{_name(run, number)}.csv"
            if path.exists():
                path = path.with_stem(f"{path.stem}_{number}")
            _write(run, number, path)
            paths.append(path)
        try:
            yield paths
        except InputError as error:
            file = error.file
            if file is not None and Path(file).parent == Path(folder):
                file = f"frame {Path(file).stem}"
            message = error.message.replace(f"{folder}/", "frame ")
            raise InputError(message, file=file, place=error.place) from error


def _name(frame: RunLike, number: int) -> str:
    given = str(getattr(frame, "attrs", {}).get("name", f"run_{number}"))
    return "".join(c if c.isalnum() or c in "-_." else "_" for c in given) or f"run_{number}"


def _one_line(value: object) -> str:
    return " ".join(str(value).split())


def _write(frame: RunLike, number: int, path: Path) -> None:
    import pandas as pd

    from gen.runs import comment_lines

    if not isinstance(frame, pd.DataFrame):
        raise InputError(f"run {number} is a {type(frame).__name__}; expected a path or a pandas DataFrame")
    if "time_s" not in frame.columns:
        if frame.index.name != "time_s":
            raise InputError(f"run {number}: expected an index or a column named time_s")
        frame = frame.reset_index()
    # Attributes are anybody's: each becomes one line, and one whose name no comment can have is not a run's.
    said = {_one_line(key): _one_line(value) for key, value in frame.attrs.items() if key != "name"}
    lines = comment_lines({key: value for key, value in said.items() if ":" not in key})
    path.write_text(lines + frame.to_csv(index=False, lineterminator="\n"), encoding="utf-8")
