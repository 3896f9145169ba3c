"""The board's own supply, measured against the chip's reference of 1.1 V, on the emulated Mega."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

from gen.coefficients import parse
from gen.coefficients.protecting import protections
from gen.errors import InputError
from gen.firmware.project import project_files
from gen.lowering.lower import lower
from tests.device.board import LATE, Board, Said
from tests.device.conftest import Open
from tests.device.variants import variant
from tests.examples import ROOT

ADCSRA, ADEN = 0x7A, 0x80


def told_mV(board: Board) -> tuple[str, int]:
    """The verdict of `test`, and the supply that it tells."""
    board.send("test")
    (found,) = [
        re.search(r"test supply (\w+) (\d+) mV", event) for event in board.hear(4.0).events if "test supply" in event
    ]
    assert found is not None
    return found[1], int(found[2])


def begins(said: Said) -> bool:
    return any("protection supply_low begins" in event for event in said.events)


def ends(said: Said) -> bool:
    return any("protection supply_low ends" in event for event in said.events)


@pytest.mark.parametrize("volts", [3.5, 4.3, 4.75, 5.0, 5.5])
def test_the_supply_that_it_tells_is_the_supply_to_a_step_of_the_converter(power_up: Open, volts: float) -> None:
    board = power_up("supplied")
    board.supply_with(volts, reference_V=1.15)
    board.started()
    verdict, millivolts = told_mV(board)
    step = 1000.0 * volts**2 / 1.15 / 1024.0
    assert millivolts == pytest.approx(1000.0 * volts, abs=1.5 * step)
    assert verdict == ("ok" if volts > 4.6 else "FAILED")


def test_a_supply_that_sags_is_told_after_a_second_and_ends_only_well_above(power_up: Open) -> None:
    board = power_up("supplied")
    board.supply_with(5.0, reference_V=1.15)
    assert not begins(board.started())
    board.supply_with(4.55, reference_V=1.15)
    assert not begins(board.hear(5.0))
    board.supply_with(4.45, reference_V=1.15)
    assert not begins(board.hear(0.9))
    assert begins(board.hear(0.9))
    board.supply_with(4.56, reference_V=1.15)
    assert not ends(board.hear(5.0))
    board.supply_with(4.66, reference_V=1.15)
    assert ends(board.hear(1.0))


def test_a_sag_as_short_as_a_motor_s_start_is_not_told(power_up: Open) -> None:
    board = power_up("supplied")
    board.supply_with(5.0, reference_V=1.15)
    board.started()
    for _ in range(5):
        board.supply_with(3.9, reference_V=1.15)
        said = board.hear(0.7)
        board.supply_with(5.0, reference_V=1.15)
        assert not begins(said)
        assert not begins(board.hear(1.0))


@pytest.mark.parametrize("reference_V", [1.0, 1.1, 1.2])
def test_no_chip_that_the_data_sheet_promises_speaks_of_a_sound_supply(power_up: Open, reference_V: float) -> None:
    """USB's 5 V may be 4.75. The worst reference is the one of 1.2 V; the sag below is one that any chip has to see."""
    board = power_up("unmeasured_reference")
    board.supply_with(4.75, reference_V=reference_V)
    assert not begins(board.started())
    assert not begins(board.hear(5.0))
    board.supply_with(3.75, reference_V=reference_V)
    assert begins(board.hear(3.0))
    board.supply_with(4.75, reference_V=reference_V)
    assert ends(board.hear(2.0))


def test_the_voltages_beside_it_are_what_they_are_without(power_up: Open) -> None:
    """The converter has one input at a time: neither sees the other's."""
    board = power_up("supplied")
    for volts in (0.0, 5.0):
        board.pins.drive_analog(54, volts)
        board.pins.drive_analog(55, 5.0 - volts)
        said = board.started() if not volts else board.hear(3.0)
        assert said.numbers("a_V")[-1] == pytest.approx(volts, abs=0.011)
        assert said.numbers("b_V")[-1] == pytest.approx(5.0 - volts, abs=0.011)
        assert told_mV(board)[1] == pytest.approx(
            5227.0, abs=40.0
        )  # the chip's reference has 1.1 V, the file says 1.15
        assert not any(int(row["flags"]) & LATE for row in said.rows)


def test_the_converter_is_on_for_a_few_milliseconds_of_a_sample(power_up: Open) -> None:
    board = power_up("unmeasured_reference")
    board.started()
    board.hear(1.0)
    on = 0
    for _ in range(500):
        board.run_seconds(0.001)
        on += board.memory.peek(ADCSRA, 1)[0] & ADEN != 0
    assert 4 <= on <= 10  # two samples


def test_a_file_that_does_not_ask_gets_nothing_of_it() -> None:
    coefficients = variant("my1016")
    files = project_files(coefficients, lower(coefficients, "fixed", "table"), "coeffs.json", None)
    assert not {"src/supply.cpp", "src/converter.cpp"} & set(files)
    assert "ADCSRA = 0;" in files["src/board.cpp"]
    assert all("supply::" not in text for text in files.values())


def example() -> dict[str, Any]:
    tree: dict[str, Any] = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text())
    return tree


def test_an_entry_alone_is_enough_and_a_supply_alone_has_a_default() -> None:
    tree = example()
    tree["protection"] = [{"cause": "supply_low", "action": "stop", "delay_s": 2}]
    text = "".join(files_of(tree)["README.md"].split())
    assert "lessthan4200mVattheboard'sownsupply,against1100mVfor2s" in text
    tree = example()
    tree["wiring"]["supply"] = {"bandgap_mV": 1083}
    (entry,) = [
        entry for entry in protections(parse(json.dumps(tree).encode()).document) if entry.cause == "supply_low"
    ]
    assert (entry.action, entry.delay_s, entry.until) == ("led", 1.0, "itself")
    assert "less than 4500 mV" in files_of(tree)["README.md"]


def files_of(tree: dict[str, Any]) -> dict[str, str]:
    coefficients = parse(json.dumps(tree).encode())
    return {
        path: str(text)
        for path, text in project_files(
            coefficients, lower(coefficients, "fixed", "table"), "coeffs.json", None
        ).items()
    }


@pytest.mark.parametrize(
    ("supply", "message"),
    [
        ({"bandgap_mV": 990}, r"\$\.wiring\.supply\.bandgap_mV: found 990, expected"),
        ({"bandgap_mV": 1210}, r"\$\.wiring\.supply\.bandgap_mV: found 1210, expected"),
        ({"low_mV": 4500}, r"\$\.wiring\.supply\.low_mV: found 4500 without \"bandgap_mV\".*at most 4200"),
        ({"low_mV": 2600}, r"\$\.wiring\.supply\.low_mV: found 2600, expected"),
        ({"bandgap_mV": 1100, "low_mV": 4950}, r"\$\.wiring\.supply\.low_mV: found 4950, expected"),
        ({"bandgap": 1100}, r"\$\.wiring\.supply\.bandgap: unknown key"),
    ],
)
def test_what_no_supply_can_be_is_refused(supply: dict[str, float], message: str) -> None:
    tree = example()
    tree["wiring"]["supply"] = supply
    with pytest.raises(InputError, match=message):
        parse(json.dumps(tree).encode())


def test_the_hysteresis_ends_on_the_worst_sound_board() -> None:
    """By hand: what a chip with the worst reference may read of 4.75 V, less two steps of the converter."""
    step = 1024.0 * 1200.0 / 4750.0
    worst = 4750.0 * (1100.0 / 1200.0) * step / (step + 2.0)
    assert worst > 4200.0 + 100.0
