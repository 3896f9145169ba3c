"""Files that the commands are given, right and wrong."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from tests.examples import ROOT

COEFFICIENTS = ROOT / "examples" / "my1016" / "coeffs.json"
OLD = "old"
MANIFEST = json.dumps({"tool": "gen 0.1.0", "files": {"a/b.txt": hashlib.sha256(OLD.encode()).hexdigest()}})


def broken(tmp_path: Path, old: str, new: str) -> Path:
    text = COEFFICIENTS.read_text()
    assert old in text
    path = tmp_path / "broken.json"
    path.write_text(text.replace(old, new, 1))
    return path


def run_file(tmp_path: Path) -> Path:
    path = tmp_path / "run.csv"
    path.write_text("time_s,pwm,brush_degC\n0,102,40\n0.25,102,\n7.3,204,\n900,0,\n1200.1,0,\n")
    return path
