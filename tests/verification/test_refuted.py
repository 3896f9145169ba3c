"""A bound that does not follow from the C++ is as bad as a word that differs."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

import pytest

import gen
from gen.errors import CheckFailed
from gen.interface.firmware import Verification
from gen.verification.report import print_results
from gen.verification.verify import CombinationResult, summary, verify
from tests.examples import example

SENTENCE = "winding: inequality 7 fails at |PWM| 128"


@cache
def result(*, spoilt: bool = False) -> CombinationResult:
    """Of two_mass; spoilt, with the first digit of a rate changed."""

    def mutation(files: dict[str, str]) -> dict[str, str]:
        path = next(path for path in files if path.endswith("_schedule.cpp"))
        other = re.sub(r"(?<=\{)\d(?=\d*UL)", lambda found: "2" if found[0] == "1" else "1", files[path], count=1)
        return {**files, path: other}

    given = mutation if spoilt else None
    return verify(
        example("two_mass"), ["fixed"], ["table"], "host", scale=0.005, host_builds=["g++ -O2"], mutation=given
    )[0]


def refuted() -> CombinationResult:
    return replace(result(), proven_K={}, inequalities=0, refuted=SENTENCE)


def test_what_is_proven_anew_is_no_more_than_what_is_guaranteed(capsys: pytest.CaptureFixture[str]) -> None:
    found = result()
    assert (found.passed, found.refuted) == (True, None)
    assert found.inequalities > 1000
    for name, bound in found.bound_K.items():
        assert bound is not None
        assert 0.0 < found.proven_K[name] <= 1.0001 * bound
    model = gen.load("examples/two_mass/coeffs.json")
    Verification(model, [found]).check()
    frame = Verification(model, [found]).errors()
    assert frame.loc[("fixed/table", "winding"), "proven_K"] == found.proven_K["winding"]
    print_results([found])
    assert "proven anew K" in capsys.readouterr().out


def test_a_refuted_bound_fails_where_every_word_is_equal(capsys: pytest.CaptureFixture[str]) -> None:
    model = gen.load("examples/two_mass/coeffs.json")
    found = refuted()
    assert found.equal
    assert not found.passed
    with pytest.raises(CheckFailed, match=r"^fixed/table, winding: inequality 7 fails at \|PWM\| 128$"):
        Verification(model, [result(), found]).check()
    assert summary(model.coefficients, [found])["verdict"] == "inaccurate"
    assert Verification(model, [found]).errors()["proven_K"].isna().all()
    print_results([found])
    said = capsys.readouterr().out
    assert f"fixed/table, the guarantee does not follow from the C++: {SENTENCE}" in " ".join(said.split())
    assert said.count("refuted") == 2


def test_a_changed_digit_of_a_rate_is_refuted_as_well() -> None:
    found = result(spoilt=True)
    assert not found.equal
    assert found.refuted is not None
