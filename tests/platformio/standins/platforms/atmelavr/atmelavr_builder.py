"""Build script of the stand-in platform: becomes `builder/main.py`, run by SCons."""

from typing import Any

from SCons.Script import AlwaysBuild, Builder, Default, DefaultEnvironment  # type: ignore[import-untyped]

env: Any = DefaultEnvironment()

env.Replace(
    AR="avr-gcc-ar",
    AS="avr-as",
    CC="avr-gcc",
    CXX="avr-g++",
    OBJCOPY="avr-objcopy",
    RANLIB="avr-gcc-ranlib",
    SIZETOOL="avr-size",
    ARFLAGS=["rc"],
    PROGNAME="firmware",
    PROGSUFFIX=".elf",
    # PlatformIO reads flash and RAM from these and fails when the board's limits are exceeded.
    SIZECHECKCMD="$SIZETOOL -A -d $SOURCES",
    SIZEPROGREGEXP=r"^(?:\.text|\.data|\.bootloader)\s+(\d+)",
    SIZEDATAREGEXP=r"^(?:\.data|\.bss|\.noinit)\s+(\d+)",
)
env.Append(
    BUILDERS={
        "ElfToHex": Builder(
            action=env.VerboseAction("$OBJCOPY -O ihex -R .eeprom $SOURCES $TARGET", "Building $TARGET"),
            suffix=".hex",
        )
    }
)

firmware_elf = env.BuildProgram()
firmware_hex = env.ElfToHex("$BUILD_DIR/${PROGNAME}", firmware_elf)


def refuse_upload(*_args: object, **_kwargs: object) -> None:
    """Fail: nothing may ever be written to a device from a test."""
    raise RuntimeError("the stand-in platform has no upload")


AlwaysBuild(env.Alias("upload", firmware_hex, env.VerboseAction(refuse_upload, "Refusing to upload")))
Default(env.Alias("buildprog", firmware_hex, firmware_hex))
