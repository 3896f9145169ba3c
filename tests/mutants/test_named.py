"""Mutants that once passed stay where they can be planted: code that moves takes its mutant along."""

from __future__ import annotations

from pathlib import Path

from benchmarks.mutants.named import named

ROOT = Path(__file__).parents[2]


def test_each_has_its_place_and_its_tests() -> None:
    made, gone = named(ROOT)
    assert gone == []
    assert made
    for _, tests in made:
        for test in tests:
            path, _, name = test.partition("::")
            assert f"def {name.partition('[')[0]}(" in (ROOT / path).read_text(encoding="utf-8") or not name, test
