"""The parts of the proof of networks, each against something that does not share its code."""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from gen.certificate.document import read as read_certificate
from gen.certificate.network.arithmetic import Arithmetic as Computing
from gen.certificate.network.arithmetic import Number
from gen.certificate.network.check import NetworkProof
from gen.certificate.network.document import NetworkCertificate
from gen.certificate.network.flow import change, flows
from gen.certificate.network.forms import Form, Space
from gen.certificate.network.machine import Machine
from gen.certificate.network.memory import Model
from gen.certificate.network.rest import rest_weights
from gen.certificate.network.single import single
from gen.certificate.network.source import Unit
from gen.certificate.network.words import low_bits
from gen.certificate.refuted import Refuted
from gen.certificate.source import Project
from gen.lowering.kinds import Arithmetic
from gen.model.network_solution import NetworkSolution
from gen.reference.network import ReferenceNetwork
from tests.certificate.networks import chain, emitted, read

DOMAIN = (96, 119)
SMALL = chain(5, domain=DOMAIN, channels=True)


def _certificate(folder: Path) -> NetworkCertificate:
    found = read_certificate(folder)
    assert isinstance(found, NetworkCertificate)
    return found


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
def test_no_sample_of_the_reference_is_off_by_more_than_the_defect(tmp_path: Path, arithmetic: Arithmetic) -> None:
    """Random states, channels and |PWM|, against the matrix exponential; and the bound is none of ten times as much."""
    coefficients, lanes = read(SMALL), 4000
    out, program = emitted(tmp_path, coefficients, arithmetic)
    certificate, network = _certificate(out), program.network
    assert network is not None
    defects = NetworkProof(Project(out, certificate.model), certificate).defects()
    generator = np.random.default_rng(5)
    bits = network.fraction_bits + low_bits(Project(out, certificate.model))
    ends = np.array([state.range_degC for state in certificate.states])
    share = generator.uniform(size=(lanes, len(ends)))
    share[: lanes // 2] = np.round(share[: lanes // 2])  # corners: there the terms are largest
    words = np.rint((ends[:, 0] + share * (ends[:, 1] - ends[:, 0])) * 2.0**bits).astype(np.int64)
    told = np.array([generator.integers(c.low, c.high + 1, lanes) for c in certificate.equations.channels])
    rows = generator.integers(DOMAIN[0], DOMAIN[1] + 1, lanes)
    starts = {part.name: [0] * lanes for part in certificate.components}
    reference = ReferenceNetwork(network, DOMAIN, DOMAIN, starts, told)
    reference._state = words.T.copy()
    reference.step(rows)
    assert np.all(reference.saturations == 0)
    solution = NetworkSolution(coefficients.model)
    columns = {c.column: told[k] / 1000.0 for k, c in enumerate(certificate.equations.channels) if k}
    steps = solution.steps(rows, np.full(lanes, certificate.sample_time_s), columns)
    exact = np.einsum("kij,kj->ki", steps.increment, words * 2.0**-bits)
    exact += steps.ambient * (told[0] / 1000.0)[:, None] + steps.heat
    away = np.abs((reference._state.T - words) * 2.0**-bits - exact)
    bounds = defects[rows - DOMAIN[0]]
    assert np.all(away <= bounds)
    assert np.all((away / bounds).max(axis=0) > 0.1)


def test_the_exact_change_is_that_of_the_matrix_exponential(tmp_path: Path) -> None:
    coefficients = read(SMALL)
    certificate = _certificate(emitted(tmp_path, coefficients, "fixed")[0])
    factors = [(1.0, 2.5), (0.5, 1.4), (0.0, 144.0)]
    states = [state.range_degC for state in certificate.states]
    space = Space([*states, (0.0, 45.0)], factors, certificate.rows)
    n = len(states)
    found = change(
        space,
        [space.temperature(k) for k in range(n)],
        space.temperature(n),
        [space.factor(k) for k in range(3)],
        flows(certificate),
    )
    generator = np.random.default_rng(3)
    model = coefficients.model
    assert model.network is not None
    solution, rows = NetworkSolution(model), np.arange(DOMAIN[0], DOMAIN[1] + 1)
    for _ in range(20):
        t, p = generator.uniform(-1.0, 1.0, n + 1), generator.uniform(-1.0, 1.0, 3)
        values = [low + (1.0 + at) / 2.0 * (high - low) for at, (low, high) in zip(p, factors, strict=True)]
        every = np.ones(len(rows))
        path_factors = [every] * 7
        path_factors[0], path_factors[6] = values[0] * every, values[0] * values[1] * every
        m, a, f = model.network.matrices_with(rows, path_factors, [every, values[2] * every])
        m, a, f = solution.with_sensors(m, a, f)
        box = zip(t, [*states, (0.0, 45.0)], strict=True)
        temperatures = np.array([low + (1.0 + at) / 2.0 * (high - low) for at, (low, high) in box])
        rate = (m @ temperatures[:n] + a * temperatures[n] + f) * certificate.sample_time_s
        expected, term = np.zeros_like(rate), rate
        for k in range(2, 20):
            expected, term = expected + term, np.einsum("kij,kj->ki", m, term) * certificate.sample_time_s / k
        for k, form in enumerate(found):
            assert np.all(np.abs(_at(form, t, p) - expected[:, k]) <= form.radius + 1e-10)
            assert np.all(form.radius < 1e-11)


def _at(form: Form, t: NDArray[Any], p: NDArray[Any]) -> NDArray[Any]:
    """A form's value where the temperatures' and factors' symbols are these: arrays of float64, or of fractions."""
    total = np.zeros_like(form.radius)
    for powers, coefficients in form.terms.items():
        total = total + np.prod(p ** np.array(powers)) * (coefficients[0] + t @ coefficients[1:])
    return total


def _fractions(form: Form) -> Form:
    """The same form, so that nothing is rounded when it is evaluated."""
    exact = np.vectorize(Fraction, otypes=[object])
    return Form({powers: exact(coefficients) for powers, coefficients in form.terms.items()}, exact(form.radius))


def _symbol(form: Form, value: Fraction) -> Fraction:
    """Where in -1 .. 1 the symbol of a temperature or of a factor stands for this value."""
    (half,) = (row[0] for powers, c in form.terms.items() for k, row in enumerate(c) if row[0] and (k or any(powers)))
    return (value - Fraction(form.constant[0])) / Fraction(half)


@pytest.mark.parametrize("nodes", [3, 5, 8])
def test_hidden_nodes_rest_where_the_model_says(tmp_path: Path, nodes: int) -> None:
    coefficients = read(chain(nodes, domain=DOMAIN, channels=True))
    certificate = _certificate(emitted(tmp_path, coefficients, "fixed")[0])
    network = coefficients.model.network
    assert network is not None
    sensed = [network.index(node.name) for node in network.sensed]
    for weights, expected in zip(rest_weights(certificate), network.hidden_at_start, strict=True):
        found = [float(weights.get(place, 0)) for place in (*sensed, None)]
        assert np.allclose(found, expected, rtol=1e-12, atol=1e-15)


POINTS = st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3)


