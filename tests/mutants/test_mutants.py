"""Planted defects are found: a few on every run; `python -m benchmarks.mutants` plants hundreds (docs/mutants.md)."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.mutants.of_templates import mutants_of
from tests.examples import ROOT


def planted(tmp_path: Path, module: str, count: int, *tests: str) -> list[str]:
    """What became of mutants of a module, drawn with a fixed seed."""
    verdicts = tmp_path / "verdicts.jsonl"
    command = [sys.executable, "-m", "benchmarks.mutants", "run", "--only", module, "--json", str(verdicts)]
    command += ["--count", str(count), "--seed", "11", "--tests", *tests]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode in (0, 1), done.stderr
    outcomes = [json.loads(line)["outcome"] for line in verdicts.read_text(encoding="utf-8").splitlines()]
    assert (done.returncode == 0) == all(outcome in ("caught", "no program") for outcome in outcomes)
    assert len(outcomes) == count, done.stdout
    return outcomes


@pytest.mark.parametrize(
    ("module", "tests"),
    [
        ("gen/reference/alarms.py", ("tests/reference/test_alarms.py",)),
        ("gen/model/schedules.py", ("tests/model/test_model_schedules.py",)),
    ],
)
def test_the_nearest_tests_catch_what_is_planted(tmp_path: Path, module: str, tests: tuple[str, ...]) -> None:
    """A survivor here after a change is a missing test, or one for benchmarks/mutants/equivalent.json."""
    assert planted(tmp_path, module, 2, *tests) == ["caught"] * 2


def test_what_no_test_looks_at_survives(tmp_path: Path) -> None:
    assert planted(tmp_path, "gen/reference/alarms.py", 1, "tests/replay/test_inputs.py") == ["survived"]


TEMPLATE = """// 1 < 2
{% if a < 1 %}
const uint8_t TIMES = {{ count + 1 }} + 2;  // 3
    Serial.print(F("a < 4"));
    if (a < b && !done) {
        left = 0;
{% endif %}
"""


def test_templates_are_changed_in_their_code_only(tmp_path: Path) -> None:
    file = tmp_path / "a.cpp.j2"
    file.write_text(TEMPLATE)
    found = {mutant.after for make in mutants_of(file, tmp_path) if (mutant := make()) is not None}
    assert found == {
        "const uint8_t TIMES = {{ count + 1 }} - 2;  // 3",
        "const uint8_t TIMES = {{ count + 1 }} + 3;  // 3",
        "if (a <= b && !done) {",
        "if (a < b || !done) {",
        "if (a < b && done) {",
        "left = 1;",
        ";",
    }
