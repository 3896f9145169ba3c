"""Compile a rival as the emitted library is compiled, and run it here and on the emulated Mega."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.rivals.code.catalogue import SOURCES, Made, Rival
from gen import toolchain
from gen.avr.compile import BuildFailed, Sizes, build_elf, sizes
from gen.avr.simulator import MAILBOX_FOLDER, MARKER_OVERHEAD, EmulatedChip
from gen.model import ThermalModel
from gen.verification.profiles import Profile, record_type

Words = NDArray[np.generic]
PARTS = 4
_CYCLES_PER_RECORD = 400_000


@dataclass(frozen=True)
class OnBoard:
    """What ran on the emulated Mega.

    Attributes
    ----------
    words
        The rival's outputs after each sample, shape (L, N, 4).
    cycles
        Of each step, shape (L, N).
    size
        Of the rival alone: the program less an empty one and the harness's input.
    stack_bytes
        The deepest stack below the caller.
    """

    words: Words
    cycles: NDArray[np.int64]
    size: Sizes
    stack_bytes: int


class Program:
    """One rival's sources in a folder of their own.

    Raises
    ------
    LibraryMissing
        When what generates a part of it is not installed.
    """

    def __init__(self, rival: Rival, model: ThermalModel, folder: Path) -> None:
        self._rival = rival
        self._folder = folder
        self._made: Made = rival.make(model, folder)
        self._dtype = np.dtype("<f4" if rival.word == "float" else "<i4")
        self._defines = (f"RIVAL_WORD={rival.word}", *self._made.defines)
        self._sources = [SOURCES / rival.source, *self._made.sources]
        self._includes = [SOURCES, *self._made.includes]

    def rises_K(self, words: Words) -> NDArray[np.float64]:
        """Rises that the words stand for, K, same shape."""
        return np.asarray(words, dtype=np.float64) * self._rival.unit_K

    def on_board(self, profile: Profile, cache: Path) -> OnBoard:
        """Run all lanes on the emulated Mega, compiled with PlatformIO's flags.

        Raises
        ------
        BuildFailed
            When it does not compile, or not cleanly where it has to.
        ToolMissing
            When a tool is not installed.
        """
        elf = build_elf(
            [SOURCES / "harness_avr.cpp", *self._sources],
            [MAILBOX_FOLDER, *self._includes],
            self._folder / "rival.elf",
            link_time=True,
            defines=self._defines,
            own_warnings=self._rival.clean,
        )
        records = profile.records()
        size = PARTS * self._dtype.itemsize
        with EmulatedChip(elf, cache) as mega:
            output, cycles = mega.run_records(
                records,
                mega.memory.address("gen_input"),
                records.dtype.itemsize,
                mega.memory.address("rival_rise"),
                size,
                len(records),
                len(records) * _CYCLES_PER_RECORD,
            )
            stack = mega.stack.use().deepest
        lanes, length = profile.pwm.shape
        words = np.ascontiguousarray(output).view(self._dtype).reshape(lanes, length + 1, PARTS)[:, 1:]
        spent = cycles.astype(np.int64).reshape(lanes, length + 1)[:, 1:] - MARKER_OVERHEAD
        return OnBoard(words, spent, self._alone(elf), stack)

    def on_host(self, profile: Profile) -> Words:
        """Run all lanes compiled by g++ for this computer, shape (L, N, 4).

        Raises
        ------
        BuildFailed
            When it does not compile, or not cleanly where it has to.
        ToolMissing
            When g++ is not installed.
        """
        binary = self._folder / "rival"
        warnings = ("-Wall", "-Wextra", "-Wconversion", "-Werror") if self._rival.clean else ("-w",)
        flags = ["-O2", "-ffp-contract=off", *warnings, *(f"-D{item}" for item in self._defines)]
        flags += [f"-I{folder}" for folder in self._includes]
        objects = []
        for number, source in enumerate([SOURCES / "harness_host.cpp", *self._sources]):
            target = self._folder / f"host-{number}.o"
            language = ["-std=gnu11", "-x", "c"] if source.suffix == ".c" else ["-std=gnu++11", "-x", "c++"]
            self._compiled([*flags, *language, "-c", str(source), "-o", str(target)])
            objects.append(str(target))
        self._compiled([*objects, "-o", str(binary), "-lm"])
        done = subprocess.run([str(binary)], input=profile.records().tobytes(), capture_output=True, check=True)
        lanes, length = profile.pwm.shape
        return np.frombuffer(done.stdout, dtype=self._dtype).reshape(lanes, length + 1, PARTS)[:, 1:]

    def _compiled(self, arguments: list[str]) -> None:
        done = toolchain.run([str(toolchain.program("g++")), *arguments], environment={"TMPDIR": str(self._folder)})
        if done.returncode:
            raise BuildFailed(f"g++ does not compile {self._rival.source}:\n{done.stderr[-4000:]}")

    def _alone(self, elf: Path) -> Sizes:
        nothing = self._folder / "empty.cpp"
        nothing.write_text("int main() { for (;;) { } }\n")
        empty = sizes(build_elf([nothing], [], self._folder / "empty.elf", link_time=True))
        used = sizes(elf)
        return Sizes(used.flash - empty.flash, used.ram - empty.ram - record_type(0).itemsize)
