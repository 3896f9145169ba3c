"""Compile C++ of a project for this computer and run it: what it prints is found, not believed."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from gen import toolchain
from gen.certificate.refuted import Refuted


@contextmanager
def scratch() -> Iterator[Path]:
    """A folder for what is compiled, gone afterwards, also when interrupted."""
    with tempfile.TemporaryDirectory(prefix="gen-check-") as folder:
        yield Path(folder)


def printed(folder: Path, sources: Sequence[Path], flags: Sequence[str]) -> str:
    """Compile sources in a scratch folder, run the program, and give what it prints.

    Parameters
    ----------
    folder
        Of :func:`scratch`.
    sources, flags
        For g++.

    Raises
    ------
    ToolMissing
        If there is no g++.
    Refuted
        If it does not compile, or the program fails; it says why in a last line ``failed WHY``.
    """
    program = folder / "program"
    made = toolchain.run(
        [str(toolchain.program("g++")), *flags, "-o", str(program), *map(str, sources)],
        environment={"TMPDIR": str(folder)},  # an interrupted compiler's files go with the folder
    )
    if made.returncode:
        raise Refuted(f"the library does not compile: {made.stderr.strip().splitlines()[0]}")
    ran = subprocess.run([str(program)], capture_output=True, text=True, check=False)
    if ran.returncode:
        last = ran.stdout.rstrip().rpartition("\n")[2]
        what = last.removeprefix("failed ") if last.startswith("failed ") else f"it ends with {ran.returncode}"
        raise Refuted(f"the C++ does not do what the proof is about: {what}")
    return ran.stdout
