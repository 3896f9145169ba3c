"""Builds the emulator's C half (the files in ``shim/``) and tells ctypes what its functions take."""

from __future__ import annotations

import ctypes
import hashlib
import os
import re
from functools import cache
from pathlib import Path
from typing import Any

from gen import toolchain
from gen.errors import CheckFailed
from gen.files import scratch

SHIM_FOLDER = Path(__file__).with_name("shim")
"""The folder of the C sources."""

_ABI = 7

_handle = _buffer = ctypes.c_void_p
_bytes = ctypes.c_char_p
_int, _char, _u8, _u16 = ctypes.c_int, ctypes.c_char, ctypes.c_uint8, ctypes.c_uint16
_u32, _u64, _size = ctypes.c_uint32, ctypes.c_uint64, ctypes.c_size_t
_to_u32 = ctypes.POINTER(_u32)

_SIGNATURES: dict[str, tuple[object, list[object]]] = {
    "gen_mega_abi": (_u32, []),
    # mega.c
    "gen_mega_open": (_handle, [_bytes, _bytes]),
    "gen_mega_close": (None, [_handle]),
    "gen_mega_reset": (None, [_handle, _u8, _int, _u64, _u32]),
    "gen_mega_watchdog_hz": (_int, [_handle, _u32]),
    "gen_mega_astray": (None, [_handle]),
    "gen_mega_boot_loader": (_int, [_handle, _u32, _bytes, _u32]),
    "gen_mega_message": (_bytes, [_handle]),
    "gen_mega_cycle": (_u64, [_handle]),
    "gen_mega_asleep": (_u64, [_handle]),
    "gen_mega_longest_awake": (_u64, [_handle]),
    "gen_mega_pc": (_u32, [_handle]),
    "gen_mega_sp": (_u16, [_handle]),
    "gen_mega_ramend": (_u16, [_handle]),
    "gen_mega_resets": (_u32, [_handle]),
    "gen_mega_peek": (_int, [_handle, _u32, _u32, _buffer]),
    "gen_mega_poke": (_int, [_handle, _u32, _u32, _bytes]),
    "gen_mega_run": (_int, [_handle, _u64, _bytes, _size]),
    "gen_mega_run_to": (_int, [_handle, _u64, _u32]),
    # uart.c
    "gen_mega_uart_available": (_size, [_handle]),
    "gen_mega_uart_take": (_size, [_handle, _buffer, _size]),
    "gen_mega_uart_forget": (None, [_handle]),
    "gen_mega_uart_send": (_int, [_handle, _bytes, _size, _u32]),
    # mailbox.c
    "gen_mega_run_records": (
        _int,
        [_handle, _bytes, _u32, _u32, _buffer, _u32, _u32, _u32, _buffer, _u64, _to_u32],
    ),
    # pins.c
    "gen_mega_pin_drive": (_int, [_handle, _char, _u8, _int]),
    "gen_mega_adc": (_int, [_handle, _u8, _u32]),
    "gen_mega_supply": (_int, [_handle, _u32, _u32]),
    "gen_mega_pin_read": (_int, [_handle, _char, _u8]),
    "gen_mega_probe_add": (_int, [_handle, _char, _u8]),
    "gen_mega_probe_length": (_size, [_handle, _u32]),
    "gen_mega_probe_copy": (None, [_handle, _u32, _size, _size, _buffer, _buffer]),
    # max6675.c
    "gen_mega_chip_add": (_int, [_handle, _char, _u8, _char, _u8, _char, _u8, _u64, _u8]),
    "gen_mega_chip_word": (_int, [_handle, _u32, _u32]),
    "gen_mega_chip_counts": (_int, [_handle, _u32, _to_u32, _to_u32, _to_u32]),
    # registers.c
    "gen_mega_register_chip_add": (
        _int,
        [_handle, _char, _u8, _char, _u8, _char, _u8, _char, _u8, _u64, _u8, _u8, _u8],
    ),
    "gen_mega_register_chip_data": (_int, [_handle, _u32, _u32, _int]),
    "gen_mega_register_chip_counts": (_int, [_handle, _u32, _to_u32, _to_u32]),
    "gen_mega_register_chip_forget": (_int, [_handle, _u32]),
    "gen_mega_register_chip_register": (_int, [_handle, _u32, _u8]),
    # encoder.c, wave.c
    "gen_mega_encoder_attach": (_int, [_handle, _char, _u8, _u64]),
    "gen_mega_encoder_pulses": (_int, [_handle, _u32, _u64]),
    "gen_mega_encoder_risen": (_u64, [_handle]),
    "gen_mega_wave": (_int, [_handle, _char, _u8, _u32, _u32]),
    # eeprom.c
    "gen_mega_eeprom_size": (_u16, [_handle]),
    "gen_mega_eeprom_load": (None, [_handle, _bytes]),
    "gen_mega_eeprom_save": (None, [_handle, _buffer]),
    "gen_mega_eeprom_busy": (_int, [_handle]),
    "gen_mega_eeprom_counts": (None, [_handle, _to_u32, _to_u32]),
}


