"""Finds the external programs, headers and sources that verification needs.

Everything comes from Debian packages. What is missing is reported with the package that holds it. Nothing is
skipped for want of it, but for one of the two compilers of this computer, where the user did not ask for it.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from gen.errors import InputError

ARDUINO_ENVIRONMENT = "GEN_ARDUINO_AVR"
"""Environment variable that names another Arduino AVR core: a folder with ``cores`` and ``variants``."""

ARDUINO_DEFAULT = Path("/usr/share/arduino/hardware/arduino/avr")
"""Where Debian's ``arduino-core-avr`` puts the core."""

MCU = "atmega2560"

PACKAGES = {
    "avr-gcc": "gcc-avr",
    "avr-g++": "gcc-avr",
    "avr-gcc-ar": "gcc-avr",
    "avr-ar": "binutils-avr",
    "avr-nm": "binutils-avr",
    "avr-size": "binutils-avr",
    "avr-objdump": "binutils-avr",
    "avr-objcopy": "binutils-avr",
    "gcc": "gcc",
    "g++": "g++",
    "clang++": "clang",
}
"""The Debian package that holds each program."""

HOST_COMPILERS = ("g++", "clang++")
"""The compilers of this computer that the emitted library is verified with."""

_PATIENCE_S = 2.0
"""How long a killed process may stay in the system's table; without an init that collects it, it stays for ever."""


class ToolMissing(InputError):
    """A program, header or source tree that a command needs is not installed.

    Parameters
    ----------
    tool
        What is missing, by the name that its users know.
    package
        The Debian package that holds it.
    hint
        A further remedy, such as an environment variable.
    """

    def __init__(self, tool: str, package: str, *, hint: str = "") -> None:
        self.tool = tool
        self.package = package
        self.command = f"apt-get install -y {package}"
        message = f"{tool} is missing: it is in the Debian package {package}; install it with: {self.command}"
        super().__init__(f"{message} ({hint})" if hint else message)


def program(name: str) -> Path:
    """Find a program on the ``PATH``.

    Parameters
    ----------
    name
        One of the keys of `PACKAGES`.

    Raises
    ------
    ToolMissing
        When the program is not on the ``PATH``.
    """
    found = shutil.which(name)
    if found is None:
        raise ToolMissing(name, PACKAGES[name])
    return Path(found)


def run(command: Sequence[str], *, environment: Mapping[str, str] | None = None) -> subprocess.CompletedProcess[str]:
    """Run a compiler or a tool beside it, with all processes that it starts.

    A compiler's driver starts others. Where this program is interrupted they end as well, and have ended before the
    interrupt goes on: nothing writes any more into a folder that is being removed.

    Parameters
    ----------
    command
        The program and its arguments.
    environment
        Changes to the environment that it runs in.

    Returns
    -------
    CompletedProcess
        With its output and its messages as text; a failure is no exception.
    """
    process = subprocess.Popen(
        command,
        env={**os.environ, **(environment or {})},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        process_group=0,
    )
    try:
        out, told = process.communicate()
    except BaseException:
        _end(process)
        raise
    return subprocess.CompletedProcess(command, process.returncode, out, told)


def _end(process: subprocess.Popen[str]) -> None:
    """Kill a group of processes, and wait until none of them can write any more."""
    if not hasattr(os, "killpg"):  # Windows has no groups to end: what the driver started is let go
        process.kill()
        process.wait()
        return
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    patience = time.monotonic() + _PATIENCE_S
    while time.monotonic() < patience:
        try:
            os.killpg(process.pid, 0)
        except ProcessLookupError:
            return
        time.sleep(0.005)


def host_compilers(asked: Sequence[str] = ()) -> list[str]:
    """Find compilers for this computer.

    Parameters
    ----------
    asked
        Some of `HOST_COMPILERS`, each of which must be there; empty: as many as there are.

    Raises
    ------
    ToolMissing
        When one that was asked for is not on the ``PATH``, or none is.
    """
    for name in asked:
        program(name)
    found = [name for name in asked or HOST_COMPILERS if shutil.which(name) is not None]
    if not found:
        raise ToolMissing(" or ".join(HOST_COMPILERS), PACKAGES[HOST_COMPILERS[0]])
    return found


def avr_compiler(mcu: str = MCU) -> Path:
    """Find ``avr-g++`` and check that avr-libc for a chip and the AVR binutils stand beside it.

    Parameters
    ----------
    mcu
        The chip, as avr-gcc calls it.

    Raises
    ------
    ToolMissing
        When the compiler, the binutils or avr-libc are not installed.
    """
    compiler = program("avr-g++")
    program("avr-ar")
    start_file = f"crt{mcu}.o"
    answer = _output([str(compiler), f"-mmcu={mcu}", f"-print-file-name={start_file}"])
    if not Path(answer).is_absolute():
        raise ToolMissing(f"avr-libc ({start_file})", "avr-libc")
    return compiler


def arduino_core(variant: str = "mega") -> Path:
    """Find the Arduino AVR core: the folder with ``cores/arduino`` and ``variants``.

    Parameters
    ----------
    variant
        Of the board whose pins it has to have.

    Raises
    ------
    ToolMissing
        When neither the environment variable `ARDUINO_ENVIRONMENT` nor Debian's place leads to it.
    """
    named = os.environ.get(ARDUINO_ENVIRONMENT)
    root = Path(named) if named else ARDUINO_DEFAULT
    for part in ("cores/arduino/Arduino.h", f"variants/{variant}/pins_arduino.h"):
        if not (root / part).is_file():
            raise ToolMissing(
                f"the Arduino AVR core ({root / part})",
                "arduino-core-avr",
                hint=f"or let {ARDUINO_ENVIRONMENT} name a folder with cores/ and variants/",
            )
    return root


def simavr_flags() -> list[str]:
    """Check that libsimavr can be compiled against; give the linker flags that it needs.

    Raises
    ------
    ToolMissing
        When gcc, the simavr headers or its library are not installed.
    """
    compiler = str(program("gcc"))
    probe = subprocess.run(
        [compiler, "-E", "-x", "c", "-o", os.devnull, "-"],
        input="#include <simavr/sim_elf.h>\n",
        capture_output=True,
        text=True,
        check=False,
    )
    if probe.returncode != 0:
        raise ToolMissing("simavr's header simavr/sim_elf.h", "libsimavr-dev")
    if not Path(_output([compiler, "-print-file-name=libsimavr.so"])).is_absolute():
        raise ToolMissing("simavr's library libsimavr.so", "libsimavr-dev")
    return ["-lsimavr"]


def _output(command: list[str]) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
