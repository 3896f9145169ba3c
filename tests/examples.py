"""What several tests share."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from gen.coefficients import Coefficients, load

ROOT = Path(__file__).parent.parent
EXAMPLES = ("my1016", "my1016_averaged", "two_mass")
ALL = sorted(path.parent.name for path in (ROOT / "examples").glob("*/coeffs.json"))
NETWORKS = ("natural_cooling", "network", "ten_nodes", "two_nodes")
WITH_TRANSFER_FUNCTIONS = tuple(name for name in ALL if name not in NETWORKS)


@cache
def example(name: str) -> Coefficients:
    """One of the repository's examples."""
    return load(ROOT / "examples" / name / "coeffs.json")