class EmulationFailed(CheckFailed):
    """The firmware crashed, ended early, ran past its cycle limit or broke the mailbox protocol."""


class Handle:
    """One emulator of the shim's, open until `close`.

    Parameters
    ----------
    elf
        The firmware.
    cache_folder
        The folder that keeps the compiled shim between runs.
    mcu
        The chip, as simavr calls it.

    Raises
    ------
    ToolMissing
        When gcc or libsimavr are not installed.
    EmulationFailed
        When the shim does not compile, or the ELF file cannot be loaded.
    """

    def __init__(self, elf: Path, cache_folder: Path, mcu: str = toolchain.MCU) -> None:
        self._pointer: int | None = None
        if not elf.is_file():
            raise EmulationFailed(f"{elf}: no such firmware")
        self._library = load_shim(cache_folder)
        self._pointer = self._library.gen_mega_open(os.fsencode(elf), mcu.encode())
        if not self._pointer:
            raise EmulationFailed(f"{elf}: out of memory")
        message = self.message()
        if message:
            self.close()
            raise EmulationFailed(f"{elf}: {message}")

    def __del__(self) -> None:
        self.close()

    def close(self) -> None:
        """Free the emulator; it cannot be used afterwards. Closing twice does no harm."""
        if self._pointer:
            self._library.gen_mega_close(self._pointer)
            self._pointer = None

    def call(self, name: str, *arguments: object) -> Any:  # noqa: ANN401
        """Call ``gen_mega_<name>`` with this handle first; the C file's header says what it gives.

        Raises
        ------
        ValueError
            When the emulator is closed.
        """
        if not self._pointer:
            raise ValueError("the emulator is closed")
        return getattr(self._library, f"gen_mega_{name}")(self._pointer, *arguments)

    def message(self) -> str:
        """Give what the shim said last, empty when it had nothing to say."""
        text = bytes(self.call("message")).decode("utf-8", "replace")
        return re.sub(r"\x1b\[[0-9;]*m", "", text).strip()


@cache
def load_shim(cache_folder: Path) -> ctypes.CDLL:
    """Load the shim, compiled once and kept in a folder.

    Raises
    ------
    ToolMissing
        When gcc or libsimavr are not installed.
    EmulationFailed
        When the shim does not compile or is of another version.
    """
    library = ctypes.CDLL(str(_build(cache_folder)))
    for name, (result, arguments) in _SIGNATURES.items():
        function = getattr(library, name)
        function.restype = result
        function.argtypes = arguments
    if library.gen_mega_abi() != _ABI:
        raise EmulationFailed("shim/mega.h and shim.py are of different versions")
    return library


def _build(folder: Path) -> Path:
    flags = ["-std=gnu11", "-O2", "-shared", "-fPIC"]
    links = toolchain.simavr_flags()
    sources = sorted(SHIM_FOLDER.glob("*.c"))
    digest = hashlib.sha256("\0".join(flags + links).encode())
    for path in sorted(SHIM_FOLDER.glob("*.[ch]")):
        digest.update(path.read_bytes())
    target = folder / f"shim-{digest.hexdigest()[:16]}.so"
    if target.is_file():
        return target
    folder.mkdir(parents=True, exist_ok=True)
    with scratch("shim-", folder) as beside:
        built = beside / target.name
        command = [str(toolchain.program("gcc")), *flags, "-o", str(built), *map(str, sources), *links]
        done = toolchain.run(command)
        if done.returncode != 0:
            raise EmulationFailed(f"gcc cannot compile the emulator's shim:\n{done.stderr.strip()}")
        built.replace(target)
    return target
