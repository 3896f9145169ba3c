"""Every example's claims are proven anew, from the emitted C++ alone."""

from __future__ import annotations

import json
import time
from pathlib import Path

import pytest

import gen
from gen.lowering.kinds import Arithmetic, ScheduleKind
from tests.campaign import FULL
from tests.certificate.projects import ROOT
from tests.examples import WITH_TRANSFER_FUNCTIONS

FORMS: list[tuple[Arithmetic, ScheduleKind]] = [("fixed", "table"), ("float", "onboard")]
OTHERS: list[tuple[str, Arithmetic, ScheduleKind]] = [
    ("my1016", "fixed", "onboard"),
    ("my1016", "float", "table"),
    ("two_mass", "fixed", "onboard"),
]
EACH = [(name, *form) for name in WITH_TRANSFER_FUNCTIONS for form in FORMS]
BY_TURNS = [(name, *FORMS[number % 2]) for number, name in enumerate(WITH_TRANSFER_FUNCTIONS)]


@pytest.mark.campaign
@pytest.mark.parametrize(("name", "arithmetic", "schedule"), [*(EACH if FULL else BY_TURNS), *OTHERS])
def test_an_example_is_proven(tmp_path: Path, name: str, arithmetic: Arithmetic, schedule: ScheduleKind) -> None:
    model = gen.load(ROOT / "examples" / name / "coeffs.json")
    built = gen.build(model, tmp_path / "project", arithmetic=arithmetic, schedule=schedule)
    before = time.process_time()
    found = gen.check(tmp_path / "project", coefficients=model)
    assert time.process_time() - before < 60.0, "a proof is quick: some seconds on an idle machine"
    claimed = built.guarantees()["bound_K"]
    for part in found.parts:
        # The certificate claims what `gen build` says, to four digits.
        assert claimed[part.name] <= part.bound_K <= claimed[part.name] * 1.002
    manifest = json.loads((tmp_path / "project" / "manifest.json").read_text())
    assert [part.name for part in found.parts] == [part["name"] for part in manifest["components"]]
