"""Write files so that an interruption leaves either the old or the new ones, never half of them."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path

from gen.errors import InputError

#: A folder without this file was not written by this tool and is not replaced.
MARK = "manifest.json"


def write_text(path: Path, text: str) -> None:
    """Write one UTF-8 file beside its place, then rename it."""
    write_bytes(path, text.encode())


def write_bytes(path: Path, data: bytes) -> None:
    """Write one file beside its place, then rename it."""
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            Path(name).chmod(0o644)
            Path(name).replace(path)
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", file=str(path)) from error


def check_writable(path: Path) -> None:
    """Find out before long work that a file could not be written at its end.

    Raises
    ------
    InputError
        If the path is a folder, or its folder is missing or takes no new file.
    """
    if path.is_dir():
        raise InputError("is a folder; expected the name of a file", file=str(path))
    try:
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", file=str(path)) from error


def replace_folder(folder: Path, files: Mapping[str, str]) -> None:
    """Put a new tree in a folder's place; an old one by this tool is removed.

    Parameters
    ----------
    folder
        The tree's root.
    files
        Relative path -> text.

    Raises
    ------
    InputError
        If the folder exists and was not written by this tool, or cannot be written.
    """
    if folder.exists() and (not folder.is_dir() or (any(folder.iterdir()) and not (folder / MARK).is_file())):
        raise InputError("exists and was not written by gen; choose another --out or remove it", file=str(folder))
    staging: Path | None = None
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        staging = Path(tempfile.mkdtemp(dir=folder.parent, prefix=f".{folder.name}."))
        for path, text in files.items():
            target = staging / "new" / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text, encoding="utf-8")
        if folder.exists():
            folder.rename(staging / "old")
            try:
                (staging / "new").rename(folder)
            except BaseException:
                (staging / "old").rename(folder)
                raise
        else:
            (staging / "new").rename(folder)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", file=str(folder)) from error
    finally:
        if staging is not None:
            shutil.rmtree(staging, ignore_errors=True)
