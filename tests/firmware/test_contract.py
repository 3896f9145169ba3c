"""What the guarantee says stands in every place in the same words."""

from __future__ import annotations

import re
from html import unescape

import pytest

from gen.coefficients import Coefficients, parse
from gen.firmware.contract import Clause, as_comment, clauses, contract
from gen.firmware.project import project_files
from gen.lowering.lower import lower
from tests.examples import ROOT, example
from tests.lowering.test_unproven import UNSTABLE, document


def words(text: str) -> str:
    """Without markup, comment signs and line breaks."""
    return " ".join(re.sub(r"<[^>]+>|[`*]|^//", "", unescape(text), flags=re.MULTILINE).split())


def spoken(promised: tuple[Clause, ...], between: str) -> list[str]:
    return [words(f"{clause.title}{between} {clause.text}") for clause in promised]


def test_header_readme_and_report_have_every_clause() -> None:
    coefficients = example("two_mass")
    program = lower(coefficients, "fixed", "table")
    files = project_files(coefficients, program, "coeffs.json", None)
    promised = contract(program)
    assert len(promised) == 6
    for path, between in (("lib/two_mass/src/two_mass.h", ":"), ("README.md", "."), ("report.html", ".")):
        for sentence in spoken(promised, between):
            assert sentence in words(files[path]), path


def test_so_has_the_repository_s_readme() -> None:
    text = words((ROOT / "README.md").read_text(encoding="utf-8"))
    for sentence in spoken(clauses("NAME", "sample_time_s", "$.domain"), "."):
        assert sentence in text


def test_it_has_the_project_s_own_numbers() -> None:
    text = " ".join(clause.text for clause in contract(lower(example("two_mass"), "fixed", "table")))
    assert "`two_mass_resume()`" in text
    assert "lasts 0.25 s." in text
    assert "limited to 0..255." in text


def _half_proven() -> Coefficients:
    tree = document(UNSTABLE, 2e-5, 0.25, unproven="saturate").decode()
    proven = '{"name": "sound", "order": 1, "gain": {"poly": [1e-5]}, "poles": [{"real": {"poly": [-0.001]}}]}'
    return parse(tree.replace('"components": [', f'"components": [{proven}, ').encode())


def test_a_part_without_a_proof_is_named_and_nothing_is_promised_where_no_part_has_one() -> None:
    text = " ".join(clause.text for clause in contract(lower(_half_proven(), "fixed", "table")))
    assert text.count("Nothing is guaranteed of part.") == 1
    none = parse(document(UNSTABLE, 2e-5, 0.25, unproven="saturate"))
    program = lower(none, "fixed", "table")
    assert contract(program) == ()
    files = project_files(none, program, "coeffs.json", None)
    assert not any("Between which events" in text for text in files.values())


def test_effects_leave_the_baseline_s_guarantee_alone() -> None:
    text = " ".join(clause.text for clause in contract(lower(example("two_mass_refined"), "fixed", "table")))
    assert "of winding and housing the guarantee is about the baseline's word alone" in text


@pytest.mark.parametrize("title", ["Short", "A title of some words"])
def test_comment_lines_fit_and_lose_nothing(title: str) -> None:
    clause = Clause(title, "A `word_mK()` and " + "more words " * 40)
    lines = as_comment((clause,))
    assert all(line.startswith("// ") and len(line) <= 118 for line in lines)
    assert words("\n".join(lines)) == words(f"{title}: {clause.text}")
