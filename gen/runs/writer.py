"""Writing run files, and other columns in their form: complete or not at all."""

from __future__ import annotations

from collections.abc import Mapping
from io import TextIOWrapper
from pathlib import Path

from gen.arrays import FloatArray, IntArray
from gen.files import replacing
from gen.runs.run import Run


def write_run(path: Path | str, run: Run) -> None:
    """Write a run file; numbers in the shortest form that reads back the same.

    Parameters
    ----------
    path
        The CSV file; it appears complete or not at all.
    run
        The run.

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    write_columns(path, run.columns(), run.comments)


def write_columns(
    path: Path | str,
    columns: Mapping[str, FloatArray | IntArray],
    comments: Mapping[str, str] | None = None,
) -> None:
    """Write any columns in the form of a run file, NaN as an empty field.

    Parameters
    ----------
    path
        The CSV file; it appears complete or not at all.
    columns
        By name, in order, all of one length.
    comments
        Written first, as ``# key: value``.

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    head = comment_lines(comments or {})
    for name in columns:
        if "\n" in name or "\r" in name or not name or set(name) & set(',"#') or name != name.strip():
            raise ValueError(f"{name!r} cannot be a column's name")
    import pandas as pd  # slow to import: reading does without

    with replacing(Path(path)) as stream:
        lines = TextIOWrapper(stream, encoding="utf-8", newline="")
        lines.write(head)
        pd.DataFrame(dict(columns)).to_csv(lines, index=False, lineterminator="\n")
        lines.detach()


def comment_lines(comments: Mapping[str, str]) -> str:
    """Give the lines that come before a run's header: ``# key: value``, and ``# key`` where nothing is said of it.

    Raises
    ------
    ValueError
        When a line break, or a colon in a key, would make something else of them.
    """
    for text in (f"{key}{value}" for key, value in comments.items()):
        if "\n" in text or "\r" in text:
            raise ValueError(f"a line break in {text!r} would break the file")
    if any(":" in key for key in comments):
        raise ValueError("a comment's key ends at its first colon, so it cannot hold one")
    return "".join(f"# {key}: {value}\n" if value else f"# {key}\n" for key, value in comments.items())
