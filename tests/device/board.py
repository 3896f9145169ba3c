"""The emulated board with thermocouples, and its serial line as rows."""

from __future__ import annotations

import subprocess
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from gen import toolchain
from gen.coefficients import Coefficients
from gen.emulate.scenario import converters
from gen.emulate.wiring.devices import DeviceBoard, ResetCause

OPEN, ZEROS, ONES = 0x0004, 0x0000, 0xFFFF
#: The sketch's flags (`device.h`).
LATE, DROPPED, STALL, MEMORY = 0x100, 0x200, 0x400, 0x800
AMBIENT, STOPPED, NOISY = 0x1000, 0x2000, 0x4000
TEMPERATURES = {"brush": 61.25, "bearing": 55.5, "magnet": 52.0, "casing": 50.75, "ambient": 24.5}


def program_crc(elf: Path, scratch: Path) -> str:
    """CRC-32 of the flash image of a program without the four bytes that may hold it, as hexadecimal digits."""
    image = scratch / "image.bin"
    subprocess.run([str(toolchain.program("avr-objcopy")), "-O", "binary", str(elf), str(image)], check=True)
    names = subprocess.run([str(toolchain.program("avr-nm")), str(elf)], check=True, capture_output=True, text=True)
    (seal,) = [int(line.split()[0], 16) for line in names.stdout.splitlines() if line.endswith(" gen_seal")]
    flash = image.read_bytes()
    return f"{zlib.crc32(flash[:seal] + flash[seal + 4 :]):08X}"


def word(celsius: float) -> int:
    return round(celsius * 4) << 3


@dataclass
class Said:
    """What came over the serial line: rows by column, events and the comments of the header."""

    columns: list[str] = field(default_factory=list)
    rows: list[dict[str, str]] = field(default_factory=list)
    events: list[str] = field(default_factory=list)
    comments: dict[str, str] = field(default_factory=dict)

    def numbers(self, column: str) -> list[float]:
        return [float(row[column]) for row in self.rows if row[column]]


class Board(DeviceBoard):
    """A Mega with the sensor chips of a coefficient file, each at 30 degC until told otherwise."""

    def __init__(self, elf: Path, cache: Path, coefficients: Coefficients | None) -> None:
        super().__init__(elf, cache)
        wiring = coefficients.document.wiring if coefficients else None
        self.chips = {
            chip.channel: self.add_chip(chip.chip, chip.cs, chip.so, chip.sck, chip.sdi, chip.analog_pin)
            for chip in (wiring.thermocouples if wiring else ())
        }
        self._converters = converters(wiring) if wiring else {}
        for channel in self.chips:
            self.set_celsius(channel, 30.0)
        self._text = ""
        self._columns: list[str] = []

    def set_celsius(self, channel: str, celsius: float) -> None:
        self.chips[channel].set_word(self._converters[channel].word(celsius, 23.0, False))

    def send(self, line: str) -> None:
        self.uart.send(line.encode() + b"\n")

    def drive(self, pwm: int) -> None:
        """Command a PWM as somebody does who means it."""
        self.send("arm")
        self.send(str(pwm))

    def cut_power(self, off_s: float, *, cause: ResetCause = ResetCause.POWER_ON, seed: int = 1) -> None:
        """As `DeviceBoard.cut_power`; of a line that it cuts off nothing is heard."""
        super().cut_power(off_s, cause=cause, seed=seed)
        self._text += self.uart.take().decode("ascii")
        self._text = self._text[: self._text.rfind("\n") + 1]

    def hear(self, seconds: float = 0.0) -> Said:
        """Run on, and take apart what was said since the last time; a line under way is kept for the next."""
        self.run_seconds(seconds)
        self._text += self.uart.take().decode("ascii")
        *lines, self._text = self._text.split("\r\n")
        said = Said(self._columns)
        for line in lines:
            if line.startswith("# "):
                key, _, value = line[2:].partition(": ")
                if key in ("event", "status"):
                    said.events.append(value)
                else:
                    said.comments[key] = value
            elif line.startswith("time_s,"):
                self._columns = said.columns = line.split(",")
            else:
                fields = line.split(",")
                assert len(fields) == len(said.columns), line
                said.rows.append(dict(zip(said.columns, fields, strict=True)))
        return said

    def run_until(self, condition: Callable[[], bool], most_s: float, *, step_s: float = 0.02) -> None:
        """Run on until something holds, looking every `step_s`."""
        for _ in range(round(most_s / step_s)):
            if condition():
                return
            self.run_seconds(step_s)
        raise AssertionError(f"it did not come within {most_s:g} s")

    def started(self) -> Said:
        """Run until the model has started, and half a second more; what was said before the reset is left out."""
        said = Said()
        for _ in range(20):
            more = self.hear(0.5)
            said.columns = more.columns
            said.comments |= more.comments
            said.events += more.events
            said.rows += more.rows
            starts = [i for i, row in enumerate(said.rows) if row["time_s"] == "0.000"]
            if starts:
                del said.rows[: starts[-1]]
                return said
        raise AssertionError("the model did not start within 10 s")

    def variable(self, name: str) -> tuple[int, int]:
        """Address and size of a variable by the name it has in the source."""
        mangled = f"{len(name)}{name}"
        names = [n for n in self.memory.symbols if n == name or n.endswith((mangled, f"{mangled}E"))]
        assert len(names) == 1, names
        symbol = self.memory.symbol(names[0])
        return symbol.address - 0x800000, symbol.size

    def read(self, name: str) -> int:
        return int.from_bytes(self.memory.peek(*self.variable(name)), "little")

    def write(self, name: str, value: int) -> None:
        address, size = self.variable(name)
        self.memory.poke(address, (value % (1 << 8 * size)).to_bytes(size, "little"))


def warm(board: Board) -> Board:
    """Give each part a temperature of its own."""
    for channel, celsius in TEMPERATURES.items():
        board.set_celsius(channel, celsius)
    return board
