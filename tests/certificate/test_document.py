"""What a certificate may say: an ambient within its range, and a start of at most 2^23 thousandths, ends included."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from pydantic import TypeAdapter, ValidationError

from gen.certificate.document import FILE, Ambient, Start, read
from gen.errors import InputError
from tests.examples import ROOT

RANGE: dict[str, Any] = {"low_mC": -20_000, "high_mC": 60_000}


@pytest.mark.parametrize("reference_mC", [-20_000, 25_000, 60_000])
def test_a_reference_within_the_range_is_taken(reference_mC: int) -> None:
    assert Ambient(**RANGE, reference_mC=reference_mC).over_mK == (-20_000 - reference_mC, 60_000 - reference_mC)


@pytest.mark.parametrize("reference_mC", [-20_001, 60_001])
def test_one_beyond_it_is_refused(reference_mC: int) -> None:
    with pytest.raises(ValidationError, match="outside of the ambient's range"):
        Ambient(**RANGE, reference_mC=reference_mC)


def test_a_start_is_at_most_two_to_the_23_thousandths() -> None:
    start: TypeAdapter[int] = TypeAdapter(Start)
    assert [start.validate_python(end) for end in (-(1 << 23), 1 << 23)] == [-(1 << 23), 1 << 23]
    for beyond in (-(1 << 23) - 1, (1 << 23) + 1):
        with pytest.raises(ValidationError):
            start.validate_python(beyond)


def test_what_is_wrong_with_a_certificate_is_told_with_its_place(tmp_path: Path) -> None:
    tree = json.loads((ROOT / "firmware_out" / FILE).read_text(encoding="utf-8"))
    tree["components"][2]["bound_K"] = "small"
    (tmp_path / FILE).write_text(json.dumps(tree), encoding="utf-8")
    with pytest.raises(InputError, match="is no certificate") as told:
        read(tmp_path)
    assert told.value.place == "$.components[2].bound_K"
