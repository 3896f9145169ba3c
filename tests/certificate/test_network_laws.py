"""Networks with natural convection and radiation: what is emitted is proven, planted defects are refuted."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gen
from gen.certificate.document import read as read_certificate
from gen.certificate.network.check import NetworkProof
from gen.certificate.network.document import NetworkCertificate
from gen.certificate.network.laws import Law, enclosed
from gen.certificate.source import Project
from gen.errors import CheckFailed
from gen.lowering.kinds import Arithmetic
from gen.lowering.program import Program
from gen.model.network_solution import NetworkSolution
from gen.reference.network import ReferenceNetwork
from tests.campaign import share
from tests.certificate.networks import emitted, read
from tests.certificate.test_network import changed, state
from tests.certificate.test_planted import Edit, added, planted, replaced
from tests.drawn_networks import with_laws
from tests.examples import ROOT

ARITHMETICS: tuple[Arithmetic, ...] = ("fixed", "float")
DOMAIN = [96, 119]
Projects = dict[str, tuple[Path, Program]]


def closed_motor() -> dict[str, Any]:
    """The example at few |PWM|, with natural convection between two nodes, too."""
    tree = dict(json.loads((ROOT / "examples" / "natural_cooling" / "coeffs.json").read_text(encoding="utf-8")))
    tree["domain"]["pwm"] = tree["validity"]["pwm"] = DOMAIN
    tree["accuracy"] = {"fixed_limit_K": 1e-2, "float_limit_K": 1e-1}
    gap = {
        "between": ["winding", "casing"],
        "conductance_W_per_K": {"poly": [0.12]},
        "convection": {"poly": [0.01, 0.7]},
    }
    tree["network"]["paths"].append(gap)
    return tree


@pytest.fixture(scope="module")
def projects(tmp_path_factory: pytest.TempPathFactory) -> Projects:
    """One project for each arithmetic."""
    return {one: emitted(tmp_path_factory.mktemp(one), read(closed_motor()), one) for one in ARITHMETICS}


def _of_path(number: int, **values: Any) -> Edit:  # noqa: ANN401
    """Other numbers of a path of the certificate."""
    return changed(lambda tree: tree["equations"]["paths"][number].update(values))


STEP, SUM, CERTIFICATE = "closed_motor_step.cpp", "closed_motor_sum.h", "certificate.json"
CASING = r"closed_motor_model\.state\.T\[closed_motor_T_casing\]"
MAGNET = "closed_motor_model.state.T[closed_motor_T_magnet]"
LATER = r"y1\[AMBIENT\] - y1\[closed_motor_T_casing\], gathered\[R3_LATER\]"


def _flow(number: int, made: str) -> Edit:
    """What the computer's C++ makes of a temperature and of what drives; the AVR's has other names."""
    return replaced(rf"( v\[FLOW_{number}\] = v\[\w+\]) [+-] driving\d", rf"\1{made}")


VALUE = r"value = INT32_C\((-?\d+)\)"
"""A coefficient of the casing's law: three of its slope, then four of what drives."""
FIXED: dict[str, tuple[str, Edit]] = {
    # What laws are evaluated by.
    "a coefficient of what drives": (STEP, added(VALUE, 3_000, 5)),
    "the last coefficient of what drives": (STEP, added(VALUE, 3_000, 6)),
    "a coefficient of a slope": (STEP, added(VALUE, 30_000_000, 2)),
    "a slope of another law": (STEP, replaced(r"&slope\[1\]", "&slope[0]")),
    "the widest difference": (STEP, added(r"up<2>\(d\), (\d+)UL", 60_000)),
    "a difference shifted less": (STEP, replaced(r"up<2>\(d\)", "up<1>(d)")),
    "a difference of the other sign": (STEP, replaced(r"-driving : driving", "driving : -driving")),
    "a magnitude that is none": (STEP, replaced(r"_of\(d < 0 \? -d : d", "_of(d < 0 ? d : d")),
    "a slope below 0": (STEP, replaced(r"\*slope = 0;", "*slope = -1;")),
    "0 degC in kelvin": (STEP, added(r"INT32_C\((572837069)\)", 2_000)),
    "what is rounded to kelvin": (STEP, replaced(r"INT32_C\(1\)\) >> 1", "INT32_C(1)) >> 2")),
    "a third power for a fourth": (STEP, replaced(r"(part\(\(uint32_t\))beside, beside", r"\1cold, beside")),
    "a second power for a third": (STEP, replaced(r"(part\(\(uint32_t\))warm, square", r"\1warm, warm")),
    "the factor of radiation": (STEP, added(r"part\((\d{9,})UL, fourth\)", 9_000)),
    "the factor of its slope": (STEP, added(r"\*slope = closed_motor_part\((\d+)UL", 90_000_000)),
    "radiation the wrong way round": (STEP, replaced(r"square, square\) - closed", "square, square) + closed")),
    "a place of the point": (SUM, replaced(r"(_part\(.*), 14\)", r"\1, 13)")),
    # What they are told, and what becomes of it.
    "another temperature": (STEP, replaced(rf"convection0\({CASING}", f"convection0({MAGNET}")),
    "no other end": (STEP, replaced(r"T_casing\]\.hi - ambient, &slope", "T_casing].hi - 0, &slope")),
    "both ends changed places": (STEP, replaced(r"radiation1\((closed.*?), ambient", r"radiation1(ambient, \1")),
    "both laws of one function": (STEP, replaced(r"convection2\(closed", "convection0(closed")),
    "what drives the wrong way": (STEP, _flow(0, " + driving0")),
    "what drives another path": (STEP, _flow(0, " - driving1")),
    "a node that heat does not leave": (STEP, _flow(3, "")),
    "a node that heat does not reach": (STEP, _flow(2, "")),
    "an ordinary difference": (STEP, replaced(r"v\[FLOW_0\] - v", "v[AMBIENT] - v")),
    "a law's rate": (STEP, added(r"R3 = (\d+)UL", 400_000)),
    "a slope that does not count": (STEP, replaced(r"closed_motor_scaled\(R3, slope\[0\]\)", "R3")),
    "a slope of another path": (STEP, replaced(r"R3, slope\[0\]", "R3, slope[1]")),
    "a rate of y1 in y2": (STEP, replaced(r"gathered\[R4_LATER\]", "R4")),
    "a law left out of y1": (STEP, replaced(r" +sum \+= closed_motor_product\(v\[FLOW_0\].*\n", "")),
    "a law left out of y2": (STEP, replaced(rf" +sum \+= closed_motor_product\({LATER}.*\n", "")),
    # The certificate and what is claimed.
    "errors a third too small": (CERTIFICATE, state("error_K", 0.67)),
    "another polynomial": (CERTIFICATE, _of_path(4, convection=[4.0e-7, -1.12e-4, 0.0132, 0.761])),
    "an ordinary path": (CERTIFICATE, _of_path(4, convection=None, scale=1.0)),
    "another reference": (CERTIFICATE, _of_path(5, radiation_degC=25.1)),
    "convection for radiation": (CERTIFICATE, _of_path(5, radiation_degC=None, convection=[1.0])),
    "another scale": (CERTIFICATE, _of_path(4, scale=4.0)),
    "a falling law": (CERTIFICATE, _of_path(6, convection=[-0.02, 0.7])),
}
ALIKE = (
    "a difference of the other sign",
    "a third power for a fourth",
    "both ends changed places",
    "what drives the wrong way",
    "a node that heat does not leave",
    "another scale",
)
FLOAT: dict[str, tuple[str, Edit]] = {
    **{name: FIXED[name] for name in ALIKE},
    "a slope that does not count": (STEP, replaced(r"(rate\[R3_LATER\] = rate\[R3\]) \* .*;", r"\1;")),
    "a slope's unit": (STEP, replaced(r"9\.313226e-10f", "1.3e-09f")),
    "y2 with the rates of y1": (STEP, replaced(r"T_casing_later\(y1, rate\)", "T_casing(y1, rate, 0.0f)")),
    "an ordinary difference": (STEP, replaced(r"v\[FLOW_0\], v", "v[AMBIENT], v")),
    "errors halved": (CERTIFICATE, state("error_K", 0.5)),
}


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_what_was_emitted_is_proven(projects: Projects, tmp_path: Path, arithmetic: str) -> None:
    path = tmp_path / "coefficients.json"
    path.write_text(json.dumps(closed_motor()))
    out, program = projects[arithmetic]
    found = gen.check(out, coefficients=gen.load(path))
    assert program.network is not None
    for part, component in zip(found.parts, program.network.components(), strict=True):
        assert component.proof.bound_K <= part.bound_K <= component.proof.bound_K * 1.002


