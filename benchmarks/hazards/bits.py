"""A bit that flips, in EEPROM, in flash, in RAM, one at a time: each is a run of its own."""

from __future__ import annotations

import random
import struct
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from benchmarks.hazards.boards import Variant, variant
from benchmarks.hazards.commanding import hot
from benchmarks.hazards.scene import Outcome, Scene

Flip = tuple[int, int]
"""Address and bit."""

SEED = 16
RUN_S = 60.0
STACK_BYTES = 200
"""So many bytes at the end of the RAM are taken for its stack."""
RAM_END = 0x2200


@dataclass(frozen=True)
class Campaign:
    """Many runs that make one line of the table.

    Attributes
    ----------
    name, cause
        As a hazard's.
    flips
        All of them, from how many are asked for; 0: every address.
    run
        One of them.
    """

    name: str
    cause: str
    flips: Callable[[int], Sequence[Flip]]
    run: Callable[[Flip], Outcome]


# ---- RAM ---------------------------------------------------------------------------------------------------------


def _ram_flips(count: int) -> list[Flip]:
    """Bits of what the firmware keeps in RAM, and of its stack: those of the bytes between would move nothing."""
    with Scene(variant("relay")) as scene:
        end = scene.board.mega.memory.address("__bss_end")
    places = [*range(0x200, end), *range(RAM_END - STACK_BYTES, RAM_END)]
    drawn = random.Random(SEED)
    return [(drawn.choice(places), drawn.randrange(8)) for _ in range(count or len(places))]


def _flip_ram(flip: Flip) -> Outcome:
    address, bit = flip
    with Scene(variant("relay"), astray=True) as scene:
        scene.start()
        drawn = random.Random(f"{flip}")
        scene.wait(drawn.randrange(80) * 0.25)
        scene.board.mega.run_seconds(drawn.random() * 0.2)  # at any time between two samples
        memory = scene.board.mega.memory
        memory.poke(address, bytes([memory.peek(address, 1)[0] ^ 1 << bit]))
        scene.begins()
        scene.wait(RUN_S)
        return scene.outcome()


# ---- flash -------------------------------------------------------------------------------------------------------


def loaded(elf: bytes) -> Iterator[tuple[int, int, int]]:
    """Address in flash, size and place in the file of what is loaded."""
    start = struct.unpack_from("<I", elf, 28)[0]
    entry, count = struct.unpack_from("<HH", elf, 42)
    for number in range(count):
        kind, offset, _, flash, size = struct.unpack_from("<5I", elf, start + entry * number)
        if kind == 1 and size and flash < 0x800000:
            yield flash, size, offset


def _flash_flips(count: int) -> list[Flip]:
    elf = variant("relay").firmware.elf.read_bytes()
    end = max(flash + size for flash, size, _ in loaded(elf))
    drawn = random.Random(SEED)
    return [(drawn.randrange(end), drawn.randrange(8)) for _ in range(count or end)]


def flip_flash(flip: Flip) -> Outcome:
    """The bit is wrong from the start on; whoever drives asks for an end of what stops, and drives."""
    address, bit = flip
    board = variant("relay")
    elf = bytearray(board.firmware.elf.read_bytes())
    for flash, size, offset in list(loaded(bytes(elf))):
        if flash <= address < flash + size:
            elf[offset + address - flash] ^= 1 << bit
    with tempfile.TemporaryDirectory() as folder:
        damaged = Path(folder) / "damaged.elf"
        damaged.write_bytes(elf)
        with Scene(board, elf=damaged, astray=True) as scene:
            scene.begins()
            scene.start()
            scene.send("reset")
            scene.wait(1.0)
            scene.drive(255)
            scene.wait(RUN_S)
            return scene.outcome()


# ---- EEPROM ------------------------------------------------------------------------------------------------------


@cache
def _stopped() -> tuple[bytes, dict[str, float]]:
    """What the EEPROM holds after a limit has stopped the motor, and how warm the motor is then."""
    with Scene(variant("relay")) as scene:
        hot(scene)
        scene.wait(5.0)
        return scene.board.mega.eeprom.image, dict(scene.plant.temperatures)


def _eeprom_flips(count: int) -> list[Flip]:
    """One bit of each address that has been written, and `count` others; 0: one bit of each address."""
    image, _ = _stopped()
    drawn = random.Random(SEED)
    written = [address for address, byte in enumerate(image) if byte != 0xFF]
    others = sorted(set(range(len(image))).difference(written))
    chosen = sorted([*written, *(drawn.sample(others, count) if count else others)])
    return [(address, drawn.randrange(8)) for address in chosen]


def _flip_eeprom(flip: Flip) -> Outcome:
    """A limit has stopped the motor; without power a bit flips, and then whoever drives does what he can."""
    address, bit = flip
    image, temperatures = _stopped()
    damaged = bytearray(image)
    damaged[address] ^= 1 << bit
    return _hot_again(variant("relay"), bytes(damaged), temperatures)


def _hot_again(board: Variant, image: bytes, temperatures: dict[str, float]) -> Outcome:
    with Scene(board, eeprom=image) as scene:
        scene.plant.temperatures |= temperatures
        scene.begins()
        scene.wait(4.0)
        for _ in range(4):
            scene.send("reset")
            scene.drive(255)
            scene.wait(3.0)
        return scene.outcome()


CAMPAIGNS = {
    campaign.name: campaign
    for campaign in (
        Campaign(
            "eeprom-bits", "a bit of the EEPROM flips while a limit has stopped the motor", _eeprom_flips, _flip_eeprom
        ),
        Campaign("flash-bits", "a bit of the program is wrong from the start on", _flash_flips, flip_flash),
        Campaign("ram-bits", "a bit of what is in RAM flips while running", _ram_flips, _flip_ram),
    )
}
