"""The emitted library compiled for this computer: model and sensor checks on the words that a board would read.

What the sketch around it does in a sample is repeated here; interrupts, clock, EEPROM and serial line a host does not
have.
"""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Self

from gen import toolchain
from gen.coefficients import Coefficients
from gen.emulate.plants.plant import AMBIENT
from gen.errors import CheckFailed
from gen.firmware.project import project_files
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.lower import lower
from gen.lowering.program import Program

_GLUE = """
#include "{name}.h"
#include "{name}_model.h"
#include <string.h>
extern "C" unsigned gen_state_bytes(void) {{ return sizeof {name}_model.state; }}
extern "C" void gen_state_get(unsigned char *bytes) {{ memcpy(bytes, &{name}_model.state, sizeof {name}_model.state); }}
extern "C" void gen_state_put(const unsigned char *bytes, int16_t pwm) {{
    memcpy(&{name}_model.state, bytes, sizeof {name}_model.state);
    {name}_resume(pwm);
}}
"""
_FLAGS = ("-std=gnu++11", "-O2", "-shared", "-fPIC", "-ffp-contract=off", "-Wall", "-Wextra", "-Wconversion", "-Werror")


class HostDevice:
    """One firmware's library, just begun.

    Parameters
    ----------
    coefficients, arithmetic, schedule
        What is emitted.

    Raises
    ------
    CheckFailed
        When the compiler refuses the emitted code.
    """

    def __init__(
        self, coefficients: Coefficients, arithmetic: Arithmetic = "fixed", schedule: ScheduleKind = "table"
    ) -> None:
        document = coefficients.document
        self._name = document.name
        self._components = document.component_names
        self.channels = [chip.channel for chip in (document.wiring.thermocouples if document.wiring else ())]
        self._folder = tempfile.TemporaryDirectory()
        program = lower(coefficients, arithmetic, schedule)
        self._library = _compiled(coefficients, program, Path(self._folder.name))
        self._tells = bool(program.channels)
        self._ambient_mC = round((document.ambient.fixed_degC or 25.0) * 1000.0)
        self._call("begin")
        self._call("sensors_begin")
        self.started = False

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._folder.cleanup()

    def sample(self, words: Mapping[str, int], pwm: int, *, finished: bool = True) -> dict[str, tuple[int, float]]:
        """Take a sample as the sketch does: checks, then the model with the PWM that acted.

        Parameters
        ----------
        words
            What each MAX6675 sends.
        pwm
            Over the sample that ends now.
        finished
            Whether the conversions had the time that they need.

        Returns
        -------
        dict
            By channel: the check's code, and the last believed temperature in degC.
        """
        found = {}
        told_mC = self._ambient_mC
        for number, channel in enumerate(self.channels):
            part = self._components.index(channel) if channel in self._components else None
            model_mC = self._call("temperature_mC", part, told_mC) if part is not None else 0
            code = self._call("sensors_check", number, words[channel], int(finished), model_mC)
            value_mC = self._call("sensors_mC", number)
            if channel == AMBIENT and code == 0:
                self._ambient_mC = value_mC
            found[channel] = (code, value_mC / 1000.0)
        if self._tells:
            self._call("channel", 0, self._ambient_mC)
        if self.started:
            self._call("step", pwm)
        elif all(code == 0 for code, _ in found.values()):
            self._start(found)
        return found

    def temperature_mC(self, component: int) -> int:
        """What the model gives for a component, by its place, in thousandths of a degree Celsius."""
        return self._call("temperature_mC", component, self._ambient_mC)

    @property
    def state(self) -> bytes:
        """The model's states as they would go to EEPROM."""
        buffer = (ctypes.c_uint8 * self._library.gen_state_bytes())()
        self._library.gen_state_get(buffer)
        return bytes(buffer)

    def resume(self, state: bytes, pwm: int) -> None:
        """Begin anew, and go on from kept states."""
        self._call("begin")
        self._library.gen_state_put(state, pwm)
        self._call("sensors_begin")

    def step(self, pwm: int) -> None:
        """Move the model alone."""
        self._call("step", pwm)

    def _start(self, found: Mapping[str, tuple[int, float]]) -> None:
        for number, name in enumerate(self._components):
            rise_mK = round(found[name][1] * 1000.0) - self._ambient_mC if name in found else 0
            self._call("start", number, rise_mK)
        self._call("sensors_model_set")
        self.started = True

    def _call(self, function: str, *arguments: int) -> int:
        result: int = getattr(self._library, f"{self._name}_{function}")(*arguments)
        return result


def _compiled(coefficients: Coefficients, program: Program, folder: Path) -> ctypes.CDLL:
    name = coefficients.document.name
    files = project_files(coefficients, program, "coeffs.json", None)
    inside = f"lib/{name}/src/"
    sources = [folder / "glue.cpp"]
    sources[0].write_text(_GLUE.format(name=name))
    for path, text in files.items():
        if path.startswith(inside):
            target = folder / path.removeprefix(inside)
            target.write_text(text)
            if target.suffix == ".cpp":
                sources.append(target)
    library = folder / "host.so"
    command = [str(toolchain.program("g++")), *_FLAGS, f"-I{folder}", *map(str, sources), "-o", str(library)]
    done = toolchain.run(command)
    if done.returncode:
        raise CheckFailed(f"g++ does not compile the emitted library:\n{done.stderr[-4000:]}")
    loaded = ctypes.CDLL(str(library))
    u8, i16, u16, i32 = ctypes.c_uint8, ctypes.c_int16, ctypes.c_uint16, ctypes.c_int32
    signatures: dict[str, tuple[object, list[object]]] = {
        "begin": (None, []),
        "start": (None, [u8, i32]),
        "step": (None, [i16]),
        "temperature_mC": (i32, [u8, i32]),
        "sensors_begin": (None, []),
        "sensors_model_set": (None, []),
        "sensors_check": (u8, [u8, u16, u8, i32]),
        "sensors_mC": (i32, [u8]),
    }
    for function, (result, arguments) in signatures.items():
        found = getattr(loaded, f"{name}_{function}")
        found.restype, found.argtypes = result, arguments
    if program.channels:
        told = getattr(loaded, f"{name}_channel")
        told.restype, told.argtypes = None, [u8, i32]
    loaded.gen_state_bytes.restype = ctypes.c_uint
    return loaded
