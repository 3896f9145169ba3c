from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from gen.avr.compile import ArduinoCore, build_elf
from gen.firmware.project import project_files
from gen.lowering.lower import lower
from tests.device.board import Board
from tests.device.person import Bench, Start
from tests.device.variants import variant

#: Stands in for the alarm rules: they say what the test wrote into `test_alarms`.
ALARMS = """
#include "my1016_alarms_state.h"
#include "my1016_platform.h"
static const char test_name[] PROGMEM = "test";
my1016_AlarmState my1016_alarm_state;
volatile uint16_t test_alarms;
extern "C" void my1016_alarms_begin(uint8_t) {}
extern "C" void my1016_alarms_restore(uint16_t alarms) { test_alarms |= alarms; }
extern "C" void my1016_alarms_step(int16_t, const my1016_Sample *) {}
extern "C" uint16_t my1016_alarms(void) { return test_alarms; }
extern "C" uint16_t my1016_alarms_active(void) { return test_alarms; }
extern "C" uint16_t my1016_alarms_asleep(void) { return 0; }
extern "C" void my1016_alarms_reset(void) { test_alarms = 0; }
extern "C" uint8_t my1016_alarms_over_limit(void) { return 0; }
extern "C" const char *my1016_alarm_name(uint8_t) { return test_name; }
"""

Open = Callable[..., Board]


@pytest.fixture(scope="session")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("device-cache")


@pytest.fixture(scope="session")
def built(cache: Path) -> Callable[[str, bool], Path]:
    """Build a variant's sketch as PlatformIO does, every warning an error; the second argument: with test alarms."""
    core = ArduinoCore(cache)
    done: dict[tuple[str, bool], Path] = {}

    def build(name: str, with_test_alarms: bool = False) -> Path:
        key = (name, with_test_alarms)
        if key not in done:
            coefficients = variant(name)
            folder = cache / f"{name}-{with_test_alarms}"
            for path, text in project_files(
                coefficients, lower(coefficients, "fixed", "table"), "coeffs.json", None
            ).items():
                target = folder / path
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_text(text)
            library = folder / "lib" / "my1016" / "src"
            if with_test_alarms:
                (library / "my1016_alarms.cpp").write_text(ALARMS)
            sources = sorted([*(folder / "src").glob("*.cpp"), *library.glob("*.cpp")])
            elf = folder / "firmware.elf"
            done[key] = build_elf(sources, [folder / "src", library], elf, core=core, optimisation="-Os")
        return done[key]

    return build


@pytest.fixture
def power_up(built: Callable[[str, bool], Path], cache: Path) -> Open:
    """Open a variant's board, just out of reset, with its thermocouples connected."""

    def open_board(name: str = "my1016", *, test_alarms: bool = False, connected: bool = True) -> Board:
        return Board(built(name, test_alarms), cache, variant(name) if connected else None)

    return open_board


@pytest.fixture
def bench(power_up: Open) -> Start:
    """Open a board with a motor and a person before it."""

    def start(name: str = "my1016", **faults: object) -> Bench:
        made = Bench(power_up(name), **faults)  # type: ignore[arg-type]
        made.start()
        return made

    return start
