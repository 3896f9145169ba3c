"""Networks with natural convection or radiation."""

from __future__ import annotations

import pytest

from gen.coefficients import load
from gen.errors import InputError
from gen.refinement.network.refine import refine_network
from tests.examples import ROOT


def test_a_law_is_refused_with_its_path() -> None:
    """What is fitted has none, and would take the heat for that of an ordinary path."""
    coefficients = load(ROOT / "examples" / "natural_cooling" / "coeffs.json")
    with pytest.raises(
        InputError,
        match=r"motor\.json: \$\.network\.paths\[4\]\.convection: gen refine knows no path with convection yet",
    ):
        refine_network(coefficients, "", [], [], print, file="motor.json")
