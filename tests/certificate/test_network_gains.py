"""Sensors whose gains are wrong: what is emitted of them is proven, and no other gain."""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gen
from gen.errors import CheckFailed, InputError
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.reference.board import reference_of
from gen.reference.network import ReferenceNetwork
from tests.campaign import share
from tests.certificate.networks import assert_about, assert_proven, emitted, read, with_sensors
from tests.certificate.test_network import ARITHMETICS, CERTIFICATE, MODEL, changed
from tests.certificate.test_planted import Edit, added, planted, replaced

#: By node: of the rise and of degC, beside a lag and an offset, too small and too large.
SENSORS: list[list[dict[str, Any]]] = [
    [
        {"gain_error": -0.45},
        {"gain_error": 0.07, "gain_about": "zero_degC", "lag_s": 6.0},
        {"gain_error": 1.5, "offset_K": 0.4},
    ],
    [{"gain_error": -0.2, "gain_about": "zero_degC"}, {"gain_error": 0.3, "lag_s": 6.0, "offset_K": -2.0}, {}],
    [{"lag_s": 6.0}, {}, {"gain_error": 1e-3, "offset_K": 0.4}],
    [{"gain_error": -0.89}, {"gain_error": 2.0}, {"gain_error": 2.0, "gain_about": "zero_degC"}],
]
Projects = dict[Arithmetic, tuple[Path, Program]]


@pytest.fixture(scope="module")
def projects(tmp_path_factory: pytest.TempPathFactory) -> Projects:
    """The first of them in both arithmetics."""
    return {one: emitted(tmp_path_factory.mktemp(one), read(with_sensors(SENSORS[0])), one) for one in ARITHMETICS}


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("case", range(len(SENSORS)))
def test_gains_are_proven(tmp_path: Path, case: int, arithmetic: Arithmetic) -> None:
    assert_proven(*emitted(tmp_path, read(with_sensors(SENSORS[case])), arithmetic))


def test_the_statement_is_about_its_gains(projects: Projects, tmp_path: Path) -> None:
    assert_about(projects["fixed"][0], tmp_path, with_sensors(SENSORS[0]), "gain_error", "components")


def _component(number: int, **parts: object) -> Edit:
    def change(tree: dict[str, Any]) -> None:
        tree["components"][number] |= parts

    return changed(change)


def _nothing_of_the_gain(tree: dict[str, Any]) -> None:
    for component in tree["components"]:
        component.pop("shown_per_K", None)
        component.pop("shown_about", None)


def _flag(number: int, nth: int) -> Edit:
    """One of a row's two flags turned: 1 of the ambient, 2 of the sign."""

    def edit(text: str) -> str:
        match = list(re.finditer(r"chain_\w+, chain_\w+, (true|false), (true|false)\}", text))[nth]
        turned = {"true": "false", "false": "true"}[match[number]]
        return text[: match.start(number)] + turned + text[match.end(number) :]

    return edit


