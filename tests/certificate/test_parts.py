"""The checker's own parts against oracles that share nothing with them."""

from __future__ import annotations

import itertools
from decimal import Decimal, localcontext
from fractions import Fraction
from math import comb
from pathlib import Path

import numpy as np
import pytest

from gen.certificate import document
from gen.certificate.check import PartProof
from gen.certificate.document import Equation, Pole, Schedule
from gen.certificate.equation import enclose
from gen.certificate.exact import BITS, Ratio, Ratios, inverse, ratios
from gen.certificate.measured import measure
from gen.certificate.polytope import Directions, Images, largest
from gen.certificate.refuted import Refuted
from gen.certificate.source import Project
from gen.certificate.step import Recursion
from gen.coefficients import load
from gen.errors import InputError
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.reference.lanes import state_fields
from gen.reference.model import ReferenceModel
from tests.certificate.projects import DOMAIN, built, small


def constant(value: float) -> Schedule:
    return Schedule(pieces=[(0, 255, [Ratio(value)])])


def test_distinct_real_poles_have_their_closed_form() -> None:
    """E's first row at T' = 0 is the initial response: sum of e^(p Ts) weighted by Lagrange's polynomials at 0."""
    poles, step = [-0.25, -0.5, -1.5], Fraction(1, 4)
    equation = Equation(
        poles=[Pole(real=constant(p)) for p in poles], gain=constant(0.75), held=(0, 255), no_gain_outside=(0, 255)
    )
    found = enclose(equation, (100, 101), step)
    with localcontext() as context:
        context.prec = 60
        expected = Decimal(0)
        for p in poles:
            others = [q for q in poles if q != p]
            weight = Decimal(1)
            for q in others:
                weight *= Decimal(-q) / (Decimal(p) - Decimal(q))
            expected += weight * (Decimal(p) / 4).exp()
        difference = abs(Fraction(int(found.transition[0, 0, 0]), 1 << BITS) - Fraction(expected))
    assert difference <= Fraction(found.radius, 1 << BITS) + Fraction(1, 10**50)
    assert Fraction(found.radius, 1 << BITS) < Fraction(1, 10**45)
    assert abs(found.steady[1] - Fraction(0.75) * 101 / Fraction(0.25 * 0.5 * 1.5)) <= found.steady_radius


def test_a_triple_pole_has_its_closed_form() -> None:
    equation = Equation(
        poles=[Pole(real=constant(-1.0))] * 3, gain=constant(0.0), held=(0, 255), no_gain_outside=(0, 255)
    )
    found = enclose(equation, (5, 5), Fraction(1, 8))
    with localcontext() as context:
        context.prec = 60
        h = Decimal(1) / 8
        decay = (-h).exp()
        expected = decay * (1 + h + h * h / 2)  # T of (1 + t + t^2/2) e^-t
    assert abs(Fraction(int(found.transition[0, 0, 0]), 1 << BITS) - Fraction(expected)) < Fraction(1, 10**45)


def test_a_negative_gain_is_taken_as_zero_outside() -> None:
    gain = Schedule(pieces=[(0, 255, [Ratio(1), Ratio(-100)])])  # |PWM| - 100
    equation = Equation(poles=[Pole(real=constant(-1.0))], gain=gain, held=(0, 255), no_gain_outside=(80, 255))
    found = enclose(equation, (70, 90), Fraction(1, 4))
    assert all(value == 0 for value in found.steady[:10])
    assert found.steady[10] < 0  # inside it is what it is


def test_an_inverse_is_exact() -> None:
    matrix = ratios([[Fraction(1, comb(i + j + 2, 2)) for j in range(4)] for i in range(4)])
    assert (matrix @ inverse(matrix) == ratios(np.eye(4).astype(int).tolist())).all()


