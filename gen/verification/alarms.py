"""Prove the emitted alarm rules equal to their reference: temperatures, timers, sums and alarms after every sample."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gen import toolchain
from gen.avr.compile import build_elf
from gen.avr.simulator import MAILBOX_FOLDER, EmulatedMega
from gen.errors import CheckFailed
from gen.lowering.alarms import LoweredRule
from gen.templating import environment
from gen.verification.alarm_campaign import AlarmCampaign, alarm_profile, campaign
from gen.verification.compare import Mismatch, first_mismatch
from gen.verification.runners import HOST_BUILDS, WARNINGS, Library

Integers = NDArray[np.int64]
Records = NDArray[np.void]
_HARNESSES = ("verify_alarms.h", "verify_alarms_host.cpp", "verify_alarms_avr.cpp")
_CYCLES_PER_RECORD = 400_000


class HostAlarms:
    """One compiler's build of the model with its rules."""

    def __init__(self, library: Library, name: str, given: AlarmCampaign) -> None:
        compiler, flags = HOST_BUILDS[name]
        self.name = f"{name}, outputs and alarms"
        self._type = given.expected.dtype
        self._binary = library.folder / ("alarms-" + "".join(c if c.isalnum() else "-" for c in name))
        command = [str(toolchain.program(compiler)), "-std=gnu++11", "-ffp-contract=off", *WARNINGS, *flags]
        command += [f"-I{library.include}", f"-I{library.folder}", str(library.folder / "verify_alarms_host.cpp")]
        command += [*map(str, library.sources), "-o", str(self._binary)]
        # An interrupted compiler's files go with the folder.
        done = toolchain.run(command, environment={"TMPDIR": str(library.folder)})
        if done.returncode:
            raise CheckFailed(f"{name} does not compile the emitted alarms:\n{done.stderr[-4000:]}")

    def run(self, inputs: Records) -> Records:
        """The records after every input, shape (L, N)."""
        done = subprocess.run([str(self._binary)], input=inputs.tobytes(), capture_output=True, check=False)
        if done.returncode:
            raise CheckFailed(f"{self.name}: {done.stderr.decode(errors='replace')[-4000:]}")
        return np.frombuffer(done.stdout, dtype=self._type).reshape(inputs.shape)[:, 1:]


class AvrAlarms:
    """The model with its rules on the emulated Mega."""

    def __init__(self, library: Library, cache: Path, given: AlarmCampaign) -> None:
        self.name = "ATmega2560 (simavr), outputs and alarms"
        self._type, self._cache = given.expected.dtype, cache
        self._elf = build_elf(
            [library.folder / "verify_alarms_avr.cpp", *library.sources],
            [MAILBOX_FOLDER, library.include, library.folder],
            library.folder / "alarms.elf",
            link_time=True,
        )

    def run(self, inputs: Records) -> Records:
        """The records after every input, shape (L, N)."""
        flat = inputs.reshape(-1)
        with EmulatedMega(self._elf, self._cache) as mega:
            output, _ = mega.run_records(
                flat,
                mega.memory.address("gen_input"),
                inputs.dtype.itemsize,
                mega.memory.address("gen_output"),
                self._type.itemsize,
                len(flat),
                len(flat) * _CYCLES_PER_RECORD,
            )
        return np.ascontiguousarray(output).view(self._type).reshape(inputs.shape)[:, 1:]


def compare_alarms(
    library: Library,
    rules: Sequence[LoweredRule],
    lanes: int,
    length: int,
    hosts: Sequence[str],
    *,
    board: bool,
) -> Iterator[tuple[str, AlarmCampaign, Mismatch | None]]:
    """Run the campaign on each target: its name, what was compared, and the first difference.

    Parameters
    ----------
    library
        The emitted library, written to a folder.
    rules
        The lowered rules; without any, the temperatures alone are compared.
    lanes, length
        Of the campaign.
    hosts
        Which of :data:`gen.verification.runners.HOST_BUILDS` to run.
    board
        Whether to run the emulated Mega.
    """
    _write_harnesses(library)
    given = campaign(library.program, rules, alarm_profile(library.program, rules, lanes, length))
    runners: list[Callable[[], HostAlarms | AvrAlarms]] = [partial(HostAlarms, library, name, given) for name in hosts]
    if board:
        runners.append(partial(AvrAlarms, library, library.folder / "cache", given))
    for make in runners:
        runner = make()
        yield runner.name, given, first_mismatch(given.expected, runner.run(given.inputs))


def _write_harnesses(library: Library) -> None:
    for name in _HARNESSES:
        text = environment("harness").get_template(f"{name}.j2").render(library.context.of_alarms())
        (library.folder / name).write_text(text)
