"""Networks: what is emitted is proven, planted defects are refuted."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import gen
from gen.coefficients import load
from gen.errors import CheckFailed
from gen.lowering.kinds import Arithmetic
from gen.lowering.program import Program
from gen.verification.proof import proof_of
from tests.campaign import share
from tests.certificate.networks import EXAMPLE, chain, emitted, read
from tests.certificate.test_planted import Edit, added, claimed, planted, replaced, scaled

ARITHMETICS: tuple[Arithmetic, ...] = ("fixed", "float")
#: Few |PWM| and all that a network can have: channels, hidden nodes, a lag, an offset, heat that grows.
SMALL = chain(5, domain=(96, 119), channels=True)

Projects = dict[str, tuple[Path, Program]]


@pytest.fixture(scope="module")
def projects(tmp_path_factory: pytest.TempPathFactory) -> Projects:
    """One project for each arithmetic."""
    return {one: emitted(tmp_path_factory.mktemp(one), read(SMALL), one) for one in ARITHMETICS}


def changed(change: Callable[[dict[str, Any]], None]) -> Edit:
    """A change of the certificate."""

    def edit(text: str) -> str:
        tree = json.loads(text)
        change(tree)
        return json.dumps(tree)

    return edit


def state(key: str, factor: float) -> Edit:
    """A number of every state made larger or smaller."""

    def change(tree: dict[str, Any]) -> None:
        for one in tree["states"]:
            scaled(key, factor)(one)

    return changed(change)


def _first(key: str, factor: float) -> Edit:
    return changed(lambda tree: scaled(key, factor)(tree["components"][0]))


def _lower_top(tree: dict[str, Any]) -> None:
    tree["states"][1]["range_degC"][1] -= 0.02


def _higher_bottom(tree: dict[str, Any]) -> None:
    tree["states"][1]["range_degC"][0] += 0.5


def _other_conductance(tree: dict[str, Any]) -> None:
    tree["equations"]["paths"][1]["conductance_W_per_K"][7] *= 1.0 + 1e-5


def _other_lag(tree: dict[str, Any]) -> None:
    tree["states"][5]["time_constant_s"] *= 1.0 + 1e-6


def _other_reference(tree: dict[str, Any]) -> None:
    tree["equations"]["heats"][1]["reference_degC"] += 0.01


def _other_rest(tree: dict[str, Any]) -> None:
    tree["equations"]["paths"][1]["at_rest_W_per_K"] *= 1.01


def _other_offset(tree: dict[str, Any]) -> None:
    tree["components"][2]["shown_K"] += 1e-4


def _no_factor(tree: dict[str, Any]) -> None:
    tree["equations"]["paths"][0]["factors"] = []


def _wider_channel(tree: dict[str, Any]) -> None:
    tree["equations"]["channels"][1]["high"] += 1


def _finer(tree: dict[str, Any]) -> None:
    tree["fraction_bits"] += 1


STEP, SCHEDULE, MODEL, SUM = "chain_step.cpp", "chain_schedule.cpp", "chain.cpp", "chain_sum.h"
CERTIFICATE = "certificate.json"
FIXED: dict[str, tuple[str, Edit]] = {
    # Tables and rates.
    "a table's word": (SCHEDULE, added(r"(\d{8,})UL", 90_000, nth=9)),
    "a table's last word": (SCHEDULE, added(r"(\d{8,})UL", 90_000, nth=-1)),
    "two words of a table changed places": (SCHEDULE, replaced(r"(\d{8,}UL), (\d{8,}UL)", r"\2, \1", nth=40)),
    "a table too short": (SCHEDULE, replaced(r"\[24\] PROGMEM", "[23] PROGMEM")),
    "a constant rate": (STEP, added(r"R1 = (\d+)UL", 60_000)),
    "another table": (STEP, replaced(r"chain_rate8\[row\]", "chain_rate5[row]")),
    "another row of a table": (STEP, replaced(r"chain_rate8\[row\]", "chain_rate8[row + 1]")),
    "rates gathered in another order": (
        STEP,
        replaced(r"( +chain_gather\(fill, &chain_rate8.*\n)( +chain_gather\(fill, &chain_rate10.*\n)", r"\2\1"),
    ),
    "a rate not gathered": (STEP, replaced(r" +chain_gather\(fill, &chain_rate10.*\n", "")),
    "a rate with another factor": (STEP, replaced(r"scaled\(3665038759UL, f0\)", "scaled(3665038759UL, f1)")),
    "a rate without its factor": (STEP, replaced(r"chain_scaled\(3665038759UL, f0\)", "3665038759UL")),
    "the lag's rate": (STEP, added(r"R12 = (\d+)UL", 90_000)),
    "a heat's unit": (STEP, replaced(r"gathered\[HEAT0\] \* \(INT64_C\(1\) << 0\)", "gathered[HEAT0] * 2")),
    "a heat left out": (STEP, replaced(r" +sum \+= \(int64_t\)gathered\[HEAT0\].*\n", "")),
    "a heat twice": (STEP, replaced(r"( +sum \+= \(int64_t\)gathered\[HEAT0\].*\n)", r"\1\1")),
    "heat that does not grow": (STEP, replaced(r" +sum \+= chain_product\(v\[chain_T_node1\] - v\[REF.*\n", "")),
    "a reference": (STEP, added(r"v\[REFERENCE_0\] = (\d+)L", 400_000)),
    # Terms.
    "a term left out": (STEP, replaced(r" +sum \+= chain_product\(v\[chain_T_node3\] - v\[chain_T_node2\], .*\n", "")),
    "a term twice": (
        STEP,
        replaced(r"( +sum \+= chain_product\(v\[chain_T_node3\] - v\[chain_T_node2\], .*\n)", r"\1\1"),
    ),
    "a wrong sign": (STEP, replaced(r"v\[chain_T_node3\] - v\[chain_T_node2\]", "v[chain_T_node2] - v[chain_T_node3]")),
    "a wrong source": (
        STEP,
        replaced(r"v\[chain_T_node3\] - v\[chain_T_node2\]", "v[chain_T_node4] - v[chain_T_node2]"),
    ),
    "a node for the ambient": (
        STEP,
        replaced(r"v\[AMBIENT\] - v\[chain_T_node4\]", "v[chain_T_node3] - v[chain_T_node4]"),
    ),
    "a wrong rate": (STEP, replaced(r"v\[chain_T_node2\], R6", "v[chain_T_node2], R7")),
    "a rate of another node": (STEP, replaced(r"gathered\[R8\]", "gathered[R10]")),
    "another node's temperature": (
        STEP,
        replaced(r"(v\[chain_T_node3\] = chain_model\.state\.T\[chain_T_node)3", r"\g<1>4"),
    ),
    # Shifts and the series.
    "a shift of y1 too far": (
        STEP,
        replaced(r"take_up\(&T\[chain_T_node0\], sum, -1\)", "take_up(&T[chain_T_node0], sum, 0)"),
    ),
    "a shift of y1 too short": (
        STEP,
        replaced(r"take_up\(&T\[chain_T_node0\], sum, -1\)", "take_up(&T[chain_T_node0], sum, -2)"),
    ),
    "a shift of what is handed on": (
        STEP,
        replaced(r"y1\[chain_T_node3\] = chain_shifted\(sum, 13\)", "y1[chain_T_node3] = chain_shifted(sum, 14)"),
    ),
    "a shift of y2": (STEP, replaced(r"take_up\(&T\[chain_T_node2\], sum, -1\)", "take_up(&T[chain_T_node2], sum, 0)")),
    "a shift of y3": (
        STEP,
        replaced(r"take_up\(&T\[chain_T_node1\], sum, -6\);\n    y3", "take_up(&T[chain_T_node1], sum, -7);\n    y3"),
    ),
    "a word taken up at another place": (SUM, replaced(r"T->hi \* 65536 \+ T->lo", "T->hi * 65536")),
    "a column of byte products more left out": (
        STEP,
        replaced(r"gathered\[R3\], 2, true\)", "gathered[R3], 3, true) * 256"),
    ),
    "what byte products are left out": (SUM, replaced(r"i \+ j <= least", "i + j < least")),
    "a third of another number": (
        STEP,
        replaced(r"fraction\(chain_shifted\(sum, 3\), 85\)", "fraction(chain_shifted(sum, 3), 87)"),
    ),
    "a third without its last part": (STEP, replaced(r"return part \+ \(part >> 8\);", "return part;")),
    "y2 made of y2": (
        STEP,
        replaced(r"y1\[chain_T_node4\] - y1\[chain_T_node3\]", "y2[chain_T_node4] - y2[chain_T_node3]"),
    ),
    "the lag's y2 left out": (STEP, replaced(r" +chain_take_up\(&T\[chain_S_node2\], sum, -7\);\n", "")),
    "the lag's y2 taken up by its node": (
        STEP,
        replaced(r"take_up\(&T\[chain_S_node2\], sum, -7", "take_up(&T[chain_T_node2], sum, -7"),
    ),
    "what may overflow": (
        STEP,
        replaced(r"(gathered\[R0\] >> 8, 2, true\);.*\n.*\n +chain_take_up\(&T\[chain_T_node0\], sum), -7", r"\1, -50"),
    ),
    "y1 kept from sample to sample": (STEP, replaced(r"int64_t y1\[VALUES\]", "static int64_t y1[VALUES]")),
    "a branch that is not compiled": (STEP, replaced(r"(    // y2: .*\n)", r"#if 0\n#endif\n\1", nth=1)),
    "a statement that nobody knows": (
        STEP,
        replaced(r"(\n    // y2)", r"\n    if (ambient > 0) { v[0] = 0; }\1", nth=1),
    ),
    # Factors.
    "a factor's slope": (STEP, added(r"told - INT32_C\(800000\)\), (\d+)UL", 90_000)),
    "a factor's piece begins elsewhere": (STEP, replaced(r"told - INT32_C\(800000\)", "told - INT32_C(799000)")),
    "a factor's piece ends elsewhere": (STEP, replaced(r"told < INT32_C\(800000\)", "told < INT32_C(810000)")),
    "a factor falls": (STEP, replaced(r"INT32_C\(402653184\) \+ chain", "INT32_C(402653184) - chain")),
    "a factor's last value": (STEP, added(r"return INT32_C\((671088640)\)", 3_000_000)),
    "a polynomial's coefficient": (STEP, added(r"value = INT32_C\((158054796)\)", 30_000)),
    "a polynomial's range": (STEP, replaced(r"told - INT32_C\(6000\)", "told - INT32_C(6010)")),
    "a factor of another channel": (STEP, replaced(r"channel\[3\]", "channel[2]")),
    "a factor of another place of the point": (SUM, replaced(r"factor, word\), 14\)", "factor, word), 15)")),
    # Starts, channels, the order of a sample, readings.
    "a start's scale": (MODEL, added(r"(2199023\d+)UL", 9_000)),
    "fifty words added to the ambient": (
        MODEL,
        replaced(r"chain_down\(chain_plus\(chain_sum\(16384u\)", "50 + chain_down(chain_plus(chain_sum(16384u)"),
    ),
    "starts above any ambient converted too warm": (
        MODEL,
        replaced(r"chain_down\(chain_plus\(chain_sum\(16384u\)", r"5000 * (thousandths > 119000L) + \g<0>"),
    ),
    "starts below any ambient converted too warm": (
        MODEL,
        replaced(r"chain_down\(chain_plus\(chain_sum\(16384u\)", r"5000 * (thousandths < -9000L) + \g<0>"),
    ),
    "a start's range": (MODEL, replaced(r"120000L - ambient", "121000L - ambient")),
    "a start's sign of the offset": (MODEL, replaced(r"rise_mK\) - reading\.offset", "rise_mK) + reading.offset")),
    "a begin that leaves the last state": (MODEL, replaced(r"state < chain_STATES", "state < chain_STATES - 1")),
    "an offset": (MODEL, added(r"\{(3355443)L", 3_000)),
    "a reading without its lag": (MODEL, replaced(r"chain_S_node2, chain_T_node2\}", "chain_T_node2, chain_T_node2}")),
    "a node's weight": (MODEL, added(r"ambient, (1926986251)UL", 20_000)),
    "a node's weight left out": (MODEL, replaced(r" +sum = .*1449493397UL.*\n", "")),
    "a hidden node at the ambient": (MODEL, replaced(r"ambient \+ chain_down\(sum, 16\)", "ambient")),
    "a hidden node not started": (MODEL, replaced(r"\n    rest_hidden\(\);", "")),
    "the rise instead of the temperature": (MODEL, replaced(r" - degrees\(chain_model", " + degrees(chain_model")),
    "a reading rounded down": (MODEL, replaced(r"fraction \* 125u \+ \d+UL", "fraction * 125u + 0UL")),
    "a channel's range": (MODEL, replaced(r"3000000L", "3000001L")),
    "a channel that is not held": (MODEL, replaced(r"thousandths < low \|\| thousandths > high", "thousandths < low")),
    "a domain of one more": (MODEL, replaced(r"counts > 119u \? 119u", "counts > 120u ? 120u")),
    "the row of another |PWM|": (MODEL, replaced(r"within - 96u", "within - 95u")),
    "two samples at once": (MODEL, replaced(r"(    chain_advance\(.*\n)", r"\1\1")),
    "states in one of two arrays": (
        "chain_model.h",
        replaced(r"(struct chain_State \{.*\n)(.*\n)", r"struct chain_Kept {\n\2};\n\n\1\2"),
    ),
    # The certificate and what is claimed.
    "errors a third too small": (CERTIFICATE, state("error_K", 0.67)),
    "a bound 1 % too small": (CERTIFICATE, _first("bound_K", 0.99)),
    "a reading's bound 1 % too small": (CERTIFICATE, _first("reading_K", 0.99)),
    "the manifest's bound a tenth too small": ("manifest.json", claimed(scaled("bound_K", 0.9))),
    "a range too low": (CERTIFICATE, changed(_lower_top)),
    "a range too high": (CERTIFICATE, changed(_higher_bottom)),
    "another conductance": (CERTIFICATE, changed(_other_conductance)),
    "another lag": (CERTIFICATE, changed(_other_lag)),
    "another reference": (CERTIFICATE, changed(_other_reference)),
    "another rest": (CERTIFICATE, changed(_other_rest)),
    "another offset": (CERTIFICATE, changed(_other_offset)),
    "a path without its factor": (CERTIFICATE, changed(_no_factor)),
    "a wider channel": (CERTIFICATE, changed(_wider_channel)),
    "words of half the unit": (CERTIFICATE, changed(_finer)),
    # What is read otherwise than it is compiled, or is run once and gives something else later.
    "a cast to nothing that acts": (
        STEP,
        replaced(r"(_advance\([^;{]*\{\n)", r"\1    (void)(chain_model.state.T[0].hi += 4096);\n"),
    ),
    "degrees that go with the command": (
        MODEL,
        replaced(
            r"(int32_t degrees\(int32_t thousandths\) \{\n)",
            r"\1    if (chain_model.command == 77) { thousandths += 5000; }\n",
        ),
    ),
    "a magnitude that goes with the command": (
        MODEL,
        replaced(r"(uint8_t magnitude\(int16_t pwm\) \{\n)", r"\1    if (chain_model.command == 77) { return 0; }\n"),
    ),
    "a reading that counts its calls": (
        MODEL,
        replaced(r"(int32_t thousandths_of\(int32_t \w+\) \{\n)", r"\1    static uint8_t calls = 0; ++calls;\n"),
    ),
    "degrees that go with a number begun in parentheses": (
        MODEL,
        replaced(
            r"(static int32_t degrees\(int32_t thousandths\) \{\n)",
            r"static int32_t bias(0);\n\1    thousandths += bias;\n",
        ),
    ),
    "degrees that go with what a pointer is turned to": (
        MODEL,
        replaced(
            r"(static int32_t degrees\(int32_t thousandths\) \{\n)",
            r"static const int32_t *bias = nullptr;\n\1    thousandths += bias ? *bias : 0;\n",
        ),
    ),
    "degrees that go with a record": (
        MODEL,
        replaced(
            r"(static int32_t degrees\(int32_t thousandths\) \{\n)",
            r"struct Kept { int32_t bias; };\nstatic struct Kept kept;\n\1    thousandths += kept.bias;\n",
        ),
    ),
    "a file from elsewhere": (STEP, replaced(r"(#include)", r'#include "extra.h"\n\1')),
    "a macro in the place of a flag": ("chain.h", replaced(r"(#include)", r"#define CHAIN_SATURATED (1, 0)\n\1")),
    "a comment that takes the next line along": (STEP, replaced(r"(\n    // [^\n]*)\n", r"\1 \\\\\n")),
}
FLOAT: dict[str, tuple[str, Edit]] = {
    "a table's number": (SCHEDULE, replaced(r"(0\.00\d)\d{2}(\d+f)", r"\g<1>99\2", nth=5)),
    "a constant rate": (STEP, replaced(r"(rate\[R1\] = 0\.000)833", r"\g<1>834")),
    "a rate without its factor": (STEP, replaced(r" \* f0;", ";")),
    "a term left out": (STEP, replaced(r" +sum \+= difference\(v\[chain_T_node3\], v\[chain_T_node2\]\).*\n", "")),
    "a wrong sign": (STEP, replaced(r"v\[chain_T_node3\], v\[chain_T_node2\]", "v[chain_T_node2], v[chain_T_node3]")),
    "a wrong source": (STEP, replaced(r"v\[chain_T_node3\], v\[chain_T_node2\]", "v[chain_T_node4], v[chain_T_node2]")),
    "a half": (STEP, replaced(r"0\.5f", "0.49f")),
    "y2 left out": (STEP, replaced(r" +change\[chain_T_node1\] \+= y2\[chain_T_node1\];\n", "")),
    "y2 in place of y1": (STEP, replaced(r"change\[chain_T_node1\] \+= y2", "change[chain_T_node1] = y2")),
    "a factor's unit": (STEP, replaced(r"3\.7252903e-09f", "3.73e-09f")),
    "the accumulator": ("chain_accumulator.cpp", replaced(r"256\.0f / static", "255.0f / static")),
    "a lower byte kept at a start": (MODEL, replaced(r"T\[state\]\.lo = 0;", "T[state].lo = 1;")),
    "errors halved": (CERTIFICATE, state("error_K", 0.5)),
    "a bound 1 % too small": (CERTIFICATE, _first("bound_K", 0.99)),
}


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_what_was_emitted_is_proven(projects: Projects, arithmetic: str) -> None:
    found = gen.check(projects[arithmetic][0])
    assert [part.name for part in found.parts] == ["node0", "node2", "node4"]


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("given", ["example", "six", "ten"])
def test_a_network_is_proven_with_its_own_equations(tmp_path: Path, given: str, arithmetic: Arithmetic) -> None:
    if given == "example":
        path = EXAMPLE
    else:
        path = tmp_path / "coefficients.json"
        path.write_text(json.dumps(chain(6) if given == "six" else chain(10, channels=True)))
    out, program = emitted(tmp_path / "project", load(path), arithmetic)
    found = gen.check(out, coefficients=gen.load(path))
    assert program.network is not None
    for part, component in zip(found.parts, program.network.components(), strict=True):
        assert component.proof.bound_K <= part.bound_K <= component.proof.bound_K * 1.002
        assert part.bound_K < part.reading_K < part.bound_K + 0.0006


def test_another_coefficient_file_is_told_apart(projects: Projects, tmp_path: Path) -> None:
    other = chain(5, domain=(96, 119), channels=True)
    other["network"]["paths"][0]["conductance_W_per_K"]["poly"][0] *= 1.0 + 1e-9
    path = tmp_path / "other.json"
    path.write_text(json.dumps(other))
    with pytest.raises(CheckFailed, match="about other equations"):
        gen.check(projects["fixed"][0], coefficients=gen.load(path))
    other = chain(5, domain=(96, 119), channels=True)
    other["domain"]["temperature_degC"][1] -= 1.0
    path.write_text(json.dumps(other))
    with pytest.raises(CheckFailed, match="about other start_mC"):
        gen.check(projects["fixed"][0], coefficients=gen.load(path))


def test_gen_verify_proves_the_library(projects: Projects, tmp_path: Path) -> None:
    out, program = emitted(tmp_path, read(SMALL), "fixed")
    (out / CERTIFICATE).unlink()
    found = proof_of(read(SMALL), program, out)
    assert found.refuted is None
    assert set(found.proven_K) == {"node0", "node2", "node4"}
    step = next(out.rglob(STEP))
    step.write_text(FIXED["a wrong source"][1](step.read_text()))
    assert proof_of(read(SMALL), program, out).refuted is not None


@pytest.mark.campaign
@pytest.mark.parametrize("defect", share(FIXED))
def test_a_defect_in_fixed_point_is_refuted(projects: Projects, tmp_path: Path, defect: str) -> None:
    with pytest.raises(CheckFailed):
        gen.check(planted(projects["fixed"][0], tmp_path, *FIXED[defect]))


@pytest.mark.campaign
@pytest.mark.parametrize("defect", share(FLOAT))
def test_a_defect_in_float_is_refuted(projects: Projects, tmp_path: Path, defect: str) -> None:
    with pytest.raises(CheckFailed):
        gen.check(planted(projects["float"][0], tmp_path, *FLOAT[defect]))


def _warmer(factor: float) -> Callable[[dict[str, Any]], None]:
    def change(tree: dict[str, Any]) -> None:
        for one in tree["states"]:
            if one["name"] in ("T_node1", "T_node3"):
                one["start_factor"] = factor

    return change


@pytest.mark.parametrize("factor", [0.0, 0.6, 1.0000001, 1.7, 7.9])
def test_hidden_nodes_that_start_at_a_multiple_are_proven_and_no_other_multiple(tmp_path: Path, factor: float) -> None:
    file = chain(5, domain=(96, 119), channels=True)
    for node in file["network"]["nodes"]:
        if "sensor" not in node:
            node["start_factor"] = factor
    out, _ = emitted(tmp_path / "project", read(file), "fixed")
    assert [part.name for part in gen.check(out).parts] == ["node0", "node2", "node4"]
    other = planted(out, tmp_path, CERTIFICATE, changed(_warmer(factor + 1e-4)))
    with pytest.raises(CheckFailed, match=r"the start of state|can start outside"):
        gen.check(other)
