"""What several tests share."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from gen.coefficients import Coefficients, load

ROOT = Path(__file__).parent.parent
EXAMPLES = ("my1016", "my1016_averaged", "two_mass")


@cache
def example(name: str) -> Coefficients:
    """One of the repository's examples."""
    return load(ROOT / "examples" / name / "coeffs.json")