@pytest.mark.parametrize("key", ["convection", "radiation"])
def test_another_law_is_told_apart(projects: Projects, tmp_path: Path, key: str) -> None:
    other = closed_motor()
    path = next(path for path in other["network"]["paths"] if key in path)
    path[key] = {"poly": [4.0e-7, -1.12e-4, 0.0132, 0.76 + 1e-12]} if key == "convection" else {"reference_degC": 25.5}
    file = tmp_path / "other.json"
    file.write_text(json.dumps(other))
    with pytest.raises(CheckFailed, match="about other equations"):
        gen.check(projects["fixed"][0], coefficients=gen.load(file))


@pytest.mark.parametrize(
    ("seed", "size", "arithmetic"),
    [(0, 1, "fixed"), (1, 3, "fixed"), (2, 4, "fixed"), (3, 5, "fixed"), (1, 3, "float")],
)
def test_random_networks_are_proven(tmp_path: Path, seed: int, size: int, arithmetic: Arithmetic) -> None:
    out, program = emitted(tmp_path, read(with_laws(seed, size)), arithmetic)
    assert {part.name for part in gen.check(out).parts} == {part.name for part in program.parts}


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_light_nodes_are_proven_up_to_a_tenth_of_a_kelvin(tmp_path: Path, arithmetic: Arithmetic) -> None:
    tree = with_laws(2, 4)
    for node in tree["network"]["nodes"]:
        node["capacity_J_per_K"] *= 0.3
    out, _ = emitted(tmp_path, read(tree), arithmetic)
    assert 0.01 < max(part.bound_K for part in gen.check(out).parts) < 0.1


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_no_sample_of_the_reference_is_off_by_more_than_the_defect(projects: Projects, arithmetic: Arithmetic) -> None:
    """Random states and |PWM|, corners among them, against the exact solution."""
    out, program = projects[arithmetic]
    certificate, network, lanes = read_certificate(out), program.network, 4000
    assert isinstance(certificate, NetworkCertificate)
    assert network is not None
    defects = NetworkProof(Project(out, certificate.model), certificate).defects()
    generator = np.random.default_rng(5)
    bits = network.fraction_bits + (16 if arithmetic == "fixed" else 8)
    ends = np.array([state.range_degC for state in certificate.states])
    share = generator.uniform(size=(lanes, len(ends)))
    share[: lanes // 2] = np.round(share[: lanes // 2])
    words = np.rint((ends[:, 0] + share * (ends[:, 1] - ends[:, 0])) * 2.0**bits).astype(np.int64)
    told = np.array([generator.integers(c.low, c.high + 1, lanes) for c in certificate.equations.channels])
    rows = generator.integers(DOMAIN[0], DOMAIN[1] + 1, lanes)
    starts = {part.name: [0] * lanes for part in certificate.components}
    domain = (DOMAIN[0], DOMAIN[1])
    reference = ReferenceNetwork(network, domain, domain, starts, told)
    reference._state = words.T.copy()
    reference.step(rows)
    solution = NetworkSolution(read(closed_motor()).model)
    step = np.full(lanes, certificate.sample_time_s)
    exact = solution.advance(words * 2.0**-bits, rows, step, told[0] / 1000.0)
    away = np.abs(reference._state.T * 2.0**-bits - exact)
    bounds = defects[rows - DOMAIN[0]]
    assert np.all(away <= bounds + 1e-11)  # what the exact solution is off by
    assert np.all((away / bounds).max(axis=0) > 0.05)


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


COEFFICIENTS = st.lists(st.floats(-2.0, 2.0), min_size=1, max_size=4)


@given(COEFFICIENTS, st.floats(0.1, 200.0), st.floats(0.0, 1.0))
@settings(max_examples=100)
def test_a_polynomial_lies_within_its_ends(polynomial: list[float], widest: float, share: float) -> None:
    low, high = enclosed(polynomial, widest)
    size = float(np.polyval(np.abs(polynomial), widest))
    assert low <= np.polyval(polynomial, share * widest) + 1e-13 * size
    assert np.polyval(polynomial, share * widest) - 1e-13 * size <= high
    values = np.polyval(polynomial, np.linspace(0.0, widest, 20_001))
    assert high - low <= values.max() - values.min() + 1e-3 * size


def test_ends_of_a_law_hold_it() -> None:
    generator = np.random.default_rng(2)
    one, other = (-10.0, 120.0), (0.0, 45.0)
    for law in (Law(0, 0, None, (4e-7, -1.12e-4, 0.0132, 0.76), 0.0, 2.0), Law(0, 0, None, (), 298.15, 2.0)):
        (low, high), slopes = law.driving_ends(one, other), law.slope_ends(one, other)
        for _ in range(200):
            a, b = generator.uniform(*one), generator.uniform(*other)
            value, size = law.driving(a, b)
            assert low - 1e-12 * size <= value <= high + 1e-12 * size
            steep = (law.driving(a + 1e-3, b)[0] - law.driving(a - 1e-3, b)[0]) / 2e-3
            assert slopes[0] - 1e-6 <= steep <= slopes[1] + 1e-6
