"""Compiles C++ for an Arduino's chip, with or without the real Arduino core, and reads what came out."""

from __future__ import annotations

import hashlib
import subprocess
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from gen import toolchain
from gen.avr.chip import MEGA, Chip
from gen.errors import CheckFailed
from gen.files import scratch

SRAM_OFFSET = 0x800000
"""Where the GNU linker places SRAM in the one address space of an AVR ELF file."""


def machine_flags(chip: Chip) -> tuple[str, ...]:
    """What the compiler is told of the board."""
    return (
        f"-mmcu={chip.mcu}",
        "-DF_CPU=16000000UL",
        "-DARDUINO=10807",
        f"-D{chip.define}",
        "-DARDUINO_ARCH_AVR",
        "-ffunction-sections",
        "-fdata-sections",
    )


OPTIMISATION = "-Os"
"""How PlatformIO compiles for the board (platform-atmelavr, `builder/frameworks/arduino.py`), so how users do."""
LINK_TIME_FLAGS = ("-flto", "-fno-fat-lto-objects")
"""The rest of it: optimised once more when all is linked, where calls between files are inlined."""
LINK_TIME_LINKER_FLAGS = ("-flto", "-fuse-linker-plugin")
ANY_SIZE_LINKER_FLAGS = ("-Wl,--defsym=__TEXT_REGION_LENGTH__=0x800000", "-Wl,--defsym=__DATA_REGION_LENGTH__=0xF000")
CPP_FLAGS = ("-std=gnu++11", "-fno-exceptions", "-fno-threadsafe-statics")
C_FLAGS = ("-std=gnu11",)
WARNING_FLAGS = ("-Wall", "-Wextra", "-Wconversion", "-Werror")
# avr-gcc 5.4 lacks DECIMAL_DIG in C++, which the core's WString.cpp uses.
CORE_FLAGS = ("-w", "-DDECIMAL_DIG=__DECIMAL_DIG__")
QUIET_IN_CORE = (
    "-Wconversion",
    "-Wextra",
    "-Wignored-qualifiers",
    "-Wmissing-field-initializers",
    "-Wsign-compare",
    "-Wtype-limits",
    "-Wunused-function",
    "-Wunused-parameter",
    "-Wunused-variable",
)
"""Warnings that the headers of the Arduino core and its libraries may cause."""

JOBS = 2


class BuildFailed(CheckFailed):
    """The compiler or linker rejected a source file; the message holds its output."""


@dataclass(frozen=True)
class Symbol:
    """One symbol of an object or ELF file.

    Parameters
    ----------
    name
        Its linker name (C++ names are mangled).
    address
        Its address in bytes as the linker counts: flash from 0, SRAM from `SRAM_OFFSET`.
    size
        Its size in bytes; 0 when the file does not tell.
    kind
        The letter of ``nm``: T code, D and B data, W weak, A absolute, capitals for global.
    """

    name: str
    address: int
    size: int
    kind: str


@dataclass(frozen=True)
class Sizes:
    """What a firmware occupies: ``flash`` and static ``ram`` (without stack and heap), both in bytes."""

    flash: int
    ram: int