@given(POINTS, POINTS, st.floats(-3.0, 3.0))
def test_a_form_holds_what_it_stands_for(t: list[float], p: list[float], c: float) -> None:
    space = Space([(-10.0, 120.0), (0.0, 45.0), (3.0, 4.0)], [(0.0, 2.0), (1.0, 1.5), (0.1, 0.7)], 1)
    about_t, about_p = [(55.0, 65.0), (22.5, 22.5), (3.5, 0.5)], [(1.0, 1.0), (1.25, 0.25), (0.4, 0.3)]
    temperatures = [Fraction(middle + half * at) for (middle, half), at in zip(about_t, t, strict=True)]
    factors = [Fraction(middle + half * at) for (middle, half), at in zip(about_p, p, strict=True)]
    made = space.temperature(0) - space.temperature(1).times(c)
    made = made.product(space.factor(0)).product(space.factor(1)) + space.temperature(2).product(space.factor(2))
    value = (temperatures[0] - Fraction(c) * temperatures[1]) * factors[0] * factors[1] + temperatures[2] * factors[2]
    hot = np.array([_symbol(space.temperature(k), at) for k, at in enumerate(temperatures)])
    strong = np.array([_symbol(space.factor(k), at) for k, at in enumerate(factors)])
    assert all(abs(at) <= 1 for at in (*hot, *strong))
    assert abs(_at(_fractions(made), hot, strong)[0] - value) <= Fraction(made.radius[0])
    low, high = made.ends
    assert low[0] <= value <= high[0]
    assert made.radius[0] < 1e-9
    wide, narrow = made.within(1.0), made.within(1.0).trimmed(1e-3)
    assert wide.ends[0][0] >= narrow.ends[0][0] - 1e-9
    with pytest.raises(Refuted):
        made.product(space.temperature(0))


