"""The emitted checks of samples beside their twin in Python: compiled here, and on the emulated Mega."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np

from gen import toolchain
from gen.avr.compile import build_elf
from gen.avr.simulator import MAILBOX_FOLDER, EmulatedChip
from gen.coefficients import Coefficients
from gen.firmware import render
from gen.firmware.context import project_context
from gen.firmware.sketch.device import device_context
from gen.lowering.lower import lower
from gen.lowering.sensors import SensorLimits, sensor_limits
from gen.reference.sensors import SensorCheck
from tests.device.variants import variant

CALLS = """
#include "my1016_sensors_state.h"
static my1016_Sensor kept[MY1016_SENSORS];
// Whether it was a call, and no sample of a channel.
static bool called(uint8_t what, uint8_t channel) {
    switch (what) {
        case 0xFF:
            my1016_sensors_begin();
            return true;
        case 0xFE:
            my1016_sensors_model_set();
            return true;
        case 0xFD:
            my1016_sensors_accept(channel);
            return true;
        case 0xFC:
            for (uint8_t i = 0; i < MY1016_SENSORS; ++i) {
                kept[i] = my1016_sensors[i];
            }
            return true;
        case 0xFB:
            for (uint8_t i = 0; i < MY1016_SENSORS; ++i) {
                my1016_sensors_restore(i, &kept[i]);
            }
            return true;
        default:
            return false;
    }
}
"""
MAIN = """
#include <stdio.h>
#include "calls.h"
int main() {
    unsigned char in[10];
    my1016_sensors_begin();
    while (fread(in, 1, sizeof in, stdin) == sizeof in) {
        if (called(in[0], in[1])) {
            continue;
        }
        uint32_t model = 0, word = 0;
        for (int i = 0; i < 4; ++i) {
            model |= (uint32_t)in[6 + i] << (8 * i);
            word |= (uint32_t)in[1 + i] << (8 * i);
        }
        const uint8_t code = my1016_sensors_check(in[0], word, in[5], (int32_t)model);
        const long value = my1016_sensors_mC(in[0]);
        const int plausible = my1016_sensors_plausible(in[0]);
        const long plausible_mC = my1016_sensors_plausible_mC(in[0]);
        const unsigned rising_mK = my1016_sensors_rising_mK(in[0]);
        const int told = code == my1016_sensors_code(in[0]) ? code : -1;
        printf("%d %ld %d %ld %u\\n", told, value, plausible, plausible_mC, rising_mK);
    }
    return 0;
}
"""
BOARD_MAIN = """
#include "mailbox.h"
#include <avr/interrupt.h>
#include "calls.h"
struct Input {
    uint8_t channel;
    uint32_t word;
    uint8_t finished;
    int32_t model_mC;
} gen_input;
struct Output {
    uint8_t code;
    int32_t value;
    uint8_t plausible;
    int32_t plausible_mC;
    uint16_t rising_mK;
} gen_output;
int main() {
    cli();
    my1016_sensors_begin();
    for (;;) {
        GEN_MAILBOX_NEXT();
        if (!called(gen_input.channel, (uint8_t)gen_input.word)) {
            const Input &in = gen_input;
            gen_output.code = my1016_sensors_check(in.channel, in.word, in.finished, in.model_mC);
            gen_output.value = my1016_sensors_mC(in.channel);
            gen_output.plausible = my1016_sensors_plausible(in.channel);
            gen_output.plausible_mC = my1016_sensors_plausible_mC(in.channel);
            gen_output.rising_mK = my1016_sensors_rising_mK(in.channel);
        }
        GEN_MAILBOX_DONE();
    }
}
"""
RECORD = np.dtype([("channel", "u1"), ("word", "<u4"), ("finished", "u1"), ("model_mC", "<i4")])
FORGET, MODEL_SET, ACCEPT, KEEP, RESTORE = 0xFF, 0xFE, 0xFD, 0xFC, 0xFB
LIMITS = SensorLimits("brush", lowest=0, highest=1000, step=5, stuck_samples=12, stuck_mK=3000)
JUDGED = np.dtype([("code", "u1"), ("mC", "<i4"), ("plausible", "u1"), ("plausible_mC", "<i4"), ("rising_mK", "<u2")])
Step = tuple[int, int, bool, int]
Judged = tuple[int, int, int, int, int]


def word(counts: int) -> int:
    return counts << 3


class Cpp:
    """The emitted checks of the MY1016 (or another), with a shorter time to being stuck, compiled for this computer."""

    def __init__(self, folder: Path, coefficients: Coefficients | None = None) -> None:
        coefficients = coefficients or variant("my1016")
        program = lower(coefficients, "fixed", "table")
        context = project_context(coefficients, program, "coeffs.json")
        device = device_context(coefficients, program)
        for chip in device["chips"]:
            chip["stuck_samples"] = min(chip["stuck_samples"], LIMITS.stuck_samples)
        told = {**context.of_model(), "device": device}
        names = ("platform.h", "sensors.h", "sensors_state.h", "sensors.cpp")
        files = render.render({f"NAME_{name}": f"lib/model/src/{name}.j2" for name in names}, told)
        for path, text in files.items():
            (folder / path).write_text(text)
        (folder / "calls.h").write_text(CALLS)
        (folder / "main.cpp").write_text(MAIN)
        self._folder = folder
        self._binary = folder / "sensors"
        flags = ["-std=gnu++11", "-O1", "-Wall", "-Wextra", "-Wconversion", "-Werror"]
        flags += ["-fsanitize=undefined,address", "-fno-sanitize-recover=all"]
        sources = [str(folder / "main.cpp"), str(folder / "my1016_sensors.cpp"), "-o", str(self._binary)]
        subprocess.run([str(toolchain.program("clang++")), *flags, *sources], check=True)
        self.limits = [
            replace(item, stuck_samples=chip["stuck_samples"])
            for item, chip in zip(sensor_limits(coefficients), device["chips"], strict=True)
        ]

    def run(self, steps: Sequence[Step]) -> list[Judged]:
        records = np.array(list(steps), dtype=RECORD)
        done = subprocess.run([str(self._binary)], input=records.tobytes(), capture_output=True, check=True)
        numbers = [int(number) for number in done.stdout.split()]
        return list(zip(*(numbers[place::5] for place in range(5)), strict=True))

    def run_on_board(self, steps: Sequence[Step]) -> tuple[list[Judged], int]:
        """The same on the emulated Mega, and the most cycles of a check."""
        records = np.array(list(steps), dtype=RECORD)
        (self._folder / "avr.cpp").write_text(BOARD_MAIN)
        sources = [self._folder / "avr.cpp", self._folder / "my1016_sensors.cpp"]
        elf = build_elf(sources, [MAILBOX_FOLDER, self._folder], self._folder / "avr.elf", optimisation="-Os")
        with EmulatedChip(elf, self._folder) as mega:
            places = [mega.memory.address(name) for name in ("gen_input", "gen_output")]
            output, cycles = mega.run_records(
                records, places[0], RECORD.itemsize, places[1], JUDGED.itemsize, len(records), len(records) * 20_000
            )
        judged = records["channel"] < RESTORE
        found = np.ascontiguousarray(output).view(JUDGED)[:, 0]
        return [tuple(row) for row in found[judged].tolist()], int(cycles[judged].max())


def by_reference(limits: Sequence[SensorLimits], steps: Sequence[Step]) -> list[Judged]:
    checks = [SensorCheck(item) for item in limits]
    kept = [SensorCheck(item) for item in limits]
    found = []
    for channel, given_word, finished, model_mC in steps:
        if channel == FORGET:
            checks = [SensorCheck(item) for item in limits]
        elif channel == MODEL_SET:
            for check in checks:
                check.model_set()
        elif channel == ACCEPT:
            checks[given_word].accept()
        elif channel == KEEP:
            kept = deepcopy(checks)
        elif channel == RESTORE:
            for check, before in zip(checks, kept, strict=True):
                check.restore(before)
        else:
            check = checks[channel]
            code = check.check(given_word, finished, model_mC)
            judged = int(code), check.temperature_mC, int(check.plausible), check.plausible_mC, check.rising_mK
            found.append(judged)
    return found
