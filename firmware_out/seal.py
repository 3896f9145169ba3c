"""Writes into a program what it sums up to: at its start the board tells whether its flash holds what was built.

PlatformIO runs this behind the linker (extra_scripts in platformio.ini). By hand: python seal.py firmware.elf
The sum is the CRC-32 of the flash image without the four bytes of the symbol gen_seal, which get it.
"""

import struct
import sys
import zlib

SYMBOL = b"gen_seal"


def seal(path):
    """Seal an ELF file of the AVR in place; gives the CRC-32. ValueError if there is no such symbol."""
    with open(path, "rb") as file:
        elf = bytearray(file.read())
    sections = _sections(elf)
    address = _symbol(elf, sections)
    image = _image(elf)
    crc = zlib.crc32(image[:address] + image[address + 4 :])
    for start, size, offset, _ in _loaded(elf):
        if start <= address < start + size:
            struct.pack_into("<I", elf, offset + address - start, crc)
    with open(path, "r+b") as file:
        file.write(elf)
    return crc


def _sections(elf):
    start, entry, count = struct.unpack_from("<I", elf, 32)[0], *struct.unpack_from("<HH", elf, 46)
    return [struct.unpack_from("<10I", elf, start + entry * number) for number in range(count)]


def _symbol(elf, sections):
    for _, kind, _, _, offset, size, link, _, _, entry in sections:
        if kind != 2:  # symbol table
            continue
        names = sections[link][4]
        for at in range(offset, offset + size, entry):
            name, value = struct.unpack_from("<II", elf, at)
            if elf[names + name : elf.index(0, names + name)] == SYMBOL:
                return value
    raise ValueError("the program has no symbol gen_seal")


def _loaded(elf):
    """(address in flash, size, offset in the file, address at run time) of what is written to flash."""
    start, entry, count = struct.unpack_from("<I", elf, 28)[0], *struct.unpack_from("<HH", elf, 42)
    for number in range(count):
        kind, offset, run, flash, size = struct.unpack_from("<5I", elf, start + entry * number)
        if kind == 1 and size and flash < 0x800000:  # beyond: RAM, EEPROM, fuses
            yield flash, size, offset, run


def _image(elf):
    """The flash from 0 on, as a programmer writes it."""
    parts = list(_loaded(elf))
    image = bytearray(b"\xff" * max(start + size for start, size, _, _ in parts))
    for start, size, offset, _ in parts:
        image[start : start + size] = elf[offset : offset + size]
    return bytes(image)


def _after_link(source, target, env):
    try:
        print("Sealed: CRC-32 %08X" % seal(str(target[0])))
    except ValueError as error:  # a test, which has no sketch in it
        print("Not sealed: %s" % error)


try:
    Import("env")  # noqa: F821 - only under PlatformIO
except NameError:
    if __name__ == "__main__":
        print("%08X" % seal(sys.argv[1]))
else:
    env.AddPostAction("$BUILD_DIR/${PROGNAME}.elf", _after_link)  # noqa: F821
