"""What a chip needs in the file, and what it cannot have."""

from __future__ import annotations

import copy
import json
from typing import Any

import pytest

from gen.coefficients import parse
from gen.coefficients.writer import dump
from gen.errors import InputError
from tests.device.variants import BASE


def with_brush(**keys: object) -> bytes:
    tree = copy.deepcopy(BASE)
    tree["wiring"]["thermocouples"][0] |= keys
    return json.dumps(tree).encode()


@pytest.mark.parametrize(
    ("keys", "place", "says"),
    [
        ({"chip": "MAX1234"}, "chip", "MAX6675"),
        ({"chip": "MAX31856"}, "sdi", "expected the pin of its SDI"),
        ({"chip": "MAX31855", "sdi": 24}, "sdi", "no such line"),
        ({"sdi": 24}, "sdi", "no such line"),
        ({"wires": 3}, "wires", "only a MAX31865"),
        ({"chip": "MAX31865", "sdi": 24, "rtd_ohm": 500}, "rtd_ohm", "100"),
        ({"chip": "MAX31865", "sdi": 24, "max_degC": 900}, "max_degC", "850"),
        ({"max_degC": 1024}, "max_degC", "1023.75"),
        ({"chip": "MAX31865", "sdi": 29}, "", "already taken"),
    ],
)
def test_a_chip_with_what_it_cannot_have_is_refused_at_its_place(keys: dict[str, Any], place: str, says: str) -> None:
    with pytest.raises(InputError) as caught:
        parse(with_brush(**keys))
    assert caught.value.place is not None
    assert caught.value.place.startswith("$.wiring.thermocouples[0]") or not place
    assert place in caught.value.place
    assert says in caught.value.message


def test_files_without_the_key_are_of_max6675s_and_are_written_without_it() -> None:
    document = parse(with_brush()).document
    assert document.wiring is not None
    assert {chip.chip for chip in document.wiring.thermocouples} == {"MAX6675"}
    assert b'"chip"' not in dump(document).encode()


def test_a_platinum_resistors_reference_follows_it() -> None:
    for ohm in (100, 1000):
        wiring = parse(with_brush(chip="MAX31865", sdi=24, rtd_ohm=ohm)).document.wiring
        assert wiring is not None
        assert wiring.thermocouples[0].resistor_ohm == pytest.approx((ohm, 4.3 * ohm))
