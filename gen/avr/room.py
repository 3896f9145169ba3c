"""Whether a program has room in its board."""

from __future__ import annotations

from gen.avr.chip import Chip
from gen.avr.compile import Sizes
from gen.errors import CheckFailed

OVERFLOW = " region `"
"""In what the linker says of a program that is too large; it does not say by how much."""


def check_room(what: str, used: Sizes, stack: int, chip: Chip) -> None:
    """Check that a program and what its stack needs, in bytes, have room in a chip.

    Raises
    ------
    CheckFailed
        If they have not, with the sizes.
    """
    ram = used.ram + stack
    if used.flash > chip.flash_bytes or ram > chip.ram_bytes:
        raise CheckFailed(
            f"{what} {used.flash} bytes of flash and {ram} of RAM, "
            f"and an {chip.name} has {chip.flash_bytes} and {chip.ram_bytes}"
        )