READ, START = r"\d+L, (\d+)UL, \d+UL, chain_T_node0", r"\d+L, \d+UL, (\d+)UL, chain_T_node0"
#: In units of the words' last bits: 2^-31 and 2^-32; so little is 1e-5 K at 100 K.
LITTLE = 400
DEFECTS: dict[str, tuple[str, Edit]] = {
    "the gain off by a little": (MODEL, added(READ, LITTLE)),
    "the gain off by a little, down": (MODEL, added(READ, -LITTLE)),
    "the start's share off by a little": (MODEL, added(START, 40 * LITTLE)),
    "the start's share off by a little, down": (MODEL, added(START, -40 * LITTLE)),
    "a sign turned": (MODEL, _flag(2, 0)),
    "another sign turned": (MODEL, _flag(2, 1)),
    "about 0 degC, not the ambient": (MODEL, _flag(1, 0)),
    "about the ambient, not 0 degC": (MODEL, _flag(1, 1)),
    "no gain of a reading": (MODEL, replaced(r"word \+ shown_more\(over_base\(&reading, word, ambient\)", "word + (0")),
    "the gain of a reading twice": (MODEL, replaced(r"reading\.gain\) \+", "2 * reading.gain) +")),
    "a start by the gain of a reading": (MODEL, replaced(r"reading\.back\)", "reading.gain)")),
    "a start added": (MODEL, replaced(r"seen - read_more", "seen + read_more")),
    "a start about another ambient": (MODEL, replaced(r"seen, degrees\(ambient\)", "seen, degrees(25000L)")),
    "a base of its own": (MODEL, replaced(r"about_ambient \? ambient : 0", "about_ambient ? ambient : 1")),
    "a shift too short": (MODEL, replaced(r"over, gain\), 15\)", "over, gain), 14)")),
    "a start's shift too short": (MODEL, replaced(r"over, back\), 16\)", "over, back), 15)")),
    "the offset before the gain": (
        MODEL,
        replaced(
            r"word = upper\(reading\.state\), ambient",
            "word = upper(reading.state) + reading.offset, ambient",
        ),
    ),
    "another gain in the certificate": (CERTIFICATE, _component(0, shown_per_K=-0.45 + 2e-7)),
    "another gain of degC in the certificate": (CERTIFICATE, _component(1, shown_per_K=0.07 + 2e-7)),
    "another sign in the certificate": (CERTIFICATE, _component(0, shown_per_K=0.45)),
    "another base in the certificate": (CERTIFICATE, _component(0, shown_about="zero_degC")),
    "half of a gain in the certificate": (CERTIFICATE, _component(2, shown_per_K=0.75)),
    "no gain in the certificate": (CERTIFICATE, changed(_nothing_of_the_gain)),
}


#: What is little lies within the bound of float32, which is a hundred times as wide.
PLANTED = [(name, one) for name in DEFECTS for one in ARITHMETICS if one == "fixed" or "little" not in name]


@pytest.mark.campaign
@pytest.mark.parametrize(("defect", "arithmetic"), share(PLANTED))
def test_a_defect_of_a_gain_is_refuted(projects: Projects, tmp_path: Path, defect: str, arithmetic: Arithmetic) -> None:
    name, edit = DEFECTS[defect]
    with pytest.raises(CheckFailed):
        gen.check(planted(projects[arithmetic][0], tmp_path, name, edit))


@pytest.mark.parametrize("parts", [{"shown_about": None}, {"shown_per_K": -1.0}, {"shown_about": "room"}])
def test_a_gain_that_means_nothing_is_no_certificate(projects: Projects, tmp_path: Path, parts: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=r"is no certificate"):
        gen.check(planted(projects["fixed"][0], tmp_path, CERTIFICATE, _component(0, **parts)))


def test_what_the_reference_starts_from_and_shows_is_exact_to_a_few_words() -> None:
    """In fractions, from the file's own numbers: the start undoes what the reading does."""
    file = with_sensors(SENSORS[0])
    program = emitted_program(file)
    network = program.network
    assert network is not None
    chance, lanes = np.random.default_rng(4), 300
    told = np.array([chance.integers(c.low, c.high + 1, lanes) for c in network.channels])
    asked = chance.integers(-10_000, 120_001, (3, lanes))
    board = reference_of(
        program, {r.name: (a - told[0]).tolist() for r, a in zip(network.readings, asked, strict=True)}, told
    )
    assert isinstance(board, ReferenceNetwork)
    temperatures = board.temperatures
    for number, (reading, sensor) in enumerate(zip(network.readings, SENSORS[0], strict=True)):
        g, offset = Fraction(sensor["gain_error"]), Fraction(sensor.get("offset_K", 0))
        for lane in range(lanes):
            base = Fraction(int(told[0, lane]), 1000) if sensor.get("gain_about") != "zero_degC" else Fraction(0)
            first = Fraction(int(asked[number, lane]), 1000)
            exact = base + (first - offset - base) / (1 + g)
            found = Fraction(float(temperatures[reading.node, lane]))
            assert abs(found - exact) * 2**network.fraction_bits < 6
            shown = Fraction(float(board.readings[number, lane]))
            assert abs(shown - (found + g * (found - base) + offset)) * 2**network.fraction_bits < 4


def emitted_program(file: dict[str, Any]) -> Program:
    return lower(read(file), "fixed", "table")
