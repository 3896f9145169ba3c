"""Framework script of the stand-in platform: becomes `builder/frameworks/arduino.py`, run by SCons.

The flags are those that users get from platformio/atmelavr 5.0.0, but for one define that Debian's older
compiler needs.
"""

from pathlib import Path
from typing import Any

from SCons.Script import DefaultEnvironment  # type: ignore[import-untyped]

env: Any = DefaultEnvironment()
board = env.BoardConfig()
package = Path(env.PioPlatform().get_package_dir("framework-arduino-avr"))
core = package / "cores" / board.get("build.core")
variant = package / "variants" / board.get("build.variant")

compiler_flags = ["-Os", "-Wall", "-ffunction-sections", "-fdata-sections", "-flto", "-mmcu=$BOARD_MCU"]

env.Append(
    ASFLAGS=["-x", "assembler-with-cpp", *compiler_flags],
    CCFLAGS=compiler_flags,
    CFLAGS=["-std=gnu11", "-fno-fat-lto-objects"],
    CXXFLAGS=["-std=gnu++11", "-fno-exceptions", "-fno-threadsafe-statics", "-fpermissive"],
    LINKFLAGS=["-Os", "-mmcu=$BOARD_MCU", "-Wl,--gc-sections", "-flto", "-fuse-linker-plugin"],
    CPPDEFINES=[
        ("F_CPU", "$BOARD_F_CPU"),
        ("ARDUINO", 10808),
        "ARDUINO_ARCH_AVR",
        # WString.cpp does not compile with avr-gcc 5.4 without it; the users' avr-gcc 7.3 has it built in.
        ("DECIMAL_DIG", "__DECIMAL_DIG__"),
    ],
    CPPPATH=[str(core), str(variant)],
    LIBS=["m"],
    LIBSOURCE_DIRS=[str(package / "libraries")],
)

env.Prepend(
    LIBS=[
        env.BuildLibrary("$BUILD_DIR/FrameworkArduinoVariant", str(variant)),
        env.BuildLibrary("$BUILD_DIR/FrameworkArduino", str(core)),
    ]
)