def test_a_polytope_is_never_read_too_small() -> None:
    """Against the corners of random polytopes about the origin, by enumeration of random points inside."""
    generator = np.random.default_rng(4)
    angles = np.linspace(0.0, np.pi, 40, endpoint=False)
    along = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    along[0], along[20] = (1.0, 0.0), (0.0, 1.0)
    heights = 1.0 + generator.random(40)
    directions = Directions(ratios(along.tolist()), np.eye(2))
    points = generator.normal(size=(200_000, 2))
    inside = points[(np.abs(points @ along.T) <= heights).all(axis=1)]
    targets = generator.normal(size=(50, 2))
    found = largest(directions, ratios(heights.tolist()), ratios(targets.tolist())).astype(float)
    assert np.all(found >= np.abs(inside @ targets.T).max(axis=0))
    turn = np.array([[[0.9, 0.3], [-0.3, 0.8]]])
    box = directions.box(ratios(heights.tolist())).astype(float)
    images = Images(directions, turn).largest(heights, box)
    assert np.all(images[0] >= np.abs(inside @ turn[0].T @ along.T).max(axis=0))


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
@pytest.mark.parametrize("schedule", ["table", "onboard"])
def test_no_word_of_the_board_leaves_what_its_cpp_was_read_as(tmp_path: Path, arithmetic: str, schedule: str) -> None:
    """The reference's words over random PWM: W' = A W + b within the columns, at each sample, held or changed."""
    out = built(tmp_path, small(1, 2, 3), arithmetic, schedule)
    certificate = document.read(out)
    assert isinstance(certificate, document.Certificate)
    project = Project(out, certificate.model)
    measured = measure(project, certificate)
    program = lower(load(tmp_path / "coefficients.json"), certificate.arithmetic, certificate.schedule)
    generator = np.random.default_rng(11)
    pwm = np.repeat(generator.integers(DOMAIN[0], DOMAIN[1] + 1, 150), generator.integers(1, 4, 150)).tolist()
    for number, part in enumerate(certificate.parts):
        assert part.substeps == 1
        proof = PartProof(project, certificate, part, measured[part.name])
        runs, _ = proof.recursion.runs(proof.enclosing)
        model = ReferenceModel(program, [25_000])
        model.step(np.array(pwm[:1]))
        words = _words(model, program, number)
        for before, value in itertools.pairwise(pwm):
            start = _combined(proof.recursion, words, before - DOMAIN[0])
            model.step(np.array([value]))
            words = _words(model, program, number)
            run = runs[1 if before != value and proof.recursion.carries else 0]
            row = value - DOMAIN[0]
            expected = run.matrix[row] @ start + run.constant[row]
            away = np.abs((_combined(proof.recursion, words, row) - expected).astype(float))
            assert np.all(away <= np.abs(run.columns[row]).sum(axis=0) * (1.0 + 1e-9)), (part.name, before, value)


def _words(model: ReferenceModel, program: Program, number: int) -> Ratios:
    """The state's words as whole numbers."""
    component, record = program.components[number], model.state_record()
    low_bits = 16 if program.arithmetic == "fixed" else 8
    names = [name for name, _ in state_fields(component)]
    pairs = zip(names[::2], names[1::2], strict=True)
    return ratios((int(record[high][0]) << low_bits) + int(record[low][0]) for low, high in pairs)


def _combined(recursion: Recursion, words: Ratios, row: int) -> Ratios:
    """W of the words at one PWM."""
    drive = recursion.drive
    combined = words.copy()
    if recursion.carries:
        q = drive.linear[:, row] @ words + drive.constant[row]
        combined[len(words) - 2] = combined[len(words) - 2] - drive.share * q
    return combined


def test_bad_certificates_are_refused(tmp_path: Path) -> None:
    out = built(tmp_path, small(1), "fixed", "table")
    path = out / "certificate.json"
    text = path.read_text()
    path.write_text(text[: len(text) // 2])
    with pytest.raises(InputError, match=r"certificate\.json"):
        document.read(out)
    path.write_text(text.replace('"version": 1', '"version": 3'))
    with pytest.raises(InputError, match=r"\$\.version"):
        document.read(out)
    path.unlink()
    with pytest.raises(InputError, match="gen build"):
        document.read(out)


def test_other_cpp_is_refuted_rather_than_guessed(tmp_path: Path) -> None:
    out = built(tmp_path, small(2), "fixed", "table")
    step = next(out.rglob("small_step.h"))
    step.write_text(step.read_text().replace("int32_t inner = state", "int32_t inner = state->x[0].hi % 3 + state", 1))
    certificate = document.read(out)
    assert isinstance(certificate, document.Certificate)
    project = Project(out, certificate.model)
    part = certificate.parts[0]
    with pytest.raises(Refuted):
        Recursion(project, certificate.arithmetic, part, measure(project, certificate)[part.name].table)