class ArduinoCore:
    """The real Arduino core for a board, compiled once into a static library.

    Parameters
    ----------
    cache
        The folder that keeps the library between runs. Its name there tells flags, compiler and core apart.
    optimisation
        The compiler's optimisation flag for the core.
    link_time
        Compile it for optimisation at link time, as PlatformIO does.
    chip
        The board's.

    Raises
    ------
    ToolMissing
        When the compiler or the core is not installed.
    BuildFailed
        When the core does not compile.
    """

    def __init__(
        self, cache: Path, *, optimisation: str = OPTIMISATION, link_time: bool = False, chip: Chip = MEGA
    ) -> None:
        self.root = toolchain.arduino_core(chip.variant)
        self._flags = (*machine_flags(chip), optimisation, *(LINK_TIME_FLAGS if link_time else ()), *CORE_FLAGS)
        self._own_folders = (self.root / "cores/arduino", self.root / "variants" / chip.variant)
        compiler = toolchain.avr_compiler()
        self._sources = sorted(path for path in self._own_folders[0].rglob("*") if path.suffix in (".c", ".cpp", ".S"))
        self.folder = cache / f"arduino-core-{self._key(compiler)}"
        self.archive = self.folder / "core.a"
        if not self.archive.is_file():
            self._build()

    def library(self, name: str) -> Path:
        """Give the include folder of a library that comes with the core, such as ``EEPROM``.

        Raises
        ------
        FileNotFoundError
            When the core has no such library.
        """
        folder = self.root / "libraries" / name / "src"
        if not folder.is_dir():
            raise FileNotFoundError(f"the Arduino core has no library {name}: {folder}")
        return folder

    def include_flags(self) -> list[str]:
        """Compiler flags under which ``#include <Arduino.h>`` works and causes no warnings.

        They belong before all other include folders. Neither ``-isystem`` nor a system_header pragma will do,
        because avr-gcc takes system headers for C: so a folder of wrappers comes first, which switch the
        warnings off around the real header.
        """
        return [f"-I{folder}" for folder in (self.folder / "quiet", *self._own_folders)]

    def _key(self, compiler: Path) -> str:
        version = subprocess.run([str(compiler), "--version"], capture_output=True, text=True, check=True).stdout
        digest = hashlib.sha256("\0".join((version, str(self.root), *self._flags, *CPP_FLAGS, *QUIET_IN_CORE)).encode())
        for folder in self._own_folders:
            for path in sorted(folder.rglob("*")):
                if path.is_file():
                    digest.update(str(path.relative_to(folder)).encode() + b"\0" + path.read_bytes())
        return digest.hexdigest()[:16]

    def _build(self) -> None:
        self.folder.parent.mkdir(parents=True, exist_ok=True)
        with scratch("core-", self.folder.parent) as beside:
            stage = beside / "core"
            stage.mkdir()
            self._write_quiet_headers(stage / "quiet")
            includes = [f"-I{folder}" for folder in self._own_folders]
            objects = compile_objects(self._sources, stage, [*self._flags, *includes])
            # avr-gcc-ar also lists the symbols of objects that only optimisation at link time turns into code.
            _run([str(toolchain.program("avr-gcc-ar")), "rcs", str(stage / "core.a"), *map(str, objects)])
            for path in objects:
                path.unlink()
            try:
                stage.rename(self.folder)
            except OSError:  # another process was faster
                if not self.archive.is_file():
                    raise

    def _write_quiet_headers(self, folder: Path) -> None:
        folder.mkdir()
        headers = [path for own in self._own_folders for path in own.glob("*.h")]
        headers += self.root.glob("libraries/*/src/*.h")
        ignored = "".join(f'#pragma GCC diagnostic ignored "{warning}"\n' for warning in QUIET_IN_CORE)
        push, pop = "#pragma GCC diagnostic push\n", "#pragma GCC diagnostic pop\n"
        for path in headers:
            text = f"{push}{ignored}#include_next <{path.name}>\n{pop}"
            (folder / path.name).write_text(text, encoding="utf-8")


def build_elf(
    sources: Sequence[Path],
    include_dirs: Sequence[Path],
    out: Path,
    *,
    core: ArduinoCore | None = None,
    optimisation: str = OPTIMISATION,
    link_time: bool = False,
    defines: Sequence[str] = (),
    own_warnings: bool = True,
    chip: Chip = MEGA,
    any_size: bool = False,
) -> Path:
    """Compile sources for a board's chip and link them.

    Parameters
    ----------
    sources
        C++, C, assembler (``.S``) or Arduino (``.ino``) files. An ``.ino`` file gets ``Arduino.h`` as the IDE
        does it, but no generated prototypes.
    include_dirs
        Folders of the sources' own headers.
    out
        The ELF file to write.
    core
        The Arduino core to link with; without it the sources bring their own ``main``.
    optimisation
        The compiler's optimisation flag; PlatformIO's by default.
    link_time
        Optimise once more when all is linked, as PlatformIO does.
    defines
        Macros, as ``NAME`` or ``NAME=VALUE``.
    own_warnings
        Whether the sources have to compile under `WARNING_FLAGS`.
    chip
        For which, as the core.
    any_size
        Link it even where the chip has no room for it: to see what it takes.

    Returns
    -------
    Path
        ``out``.

    Raises
    ------
    ToolMissing
        When avr-gcc, avr-libc or the binutils are not installed.
    BuildFailed
        When a source does not compile or the program does not link.
    """
    toolchain.avr_compiler(chip.mcu)
    flags = [*machine_flags(chip), optimisation, *(LINK_TIME_FLAGS if link_time else ())]
    flags += [f"-D{item}" for item in defines]
    flags += WARNING_FLAGS if own_warnings else ("-w",)
    if core is not None:
        flags += core.include_flags()
    flags += [f"-I{folder}" for folder in include_dirs]
    out.parent.mkdir(parents=True, exist_ok=True)
    with scratch("objects-", out.parent) as beside:
        objects = [str(path) for path in compile_objects(sources, beside, flags)]
        archives = [] if core is None else [str(core.archive)]
        linked = beside / "linked.elf"
        link = [str(toolchain.avr_compiler()), f"-mmcu={chip.mcu}", optimisation, "-Wl,--gc-sections"]
        link += LINK_TIME_LINKER_FLAGS if link_time else ()
        link += ANY_SIZE_LINKER_FLAGS if any_size else ()
        _run([*link, "-o", str(linked), *objects, *archives, "-lm"])
        linked.replace(out)
    return out