PROGRAM = """
#include "some_platform.h"
enum { A, B = A, C };
int32_t small(int16_t a, int16_t b) { return a * b; }
int32_t wide(int16_t a, int16_t b) { return (int32_t)a * b; }
uint32_t sign(int32_t a) { return (uint32_t)a; }
int32_t down(int32_t a) { return a >> 3; }
int32_t loop(const int32_t *v) { int32_t sum = 0; for (uint8_t i = 0; i < 3; ++i) { sum += v[i]; } return sum; }
int32_t last(void) { int32_t v[C] = {0}; v[C] = 1L; return v[A]; }
int32_t empty(void) { int32_t v[C]; return v[A] + 1L; }
int32_t either(int32_t a) { return a > 0 ? a : 0; }
float rounds(int32_t a) { return static_cast<float>(a) * 0.1f; }
double other(int32_t a) { double b = a; return b; }
int32_t kept(int32_t a) { static int32_t b = 0L; return a; }
"""


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    folder = tmp_path / "lib" / "some" / "src"
    folder.mkdir(parents=True)
    (folder / "some_step.cpp").write_text(PROGRAM)
    (folder / "some_platform.h").write_text("#include <stdint.h>\n")
    unit = Unit(Project(tmp_path, "some"), "_step.cpp")
    return Machine(unit, {}, Space([(-300.0, 300.0)], [], 1), Model([]), lambda *_: pytest.fail("no channel"))


KNOWN = Computing(Space([(-300.0, 300.0)], [], 1)).known


def _number(low: float, high: float, kind: str) -> Number:
    return Number(kind, Space([(low, high)], [], 1).temperature(0))


def test_numbers_stay_within_their_types(machine: Machine) -> None:
    large, word = _number(-300.0, 300.0, "int16_t"), _number(-1e6, 1e6, "int32_t")
    with pytest.raises(Refuted, match="int16_t can reach"):  # on the AVR an int has 16 bits
        machine.call("small", large, KNOWN(200.0, "int16_t"))
    assert machine.call("wide", large, KNOWN(200.0, "int16_t")).form.largest[0] == pytest.approx(60000.0)
    with pytest.raises(Refuted, match="uint32_t can reach"):
        machine.call("sign", word)
    low, high = machine.call("down", word).form.ends
    assert low[0] == pytest.approx(-125001.0, abs=0.2)
    assert high[0] == pytest.approx(125000.0, abs=0.2)
    with pytest.raises(Refuted, match="can reach"):
        machine.call("down", _number(-3e9, 3e9, "int64_t"))
    form = machine.call("rounds", KNOWN(2.0**24 + 1.0)).form
    assert abs(form.constant[0] - (2.0**24 + 1.0) * float(np.float32(0.1))) <= form.radius[0] < 0.3


@pytest.mark.parametrize("name", ["last", "empty", "either", "other", "kept", "nothing"])
def test_what_is_not_understood_is_refuted(machine: Machine, name: str) -> None:
    arguments = [_number(-5.0, 5.0, "int32_t")] if name not in ("last", "empty") else []
    with pytest.raises(Refuted):
        machine.call(name, *arguments)


@pytest.mark.parametrize("text", ["0.1f", "3.7252903e-09f", "1e+10f", "0.00010526316f", "0.0f"])
def test_a_literal_is_the_float32_that_reads_so(text: str) -> None:
    assert single(text) == float(np.float32(text[:-1]))


@pytest.mark.parametrize("text", ["0.1", "x", "1e40f", "16777217.0f"])
def test_no_literal_is_guessed(text: str) -> None:
    with pytest.raises(Refuted, match=re.escape(text)):
        single(text)
