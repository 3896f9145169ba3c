"""A model whose header had the name of one of the sketch's would hide behind it: such names are refused."""

from __future__ import annotations

from pathlib import Path

from gen.coefficients.document import SKETCH_FILES

SOURCES = Path(__file__).parents[2] / "templates" / "project" / "src"


def test_no_model_has_the_name_of_a_header_of_the_sketch() -> None:
    assert {path.name.removesuffix(".h.j2") for path in SOURCES.glob("*.h.j2")} == SKETCH_FILES