def compile_objects(sources: Sequence[Path], folder: Path, flags: Sequence[str]) -> list[Path]:
    """Compile each source into an object file in ``folder``, two at a time.

    Raises
    ------
    ToolMissing
        When avr-gcc, avr-libc or the binutils are not installed.
    BuildFailed
        When a source does not compile.
    """
    compiler = str(toolchain.avr_compiler())

    def compile_one(place: tuple[int, Path]) -> Path:
        index, source = place
        target = folder / f"{index:03}-{source.name}.o"
        _run([compiler, *flags, *_language(source), "-c", str(source), "-o", str(target)])
        return target

    with ThreadPoolExecutor(JOBS) as pool:
        return list(pool.map(compile_one, enumerate(sources)))


def symbols(binary: Path) -> list[Symbol]:
    """List the defined symbols of an object or ELF file, by address.

    Raises
    ------
    ToolMissing
        When ``avr-nm`` is not installed.
    BuildFailed
        When the file is no object or ELF file.
    """
    found = []
    for line in _nm(binary, "--defined-only", "--format=posix"):
        name, kind, address, *size = line.split()
        found.append(Symbol(name, int(address, 16), int(size[0], 16) if size else 0, kind))
    return sorted(found, key=lambda symbol: (symbol.address, symbol.name))


def undefined_symbols(binary: Path) -> list[str]:
    """List the names that an object file needs from elsewhere (``__mulsf3`` betrays a float product).

    Raises
    ------
    ToolMissing
        When ``avr-nm`` is not installed.
    BuildFailed
        When the file is no object or ELF file.
    """
    return sorted(line.split()[0] for line in _nm(binary, "--undefined-only", "--format=posix"))


def sizes(elf: Path) -> Sizes:
    """Measure the flash and static RAM that an ELF file occupies, in bytes.

    Raises
    ------
    ToolMissing
        When ``avr-size`` is not installed.
    BuildFailed
        When the file is no ELF file.
    """
    output = _run([str(toolchain.program("avr-size")), "-A", str(elf)])
    rows = (line.split() for line in output.splitlines())
    section = {row[0]: int(row[1]) for row in rows if len(row) == 3 and row[0].startswith(".")}
    data = section.get(".data", 0)
    return Sizes(
        flash=section.get(".text", 0) + data,
        ram=data + section.get(".bss", 0) + section.get(".noinit", 0),
    )


def _language(source: Path) -> list[str]:
    if source.suffix == ".ino":
        return [*CPP_FLAGS, "-x", "c++", "-include", "Arduino.h"]
    if source.suffix == ".c":
        return [*C_FLAGS, "-x", "c"]
    if source.suffix == ".S":
        return ["-x", "assembler-with-cpp"]
    return [*CPP_FLAGS, "-x", "c++"]


def _nm(binary: Path, *options: str) -> list[str]:
    output = _run([str(toolchain.program("avr-nm")), *options, str(binary)])
    return [line for line in output.splitlines() if line.strip()]


def _run(command: list[str]) -> str:
    done = toolchain.run(command, environment={"LC_ALL": "C"})
    if done.returncode != 0:
        name = Path(command[0]).name
        detail = (done.stderr or done.stdout).strip() or f"exit status {done.returncode}"
        raise BuildFailed(f"{name} failed:\n{detail}")
    return done.stdout
