"""Pictures and figures of the docs are of today's code: `python -m docs.figures` makes them anew."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.figure import Figure

from docs.figures.__main__ import DOCS, PICTURES
from docs.figures.picture import shown, told, write
from docs.figures.readme import COEFFICIENTS, COMBINATIONS, README, firmware_digest
from gen.coefficients import load
from gen.lowering.lower import lower
from gen.lowering.recursion.guarantee import rounded_up


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_shows_today_s_numbers(name: str) -> None:
    assert ElementTree.parse(DOCS / name).getroot().tag.endswith("svg")
    assert told(PICTURES[name]()).agrees(shown(DOCS / name)), "out of date: python -m docs.figures"


def test_every_picture_of_the_docs_is_drawn_by_the_command() -> None:
    assert {path.name for path in DOCS.glob("*.svg")} == set(PICTURES)


def test_the_readme_s_figures_are_of_today_s_firmware() -> None:
    found = re.search(r"<!-- of ([0-9a-f]{16}) -->", README.read_text(encoding="utf-8"))
    assert found is not None
    assert found[1] == firmware_digest(), "out of date: python -m docs.figures"


def test_the_readme_guarantees_what_is_proven() -> None:
    text = README.read_text(encoding="utf-8")
    coefficients = load(COEFFICIENTS)
    for arithmetic, schedule in COMBINATIONS:
        proofs = [part.proof for part in lower(coefficients, arithmetic, schedule).components]
        worst = max(proof.bound_K for proof in proofs if proof is not None)
        row = next(line for line in text.splitlines() if line.startswith(f"| {arithmetic}/{schedule} |"))
        assert f"{rounded_up(worst):.1e} K" in row.split("|")[3]


def drawn(level: float, label: str = "casing") -> Figure:
    figure = Figure()
    axes = figure.subplots()
    axes.set_ylim(0.0, 10.0)
    axes.plot(np.arange(5), np.full(5, level), label=label)
    return figure


def test_a_picture_of_other_numbers_shows_something_else() -> None:
    assert told(drawn(5.0)).agrees(told(drawn(5.0 + 1e-3)))
    assert not told(drawn(5.0)).agrees(told(drawn(5.1)))
    assert not told(drawn(5.0)).agrees(told(drawn(5.0, "brush")))


def test_a_picture_carries_what_it_shows(tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("picture") / "a.svg"
    write(drawn(5.0), path)
    assert shown(path).agrees(told(drawn(5.0)))
    assert not shown(path).agrees(told(drawn(6.0)))
    first = path.read_bytes()
    write(drawn(5.0), path)
    assert path.read_bytes() == first
