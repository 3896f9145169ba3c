"""Run the emitted library: compiled for this computer, or on an emulated board."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gen import toolchain
from gen.arrays import IntArray, RecordArray
from gen.avr.chip import MEGA, Chip
from gen.avr.compile import (
    CPP_FLAGS,
    OPTIMISATION,
    BuildFailed,
    Sizes,
    build_elf,
    compile_objects,
    machine_flags,
    sizes,
    undefined_symbols,
)
from gen.avr.room import OVERFLOW, check_room
from gen.avr.simulator import MAILBOX_FOLDER, MARKER_OVERHEAD, EmulatedChip
from gen.errors import CheckFailed
from gen.firmware.context import LibraryContext
from gen.lowering.program import Program
from gen.reference.board import record_type
from gen.templating import environment
from gen.verification.profiles import Profile
from gen.verification.profiles import record_type as input_type

WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Werror")
_SANITIZE = ("-O1", "-g", "-fsanitize=undefined,address", "-fno-sanitize-recover=all")
#: The host's builds: name -> compiler and flags. No contraction: the board has no fused multiply-add.
HOST_BUILDS: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "g++ -O2": ("g++", ("-O2",)),
    "clang++ -O2": ("clang++", ("-O2",)),
    "g++ sanitized": ("g++", _SANITIZE),
    "clang++ sanitized": ("clang++", _SANITIZE),
}
_CYCLES_PER_RECORD = 400_000


@dataclass(frozen=True)
class Library:
    """The emitted library's files in a folder, with what the harnesses need beside them; and for which chip."""

    program: Program
    context: LibraryContext
    folder: Path
    sources: tuple[Path, ...]
    chip: Chip = MEGA

    @property
    def include(self) -> Path:
        """Folder of the library's headers."""
        return self.folder / "lib" / self.context.name / "src"


def write_library(
    program: Program, context: LibraryContext, files: Mapping[str, str], folder: Path, chip: Chip = MEGA
) -> Library:
    """Write the library's files and both harnesses below a folder."""
    sources = []
    for path, text in files.items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text)
        if target.suffix == ".cpp":
            sources.append(target)
    harness = {
        **context.of_model(),
        "record_size": record_type(program).itemsize,
        "input_size": input_type(len(program.channels)).itemsize,
    }
    for name in ("verify_host.cpp", "verify_avr.cpp"):
        text = environment("harness").get_template(f"{name}.j2").render(harness)
        (folder / name).write_text(text)
    return Library(program, context, folder, tuple(sources), chip)


class HostRunner:
    """One compiler's build of the library."""

    def __init__(self, library: Library, name: str) -> None:
        compiler, flags = HOST_BUILDS[name]
        self.name = name
        self._library = library
        self._binary = library.folder / ("host-" + "".join(c if c.isalnum() else "-" for c in name))
        command = [
            str(toolchain.program(compiler)),
            "-std=gnu++11",
            "-ffp-contract=off",
            *WARNINGS,
            *flags,
            f"-I{library.include}",
            str(library.folder / "verify_host.cpp"),
            *map(str, library.sources),
            "-o",
            str(self._binary),
        ]
        # An interrupted compiler's files go with the folder.
        done = toolchain.run(command, environment={"TMPDIR": str(library.folder)})
        if done.returncode:
            raise CheckFailed(f"{name} does not compile the emitted library:\n{done.stderr[-4000:]}")

    def run(self, profile: Profile) -> RecordArray:
        """Everything after every sample, shape (L, N).

        Raises
        ------
        CheckFailed
            If the program ends early: a sanitizer's finding, for instance.
        """
        done = subprocess.run([str(self._binary)], input=profile.records().tobytes(), capture_output=True, check=False)
        if done.returncode:
            raise CheckFailed(f"{self.name}: {done.stderr.decode(errors='replace')[-4000:]}")
        return np.frombuffer(done.stdout, dtype=record_type(self._library.program)).reshape(profile.pwm.shape)


TAKEN = "the emitted library and its test take"


def link_harness(library: Library, sources: Sequence[Path], include_dirs: Sequence[Path], name: str) -> Path:
    """Link the emitted library and a harness for the library's chip, as PlatformIO does.

    Raises
    ------
    BuildFailed
        If they do not compile.
    CheckFailed
        If they take more flash or RAM than the chip's board has, with the sizes.
    """
    elf = library.folder / name
    made = [*sources, *library.sources]
    try:
        build_elf(made, include_dirs, elf, link_time=True, chip=library.chip)
    except BuildFailed as failed:
        if OVERFLOW not in str(failed):
            raise
        build_elf(made, include_dirs, elf, link_time=True, chip=library.chip, any_size=True)
        check_room(TAKEN, sizes(elf), 0, library.chip)
        raise
    check_room(TAKEN, sizes(elf), 0, library.chip)
    return elf


