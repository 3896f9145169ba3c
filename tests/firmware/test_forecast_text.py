"""What the emitted project says to people about its look ahead, in the units of the coefficient file."""

from __future__ import annotations

import json

from gen.coefficients import parse
from gen.firmware.project import project_files
from gen.lowering.lower import lower
from tests.examples import ROOT


def test_the_readme_gives_the_horizon_that_the_file_asks_for() -> None:
    tree = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    coefficients = parse(json.dumps({**tree, "version": 2, "forecast": {"horizon_s": 630}}).encode())
    readme = project_files(coefficients, lower(coefficients, "fixed", "table"), "coeffs.json", None)["README.md"]
    (row,) = [line for line in readme.splitlines() if line.startswith("| `holdable_pwm` |")]
    assert "could hold for 630 s" in row
