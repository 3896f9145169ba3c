"""Commissioning on the emulated Mega: that what was passed is kept, and nothing less."""

from __future__ import annotations

import pytest

from gen.firmware.sketch.device import device_context
from gen.lowering.lower import lower
from tests.device.conftest import Open
from tests.device.person import Bench, Start, is_commissioned
from tests.device.variants import variant


def passed(power_up: Open) -> Bench:
    motor = Bench(power_up())
    motor.start()
    assert motor.commission() == "commissioning passed"
    return motor


def record() -> tuple[int, int]:
    """Address and size of what is kept."""
    context = device_context(variant("my1016"), lower(variant("my1016"), "fixed", "table"))["commissioning"]
    assert context is not None
    return context["at"], context["bytes"]


@pytest.mark.parametrize("written", [None, 0, 2, 4])
def test_a_loss_of_power_in_the_middle_or_while_it_is_kept_leaves_it_undone(
    power_up: Open, written: int | None
) -> None:
    """Five bytes make a record of a pass out of one of none: the verdict, and four of the CRC."""
    motor = Bench(power_up())
    motor.start()
    motor.board.send("commission")
    motor.until("warm magnet" if written is None else "writing")
    if written is not None:
        enough = motor.board.eeprom.counts.writes + written
        motor.board.run_until(lambda: motor.board.eeprom.counts.writes >= enough, 3.0, step_s=0.0005)
        assert motor.board.eeprom.busy == (written > 0)
    motor.board.cut_power(1.0, seed=7)
    assert motor.board.started().comments["commissioned"] == "no"


def test_any_single_bit_that_turns_in_what_is_kept_undoes_it(power_up: Open) -> None:
    motor = passed(power_up)
    contents = motor.board.eeprom.image
    at, size = record()
    for bit in range(0, 8 * size, 5):
        damaged = bytearray(contents)
        damaged[at + bit // 8] ^= 1 << bit % 8
        other = power_up()
        other.eeprom.image = bytes(damaged)
        assert other.started().comments["commissioned"] == "no"


def test_a_cell_that_does_not_hold_is_said(power_up: Open) -> None:
    motor = Bench(power_up())
    motor.start()
    at, _ = record()
    motor.board.send("commission")
    motor.until("writing")

    def written() -> bool:
        return motor.board.eeprom.image[at + 4] == 0xA5

    motor.board.run_until(written, 3.0)
    image = bytearray(motor.board.eeprom.image)
    image[at] ^= 1
    motor.board.eeprom.image = bytes(image)
    assert motor.until("FAILED", 5.0).endswith("FAILED at eeprom: the record does not hold")
    motor.wait(3.0)
    assert is_commissioned(motor) == "no"


def test_a_line_while_it_is_kept_leaves_it_undone(bench: Start) -> None:
    motor = bench()
    motor.board.send("commission")
    motor.until("writing")
    motor.board.send("stop")
    assert motor.until("FAILED", 5.0).endswith("ended by a line")
    motor.wait(3.0)
    assert is_commissioned(motor) == "no"


def test_another_wiring_is_not_commissioned_and_a_refined_model_is(power_up: Open) -> None:
    kept = passed(power_up).board.eeprom.image
    for name, said in (("watched_brush", "yes"), ("directed", "no")):
        other = power_up(name)
        other.eeprom.image = kept
        assert other.started().comments["commissioned"] == said
