"""Files to tables, by what stands in them and not by their names."""

from __future__ import annotations

import gc
import gzip
import io
import zipfile
import zlib
from pathlib import Path

from gen.errors import InputError
from gen.importing.table import Reading, Table

_MOST_BYTES = 2 << 30
_FOREIGN = {
    b"\xd0\xcf\x11\xe0": "is an old Excel workbook (.xls); save it as .xlsx or CSV",
    b"\x1f\x9d": "is compressed by compress; unpack it",
    b"BZh": "is compressed by bzip2; unpack it",
    b"\xfd7zXZ": "is compressed by xz; unpack it",
    b"%PDF": "is a PDF; expected a log",
    b"\x7fELF": "is a program; expected a log",
}
_TAR = 257
"""Where a tar archive says that it is one."""


def read_tables(file: Path, given: Reading) -> list[Table]:
    """Read all tables of a file.

    Parameters
    ----------
    file
        CSV of any dialect, a serial capture, JSON lines, Excel, Parquet, MATLAB; text may be packed by gzip.
    given
        What need not be guessed of a text file.

    Raises
    ------
    InputError
        With the file, the place, what was found and what was expected.
    """
    collecting = gc.isenabled()
    gc.disable()  # millions of cells are made and none of them is in a circle: looking for those takes half of the time
    try:
        return _tables(file, _content(file), given)
    except InputError as error:
        raise InputError(error.message, file=str(file), place=error.place) from error.__cause__
    finally:
        if collecting:
            gc.enable()


def _content(file: Path) -> bytes:
    try:
        if file.is_dir():
            raise InputError("this is a directory; expected a log")
        if file.exists() and not file.is_file():
            raise InputError("this is no file; expected a log")
        data = file.read_bytes()
    except FileNotFoundError:
        raise InputError("there is no such file; expected a log") from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}") from None
    if not data.startswith(b"\x1f\x8b"):
        return data
    try:
        with gzip.open(file) as stream:
            unpacked = stream.read(_MOST_BYTES + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(f"cannot be unpacked: {error}") from None
    if len(unpacked) > _MOST_BYTES:
        raise InputError("unpacks to more than 2 GiB; expected a smaller file")
    return unpacked


def _tables(file: Path, data: bytes, given: Reading) -> list[Table]:
    if not data.strip():
        raise InputError("is empty; expected a log")
    for magic, message in _FOREIGN.items():
        if data.startswith(magic):
            raise InputError(message)
    if data.startswith(b"ustar", _TAR):
        raise InputError("is a tar archive; unpack it")
    if data.startswith(b"PK\x03\x04") and not _is_workbook(data):
        raise InputError("is a zip archive and no workbook; unpack it")
    if data.startswith(b"\x89HDF"):
        raise InputError(
            "is an HDF5 file, which is not read; write its table as CSV or Parquet, or of MATLAB's by save('log.mat', "
            "..., '-v7')"
        )
    if data.startswith(b"PK\x03\x04"):
        from gen.importing.reading.workbook import read_workbook

        return read_workbook(file, data, given.sheet)
    if given.sheet:
        raise InputError(f'is no workbook; expected one with the sheet "{given.sheet}"')
    if data.startswith(b"PAR1"):
        from gen.importing.reading.parquet import read_parquet

        return [read_parquet(file, data)]
    if data.startswith(b"MATLAB ") or file.suffix.casefold() == ".mat":
        from gen.importing.reading.matlab import read_matlab

        return [read_matlab(file, data)]
    from gen.importing.reading.text import read_text

    return [read_text(file, data, given)]


def _is_workbook(data: bytes) -> bool:
    """Whether a zip archive is Excel's; a broken one may be."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = archive.namelist()
    except (zipfile.BadZipFile, ValueError, OSError):
        return True
    return "[Content_Types].xml" in names or "mimetype" in names