@dataclass(frozen=True)
class Cost:
    """What the model costs on the board's chip.

    Attributes
    ----------
    cycles_constant, cycles_change
        Most cycles of one step at constant PWM, and with a change of it; the ambient as before, where it has dynamics.
    cycles_constant_mean
        Mean at constant PWM.
    flash_bytes, ram_bytes
        Of the model alone: the library linked to an empty program, less the empty program.
    stack_bytes
        Deepest stack below the caller.
    cycles_ambient
        Most cycles of one step and of telling it another ambient, where its changes pass the dynamics.
    """

    cycles_constant: int
    cycles_constant_mean: float
    cycles_change: int
    flash_bytes: int
    ram_bytes: int
    stack_bytes: int
    cycles_ambient: int | None = None


class AvrRunner:
    """The library on the emulated board, compiled with PlatformIO's flags: it is what users run that is measured."""

    def __init__(self, library: Library, cache: Path) -> None:
        self.name = f"{library.chip.name} (simavr)"
        self._library = library
        self._cache = cache
        name = library.context.name
        harness = library.folder / "verify_avr.cpp"
        self._elf = link_harness(library, [harness], [MAILBOX_FOLDER, library.include], "model.elf")
        empty = library.folder / "empty.cpp"
        empty.write_text("int main() { for (;;) { } }\n")
        self._empty = build_elf([empty], [], library.folder / "empty.elf", link_time=True, chip=library.chip)
        self._model = f"{name}_model"
        self.cycles: IntArray = np.zeros(0, dtype=np.int64)
        self.stack_bytes = 0

    def run(self, profile: Profile) -> RecordArray:
        """Everything after every sample, shape (L, N); keeps the cycles of each in :attr:`cycles`."""
        records = profile.records()
        layout = record_type(self._library.program)
        with EmulatedChip(self._elf, self._cache, self._library.chip) as mega:
            model = mega.memory.symbol(self._model)
            if model.size != layout.itemsize:
                raise CheckFailed(f"the board's structure has {model.size} bytes, the reference's {layout.itemsize}")
            output, cycles = mega.run_records(
                records,
                mega.memory.address("gen_input"),
                records.dtype.itemsize,
                mega.memory.address(self._model),
                layout.itemsize,
                len(records),
                len(records) * _CYCLES_PER_RECORD,
            )
            self.stack_bytes = mega.stack.use().deepest
        check_room(TAKEN, self.sizes(), self.stack_bytes, self._library.chip)
        lanes, length = profile.pwm.shape
        self.cycles = cycles.astype(np.int64).reshape(lanes, length + 1)[:, 1:] - MARKER_OVERHEAD
        frame = np.ascontiguousarray(output).view(layout).reshape(lanes, length + 1)
        return frame[:, 1:]

    def cost(self, profile: Profile) -> Cost:
        """Cost over the last run, which was of this profile."""
        magnitude = np.abs(profile.pwm)
        changed = np.ones(magnitude.shape, dtype=bool)
        changed[:, 1:] = magnitude[:, 1:] != magnitude[:, :-1]
        same_command = np.zeros(magnitude.shape, dtype=bool)
        same_command[:, 1:] = profile.pwm[:, 1:] == profile.pwm[:, :-1]
        retold = np.zeros(magnitude.shape, dtype=bool)
        if profile.channels is not None and self._library.program.ambient is not None:
            retold = profile.channels[:, 1:, 0] != profile.channels[:, :-1, 0]
        held = self.cycles[same_command & ~retold]
        used, empty = sizes(self._elf), sizes(self._empty)
        harness = profile.records().dtype.itemsize
        return Cost(
            cycles_constant=int(held.max()),
            cycles_constant_mean=round(float(held.mean()), 1),
            cycles_change=int(self.cycles[changed & ~retold].max()),
            flash_bytes=used.flash - empty.flash,
            ram_bytes=used.ram - empty.ram - harness,
            stack_bytes=self.stack_bytes,
            cycles_ambient=int(self.cycles[retold].max()) if retold.any() else None,
        )

    def helper_symbols(self) -> list[str]:
        """Compiler helpers for 64-bit or float arithmetic that the library's objects call."""
        return forbidden_helpers(self._library)

    def sizes(self) -> Sizes:
        """Flash and RAM of the verification program."""
        return sizes(self._elf)


_FORBIDDEN = ("di3", "sf2", "sf3", "sfsi", "sfdi", "sisf", "unsisf", "divsf", "mulsf", "addsf", "subsf")


def forbidden_helpers(library: Library) -> list[str]:
    """Names of 64-bit and float helpers that the library's object files refer to."""
    (library.folder / "objects").mkdir(exist_ok=True)
    flags = [*machine_flags(library.chip), *CPP_FLAGS, OPTIMISATION, f"-I{library.include}"]
    objects = compile_objects(list(library.sources), library.folder / "objects", flags)
    names: set[str] = set()
    for item in objects:
        names.update(undefined_symbols(item))
    return sorted(name for name in names if name.startswith("__") and _is_forbidden(name))


def _is_forbidden(name: str) -> bool:
    if name in ("__umulhisi3", "__mulhisi3", "__usmulhisi3", "__muluhisi3", "__mulshisi3"):
        return False
    return any(part in name for part in _FORBIDDEN)
