"""Harnesses that read records and answer each with one: compiled for this computer, or on an emulated board."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gen import toolchain
from gen.arrays import RecordArray
from gen.avr.compile import sizes
from gen.avr.room import check_room
from gen.avr.simulator import MAILBOX_FOLDER, EmulatedChip
from gen.errors import CheckFailed
from gen.templating import environment
from gen.verification.runners import HOST_BUILDS, TAKEN, WARNINGS, Library, link_harness


@dataclass(frozen=True)
class Harness:
    """One pair of harnesses.

    Attributes
    ----------
    stem
        Of its templates: `stem`.h, `stem`_host.cpp, `stem`_avr.cpp.
    what
        What is compared, for people.
    cycles_per_record
        More than a board needs for one: it is taken for lost then.
    """

    stem: str
    what: str
    cycles_per_record: int = 400_000

    def write(self, library: Library) -> None:
        """Write its files beside the library's."""
        for name in ("records.h", *(f"{self.stem}{end}" for end in (".h", "_host.cpp", "_avr.cpp"))):
            template = environment("harness").get_template(f"{name}.j2")
            (library.folder / name).write_text(template.render(library.context.of_alarms()))


class HostHarness:
    """One compiler's build.

    Parameters
    ----------
    library, harness
        What is run; the harness's files are written already.
    name
        One of :data:`gen.verification.runners.HOST_BUILDS`.
    kind
        What it answers with.

    Raises
    ------
    CheckFailed
        If it does not compile.
    """

    def __init__(self, library: Library, harness: Harness, name: str, kind: np.dtype[np.void]) -> None:
        compiler, flags = HOST_BUILDS[name]
        self.name = f"{name}, {harness.what}"
        self._type = kind
        self._binary = library.folder / (f"{harness.stem}-" + "".join(c if c.isalnum() else "-" for c in name))
        command = [str(toolchain.program(compiler)), "-std=gnu++11", "-ffp-contract=off", *WARNINGS, *flags]
        command += [f"-I{library.include}", f"-I{library.folder}", str(library.folder / f"{harness.stem}_host.cpp")]
        command += [*map(str, library.sources), "-o", str(self._binary)]
        # An interrupted compiler's files go with the folder.
        done = toolchain.run(command, environment={"TMPDIR": str(library.folder)})
        if done.returncode:
            raise CheckFailed(f"{name} does not compile the emitted library:\n{done.stderr[-4000:]}")

    def run(self, inputs: RecordArray) -> RecordArray:
        """The records after every input but each lane's first, shape (L, N) of (L, N + 1).

        Raises
        ------
        CheckFailed
            If it crashes.
        """
        done = subprocess.run([str(self._binary)], input=inputs.tobytes(), capture_output=True, check=False)
        if done.returncode:
            raise CheckFailed(f"{self.name}: {done.stderr.decode(errors='replace')[-4000:]}")
        return np.frombuffer(done.stdout, dtype=self._type).reshape(inputs.shape)[:, 1:]


class AvrHarness:
    """The same on the library's emulated board, see :class:`HostHarness`.

    Parameters
    ----------
    library, harness, kind
        As there.
    cache
        The folder that keeps the emulator's compiled half.
    """

    def __init__(self, library: Library, harness: Harness, cache: Path, kind: np.dtype[np.void]) -> None:
        self.name = f"{library.chip.name} (simavr), {harness.what}"
        self._chip = library.chip
        self._type, self._cache, self._cycles = kind, cache, harness.cycles_per_record
        source = library.folder / f"{harness.stem}_avr.cpp"
        folders = [MAILBOX_FOLDER, library.include, library.folder]
        self._elf = link_harness(library, [source], folders, f"{harness.stem}.elf")

    def run(self, inputs: RecordArray) -> RecordArray:
        """The records after every input but each lane's first, shape (L, N) of (L, N + 1)."""
        flat = inputs.reshape(-1)
        with EmulatedChip(self._elf, self._cache, self._chip) as mega:
            output, _ = mega.run_records(
                flat,
                mega.memory.address("gen_input"),
                inputs.dtype.itemsize,
                mega.memory.address("gen_output"),
                self._type.itemsize,
                len(flat),
                len(flat) * self._cycles,
            )
            stack = mega.stack.use().deepest
        check_room(TAKEN, sizes(self._elf), stack, self._chip)
        return np.ascontiguousarray(output).view(self._type).reshape(inputs.shape)[:, 1:]
