"""What a certificate may say of the ambient: its reference is a temperature of the range, the ends included."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import ValidationError

from gen.certificate.document import Ambient

RANGE: dict[str, Any] = {"low_mC": -20_000, "high_mC": 60_000}


@pytest.mark.parametrize("reference_mC", [-20_000, 25_000, 60_000])
def test_a_reference_within_the_range_is_taken(reference_mC: int) -> None:
    assert Ambient(**RANGE, reference_mC=reference_mC).over_mK == (-20_000 - reference_mC, 60_000 - reference_mC)


@pytest.mark.parametrize("reference_mC", [-20_001, 60_001])
def test_one_beyond_it_is_refused(reference_mC: int) -> None:
    with pytest.raises(ValidationError, match="outside of the ambient's range"):
        Ambient(**RANGE, reference_mC=reference_mC)
