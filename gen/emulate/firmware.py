"""From a coefficient file to the firmware's ELF file, kept between runs."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gen.avr.chip import BOARDS, Chip
from gen.avr.compile import OPTIMISATION, ArduinoCore, BuildFailed, build_elf, sizes
from gen.avr.room import OVERFLOW, check_room
from gen.coefficients import Coefficients
from gen.files import scratch
from gen.firmware.boards import BOARDS as FIRMWARE_BOARDS
from gen.firmware.project import project_files
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.lower import lower

SEAL = "seal.py"
"""The project's script that writes into a program what it sums up to."""


STACK_BYTES = 256
"""What the deepest stack may take, beside what the self test wants untouched (`STACK_RESERVE` in `config.h`)."""


@dataclass(frozen=True)
class Firmware:
    """A built firmware: the ``elf``, and the ``cache`` folder that holds it, the core and the emulator's shim."""

    elf: Path
    cache: Path


def cache_folder() -> Path:
    """Give the folder for what can be built again: ``$XDG_CACHE_HOME/gen``, by default ``~/.cache/gen``."""
    named = os.environ.get("XDG_CACHE_HOME")
    return (Path(named) if named else Path.home() / ".cache") / "gen"


def build_firmware(
    coefficients: Coefficients,
    arithmetic: Arithmetic,
    schedule: ScheduleKind,
    source_name: str,
    cache: Path,
) -> Firmware:
    """Emit the project of a coefficient file and compile it as PlatformIO does, unless that was done before.

    Parameters
    ----------
    coefficients, arithmetic, schedule
        What to emit, as `gen build` does.
    source_name
        The coefficient file's name.
    cache
        The folder that keeps what was built.

    Raises
    ------
    ToolMissing
        When the compiler or the core is not installed.
    BuildFailed
        When the project does not compile.
    CheckFailed
        When the board has no room for it, with the sizes.
    """
    program = lower(coefficients, arithmetic, schedule)
    files = project_files(coefficients, program, source_name, None)
    library = f"lib/{coefficients.name}/src/"
    wanted = {path: text for path, text in files.items() if path.startswith(("src/", library))}
    chip, reserve = BOARDS[coefficients.document.board], FIRMWARE_BOARDS[coefficients.document.board].stack_reserve
    core = ArduinoCore(cache, link_time=True, chip=chip)
    digest = hashlib.sha256(f"{files[SEAL]} {core.folder.name} {OPTIMISATION} link time".encode())
    for path, text in sorted(wanted.items()):
        digest.update(f"{path}\0{text}\0".encode())
    elf = cache / f"firmware-{digest.hexdigest()[:16]}.elf"
    if not elf.is_file():
        with scratch("project-", cache) as folder:
            for path, text in wanted.items():
                target = folder / path
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_text(text, encoding="utf-8")
            sources = [folder / path for path in wanted if path.endswith(".cpp")]
            linked = _linked(sources, [folder / "src", folder / library], folder / "linked.elf", core, chip, reserve)
            (folder / SEAL).write_text(files[SEAL], encoding="utf-8")
            subprocess.run([sys.executable, str(folder / SEAL), str(linked)], check=True, capture_output=True)
            linked.replace(elf)
    return Firmware(elf, cache)


def _linked(
    sources: Sequence[Path], include_dirs: Sequence[Path], elf: Path, core: ArduinoCore, chip: Chip, reserve: int
) -> Path:
    def build(*, any_size: bool) -> Path:
        return build_elf(sources, include_dirs, elf, core=core, link_time=True, chip=chip, any_size=any_size)

    try:
        build(any_size=False)
    except BuildFailed as failed:
        if OVERFLOW not in str(failed):
            raise
        build(any_size=True)
    check_room("the sketch and its stack take", sizes(elf), STACK_BYTES + reserve, chip)
    return elf
