from __future__ import annotations

from pathlib import Path

import pytest

from gen.avr.compile import (
    SRAM_OFFSET,
    ArduinoCore,
    BuildFailed,
    Sizes,
    build_elf,
    compile_objects,
    sizes,
    symbols,
    undefined_symbols,
)

MCU = ["-mmcu=atmega2560", "-O2"]


def write(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_symbols_tell_name_place_size_and_kind(tmp_path: Path) -> None:
    text = "volatile long table[5]; extern long start; long start = 7; int main() { table[0] = start; }\n"
    elf = build_elf([write(tmp_path, "a.cpp", text)], [], tmp_path / "a.elf")
    found = {symbol.name: symbol for symbol in symbols(elf)}
    assert (found["table"].size, found["table"].kind) == (20, "B")
    assert (found["start"].size, found["start"].kind) == (4, "D")
    assert found["start"].address >= SRAM_OFFSET + 0x200
    assert found["main"].kind == "T"
    assert found["main"].size > 0


def test_sizes_count_initialised_data_in_flash_and_ram(tmp_path: Path) -> None:
    text = "{0} volatile long b[5]; int main() {{ b[0] = {1}; }}\n"
    without = write(tmp_path, "without.cpp", text.format("", "1"))
    plain = sizes(build_elf([without], [], tmp_path / "without.elf"))
    table = 'static const char t[] __attribute__((used, section(".progmem.data"))) = "123456789";'
    with_table = write(tmp_path, "with.cpp", text.format(table, "t[0]"))
    assert plain.ram == 20
    assert 200 < plain.flash < 600
    data = write(tmp_path, "data.cpp", "volatile long d[4] = {1, 2, 3, 4}; int main() { d[0] = 2; }\n")
    filled = sizes(build_elf([data], [], tmp_path / "data.elf"))
    assert filled.ram == 16
    assert filled.flash > 16
    assert isinstance(sizes(build_elf([with_table], [], tmp_path / "with.elf")), Sizes)


def test_undefined_symbols_betray_floats_and_divisions(tmp_path: Path) -> None:
    text = "float p(float a, float b) { return a * b; } long q(long a, long b) { return a / b; }\n"
    source = write(tmp_path, "helpers.cpp", text)
    (built,) = compile_objects([source], tmp_path, MCU)
    needed = undefined_symbols(built)
    assert {"__mulsf3", "__divmodsi4"} <= set(needed)
    assert needed == sorted(needed)


def test_own_warnings_are_errors_unless_switched_off(tmp_path: Path) -> None:
    text = "#include <stdint.h>\nuint8_t cut(uint16_t a) { return a; }\nint main() { return cut(3); }\n"
    source = write(tmp_path, "cut.cpp", text)
    with pytest.raises(BuildFailed, match=r"cut\.cpp:2.*conversion"):
        build_elf([source], [], tmp_path / "cut.elf")
    assert build_elf([source], [], tmp_path / "cut.elf", own_warnings=False).is_file()


def test_failed_build_leaves_nothing_behind(tmp_path: Path) -> None:
    source = write(tmp_path, "bad.cpp", "int main() { return missing(); }\n")
    with pytest.raises(BuildFailed, match=r"avr-g\+\+ failed:\n(?s:.)*bad\.cpp:1.*missing"):
        build_elf([source], [], tmp_path / "out" / "bad.elf")
    assert list((tmp_path / "out").iterdir()) == []


def test_link_errors_name_the_symbol(tmp_path: Path) -> None:
    source = write(tmp_path, "half.cpp", "void other(); int main() { other(); }\n")
    with pytest.raises(BuildFailed, match=r"undefined reference to `other\(\)'"):
        build_elf([source], [], tmp_path / "half.elf")


def test_defines_headers_and_languages(tmp_path: Path) -> None:
    headers = tmp_path / "headers"
    headers.mkdir()
    write(
        headers,
        "own.h",
        '#ifdef __cplusplus\nextern "C" {\n#endif\nint from_c(void);\nint from_s(void);\n'
        "#ifdef __cplusplus\n}\n#endif\n",
    )
    sources = [
        write(tmp_path, "main.cpp", '#include "own.h"\nint main() { return from_c() + from_s() + VALUE; }\n'),
        write(tmp_path, "c.c", '#include "own.h"\nint from_c(void) { return VALUE; }\n'),
        write(tmp_path, "s.S", ".global from_s\nfrom_s: ldi r24, VALUE\n ldi r25, 0\n ret\n"),
    ]
    elf = build_elf(sources, [headers], tmp_path / "all.elf", defines=["VALUE=3"], optimisation="-Os")
    assert {"main", "from_c", "from_s"} <= {symbol.name for symbol in symbols(elf)}


def test_core_headers_cause_no_warnings_under_our_flags(core: ArduinoCore, tmp_path: Path) -> None:
    text = (
        "#include <Arduino.h>\n#include <EEPROM.h>\n"
        "void setup() { Serial.begin(9600); EEPROM.put(0, 1.5f); digitalWrite(LED_BUILTIN, HIGH); }\n"
        "void loop() { Serial.println(analogRead(A0)); }\n"
    )
    source = write(tmp_path, "sketch.cpp", text)
    elf = build_elf([source], [core.library("EEPROM")], tmp_path / "sketch.elf", core=core)
    assert sizes(elf).flash > 2000
    assert "__vector_23" in {symbol.name for symbol in symbols(elf)}  # TIMER0_OVF: millis() of the real core


def test_core_is_built_once(core: ArduinoCore, cache: Path) -> None:
    stamp = core.archive.stat().st_mtime_ns
    assert ArduinoCore(cache).archive == core.archive
    assert core.archive.stat().st_mtime_ns == stamp
    assert not list(cache.glob("core-*"))


def test_unknown_core_library_is_an_error(core: ArduinoCore) -> None:
    with pytest.raises(FileNotFoundError, match="no library Ghost"):
        core.library("Ghost")


def test_foreign_file_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(BuildFailed, match="avr-nm failed"):
        symbols(write(tmp_path, "text.elf", "no ELF"))
