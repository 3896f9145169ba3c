"""Write files so that an interruption leaves either the old or the new ones, never half of them."""

from __future__ import annotations

import hashlib
import json
import os
import secrets
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from gen.errors import InputError
from gen.interruption import interrupts_wait

#: A folder without this file was not written by this tool and is not replaced.
MARK = "manifest.json"
#: What a project holds and its manifest does not list.
_UNLISTED = ("report.html", "verification.json")
#: What PlatformIO and its editor put into a project.
_MADE_AGAIN = (".pio", ".vscode")
_TABLES = (b"PK\x03\x04", b"PAR1", b"MATLAB ", b"\x89HDF", b"\xd0\xcf\x11\xe0", b"\x1f\x8b")
"""How workbooks, Parquet, MATLAB and packed files begin."""
_LOGS = {".csv", ".tsv", ".txt", ".log", ".dat", ".asc", ".lvm", ".json", ".jsonl", ".ndjson"}
_HEAD_BYTES = 65_536
_LONGEST_HEAD = 10_000
"""Lines before the header of a run file, events among them, beyond which none is looked for."""


def write_text(path: Path, text: str) -> None:
    """Write one UTF-8 file as :func:`replacing` does."""
    write_bytes(path, text.encode())


def write_bytes(path: Path, data: bytes) -> None:
    """Write one file as :func:`replacing` does."""
    with replacing(path) as stream:
        stream.write(data)


@contextmanager
def scratch(prefix: str, parent: Path | None = None) -> Iterator[Path]:
    """Give a folder that goes with the block, also where an interrupt comes in the moment in which it is made.

    Its name is chosen before it is there, so that whatever happens from then on ends in its removal.
    :class:`tempfile.TemporaryDirectory` knows its name only some instructions after.

    Parameters
    ----------
    prefix
        Of its name.
    parent
        Where; by default where the system keeps such folders.
    """
    if parent is None:
        with interrupts_wait():  # asked for the first time, Python tries the place with a file of its own
            parent = Path(tempfile.gettempdir())
    folder = parent / f"{prefix}{secrets.token_hex(8)}"
    try:
        folder.mkdir(mode=0o700)
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


@contextmanager
def replacing(path: Path) -> Iterator[IO[bytes]]:
    """Write beside the file and rename, so that a reader never sees half of it.

    A link stays, and what it leads to is replaced. A pipe, a terminal or a device (``/dev/null``) is written to.

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    special = _special(path)
    target = path if special else path.resolve()
    beside = target if special else target.with_name(f".{target.name}.{os.getpid()}.tmp")
    try:
        if target.is_dir():
            raise InputError("is a folder; expected the name of a file", file=str(path))
        try:
            with beside.open("wb") as stream:
                yield stream
            if not special:
                beside.replace(target)
        finally:
            if not special:
                beside.unlink(missing_ok=True)
    except OSError as error:
        named = error.filename if isinstance(error.filename, str) else None
        if named is not None and Path(named) not in (beside, target):
            raise  # of another file that the block opened
        raise InputError(f"cannot be written: {error.strerror or error}", file=str(path)) from error


def _special(path: Path) -> bool:
    # Asked of the path itself: /dev/stdout of a pipeline leads to no name that could be looked up.
    return path.exists() and not path.is_file() and not path.is_dir()


def check_writable(path: Path) -> None:
    """Find out before long work that a file could not be written at its end.

    Raises
    ------
    InputError
        If the path is a folder, or its folder is missing or takes no new file.
    """
    target = path.resolve()
    if target.is_dir():
        raise InputError("is a folder; expected the name of a file", file=str(path))
    if _special(path):
        return
    try:
        with tempfile.TemporaryFile(dir=target.parent):
            pass
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", file=str(path)) from error


def shown_name(path: Path) -> str:
    """A file's name as comments of the C++ can hold it: a name may have line ends and bytes that are no text."""
    return "".join(c if c.isprintable() and c != "\\" else "?" for c in path.name)


def check_outputs(written: Iterable[Path | None], read: Iterable[Path]) -> None:
    """Find out before long work that files cannot be written at its end, or that one would take another's place.

    Nor may one take that of a measured run or of a logger's own file: these cannot be made again.

    Parameters
    ----------
    written
        What the command is to write; None for what was not asked for.
    read
        What it reads and must not overwrite.

    Raises
    ------
    InputError
        With the first such file.
    """
    inputs = {path.resolve() for path in read}
    seen: set[Path] = set()
    for path in written:
        if path is None:
            continue
        check_writable(path)
        target = path.resolve()
        if target in inputs:
            raise InputError("is read by this command and would be overwritten; expected another name", file=str(path))
        if target in seen and not _special(path):
            raise InputError("is given twice as a file to write; expected another name", file=str(path))
        if holds_measured_run(path):
            raise InputError("holds a measured run and would be overwritten; expected another name", file=str(path))
        if _may_be_a_log(path):
            raise InputError("may be a logger's file and would be overwritten; expected another name", file=str(path))
        seen.add(target)


def holds_measured_run(path: Path) -> bool:
    """Whether a file is a run file with temperatures, and none that `gen emulate` wrote.

    Only its comments and its header are read.
    """
    if not path.is_file():
        return False
    with path.open(encoding="utf-8-sig", errors="replace") as stream:
        for _, line in zip(range(_LONGEST_HEAD), stream, strict=False):
            if line.startswith("# emulated:"):
                return False
            if not line.startswith("#") and line.strip():
                columns = [name.strip() for name in line.split(",")]
                return {"time_s", "pwm"} <= set(columns) and any(name.endswith("_degC") for name in columns)
    return False


def _may_be_a_log(path: Path) -> bool:
    """Whether a file is of a kind that loggers write and this tool does not, by what stands first in it."""
    if not path.is_file():
        return False
    with path.open("rb") as stream:
        head = stream.read(_HEAD_BYTES)
    if head.startswith(_TABLES):
        return True
    lines = [line for line in head.decode("utf-8", errors="replace").splitlines() if line.strip()]
    if not lines or path.suffix.casefold() not in _LOGS:
        return False
    if lines[0].lstrip().startswith("{"):
        return len(lines) > 1 and lines[1].startswith("{")  # an object a line
    first = next((line for line in lines if not line.startswith("#")), "time_s")
    return not first.startswith(("time_s", "<"))


def replace_folder(folder: Path, files: Mapping[str, str], *, force: bool = False) -> None:
    """Put a new tree in a folder's place; an old one by this tool is removed.

    Parameters
    ----------
    folder
        The tree's root.
    files
        Relative path -> text.
    force
        Whether files of the old tree may be lost that were edited since this tool wrote them.

    Raises
    ------
    InputError
        If the folder exists and was not written by this tool, holds anything else or edited files, or cannot be
        written.
    """
    named, folder = folder, folder.resolve()
    try:
        _check_replaceable(folder, named, force)
        folder.parent.mkdir(parents=True, exist_ok=True)
        with scratch(f".{folder.name}.", folder.parent) as staging:
            for path, text in files.items():
                target = staging / "new" / path
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_text(text, encoding="utf-8", newline="\n")  # as the manifest's hashes are
            _exchange(staging / "new", folder, staging / "old")
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", file=str(named)) from error


def _exchange(new: Path, folder: Path, old: Path) -> None:
    """Put a finished tree where it belongs; what was there goes aside, and comes back where that fails."""
    if not folder.exists():
        new.rename(folder)
        return
    folder.rename(old)
    try:
        new.rename(folder)
    except BaseException:
        old.rename(folder)
        raise


def _check_replaceable(folder: Path, named: Path, force: bool) -> None:
    """Nothing but what this tool wrote, or what PlatformIO makes again, may be lost."""
    if not folder.exists():
        return
    if folder in (Path.cwd(), *Path.cwd().parents):
        raise InputError("holds the current folder; choose another --out", file=str(named))
    if not folder.is_dir():
        raise InputError("exists and is no folder; choose another --out", file=str(named))
    if not any(folder.iterdir()):
        return
    written = _written_files(folder)
    if written is None:
        raise InputError("exists and was not written by gen; choose another --out or remove it", file=str(named))
    for path in sorted(folder.rglob("*")):
        place = path.relative_to(folder)
        if place.parts[0] in _MADE_AGAIN or path.is_dir():
            continue
        if place.as_posix() not in written:
            raise InputError(
                f"holds {place}, which gen did not write; move it or choose another --out", file=str(named)
            )
        digest = written[place.as_posix()]
        if not force and digest is not None and hashlib.sha256(path.read_bytes()).hexdigest() != digest:
            raise InputError(
                f"holds {place}, which was edited since gen wrote it; choose another --out or use --force",
                file=str(named),
            )


def _written_files(folder: Path) -> dict[str, str | None] | None:
    """A tree's files with the SHA-256 that its manifest lists, if any; None for a folder of somebody else."""
    try:
        manifest = json.loads((folder / MARK).read_text(encoding="utf-8"))
        if not str(manifest["tool"]).startswith("gen "):
            return None
        return {MARK: None, **dict.fromkeys(_UNLISTED), **manifest["files"]}
    except (OSError, ValueError, LookupError, TypeError):
        return None
