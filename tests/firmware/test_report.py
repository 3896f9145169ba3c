"""The report: its verdict, its numbers, its charts, and that it stands alone."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from decimal import Decimal
from functools import cache
from html import unescape
from typing import Any

import numpy as np
import pytest

from gen.coefficients import Coefficients, parse
from gen.firmware.report import constants, report_html, words
from gen.firmware.step_responses import exact_response
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.lowering.recursion.guarantee import rounded_up
from gen.model.exact import ExactSolution
from gen.pages.charts import Chart, Series, scientific, svg, ticks
from tests.examples import ROOT, example

HOSTILE = '</svg><script>alert("x")</script>&'


@cache
def lowered(name: str = "my1016", arithmetic: Arithmetic = "fixed", schedule: ScheduleKind = "table") -> Program:
    return lower(example(name), arithmetic, schedule)


@cache
def report(name: str = "my1016", arithmetic: Arithmetic = "fixed", schedule: ScheduleKind = "table") -> str:
    return report_html(example(name), lowered(name, arithmetic, schedule), None)


def verification(coefficients: Coefficients, differing: int = 0) -> dict[str, Any]:
    names = coefficients.model.component_names
    failed = {"mismatch": "step 7, brush.x1: board 0x01, reference 0x02", "profile": {"start_mK": 0, "pwm": [1]}}
    passed = {"mismatch": None, "profile": None}
    targets = [
        {"target": "g++ -O2", "samples": 52_480, "words": 1_259_520, "differing": 0} | passed,
        {"target": "g++ -O2, every command", "samples": 511, "words": 12_264, "differing": 0} | passed,
        {"target": "ATmega2560 (simavr)", "samples": 4_800, "words": 115_200, "differing": differing}
        | (failed if differing else passed),
    ]
    cost = {"cycles_constant": 1265, "cycles_constant_mean": 1253.9, "cycles_change": 2493}
    return {
        "tool": "gen 0.1.0",
        "coefficients_sha256": coefficients.sha256,
        "combinations": [
            {
                "arithmetic": "fixed",
                "schedule": "table",
                "targets": targets,
                "bound_K": dict.fromkeys(names, 1e-6),
                "error_K": dict.fromkeys(names, 2.31e-7),
                "error_course": {"time_s": [5400.0, 10800.0], "error_K": {name: [2.31e-7, 1e-7] for name in names}},
                "step_errors": {
                    "pwm": [51, 102, 153, 204, 255],
                    "time_s": [0.0, 3600.0, 7200.0, 10_800.0],
                    "error_K": {name: [[0.0, 1e-7, -3e-7, 2.5e-7]] * 5 for name in names},
                },
                "cost": cost | {"flash_bytes": 15_162, "ram_bytes": 81, "stack_bytes": 69},
                "helpers": [],
            }
        ],
    }


def text(html: str) -> str:
    return unescape(re.sub(r"<[^>]+>", "", html)).replace("\u202f", " ")


def first_line(html: str) -> str:
    body = html[html.index("<body>") + len("<body>") :].strip()
    assert body.startswith('<p class="verdict ')
    return body.partition("</p>")[0]


@pytest.mark.parametrize("name", ["my1016", "two_mass"])
def test_two_runs_give_the_same_bytes(name: str) -> None:
    assert report(name) == report_html(example(name), lowered(name), None)


@pytest.mark.parametrize(("name", "arithmetic"), [("my1016", "fixed"), ("my1016", "float"), ("two_mass", "fixed")])
def test_it_stands_alone(name: str, arithmetic: Arithmetic) -> None:
    html = report(name, arithmetic)
    outside = r'https?:|//[a-z]|@import|url\(|<script|<link|<img|<iframe|\bsrc=|\bhref=(?!"#)'
    assert not re.search(outside, html, re.IGNORECASE)


@pytest.mark.parametrize("name", ["my1016", "two_mass"])
def test_every_section_is_in_the_table_of_contents(name: str) -> None:
    html = report(name)
    listed = re.findall(r'<li><a href="#([^"]+)">([^<]+)</a></li>', html)
    assert listed == re.findall(r'<h2 id="([^"]+)">([^<]+)</h2>', html)
    assert html.count("<h2") == len(listed)


def test_without_a_verification_it_says_so() -> None:
    line = first_line(report())
    assert 'class="verdict none"' in line
    assert "Not verified yet: run gen verify" in text(line)


def test_another_files_or_combinations_verification_is_none() -> None:
    coefficients = example("my1016")
    other = verification(coefficients) | {"coefficients_sha256": "0" * 64}
    assert report_html(coefficients, lowered(), other) == report()
    html = report_html(coefficients, lowered(arithmetic="float"), verification(coefficients))
    assert "Not verified yet" in first_line(html)
    assert "fixed/table" in html  # what was compared is still shown, below


def test_equal() -> None:
    html = report_html(example("my1016"), lowered(), verification(example("my1016")))
    line = first_line(html)
    assert 'class="verdict equal"' in line
    assert "57 791 samples and 1 386 984 words compared, 0 words differ" in text(line)
    assert text(line).endswith("targets: g++ -O2, ATmega2560 (simavr).")
    assert "1 265" in text(html)
    assert "2.4 × 10⁻⁷" in html  # the measured error, rounded up


def test_different_shows_the_first_mismatch() -> None:
    html = report_html(example("my1016"), lowered(), verification(example("my1016"), differing=3))
    line = first_line(html)
    assert 'class="verdict different"' in line
    assert "3 words differ" in text(line)
    assert "First mismatch, ATmega2560 (simavr): step 7, brush.x1: board 0x01" in text(line)
    assert '<td class="wrong">3 of 115 200 differ</td>' in html.replace("\u202f", " ")


def test_an_error_larger_than_allowed_is_no_success() -> None:
    record = verification(example("my1016"))
    record["combinations"][0]["exceeded"] = ["component brush: the measured error of 1.2e-05 K exceeds ..."]
    line = first_line(report_html(example("my1016"), lowered(), record))
    assert 'class="verdict different"' in line
    assert "Equal, but not as accurate as it must be" in text(line)
    assert "component brush: the measured error of 1.2e-05 K" in text(line)


def test_what_was_proven_anew_stands_beside_what_is_guaranteed() -> None:
    record = verification(example("my1016"))
    names = example("my1016").model.component_names
    record["combinations"][0] |= {"proven_K": dict.fromkeys(names, 4.56e-7), "inequalities": 1234567, "refuted": None}
    html = report_html(example("my1016"), lowered(), record)
    line = first_line(html)
    assert 'class="verdict equal"' in line
    assert text(line).endswith("The bounds were proven anew from the C++: 1 234 567 inequalities hold.")
    assert text(html).count("4.6 × 10⁻⁷") == len(names)
    assert "not checked" not in html


def test_a_verification_from_before_certificates_is_read() -> None:
    html = report_html(example("my1016"), lowered(), verification(example("my1016")))
    assert html.count("<td>not checked</td>") == 4


def test_a_refuted_bound_is_no_success() -> None:
    record = verification(example("my1016"))
    record["combinations"][0] |= {"proven_K": {}, "inequalities": 0, "refuted": "brush: Lemma 2 fails at |PWM| 128"}
    html = report_html(example("my1016"), lowered(), record)
    line = first_line(html)
    assert 'class="verdict different"' in line
    assert "Equal, but the guarantee does not follow" in text(line)
    assert text(line).endswith("Refuted: brush: Lemma 2 fails at |PWM| 128")
    assert html.count('<td class="wrong">refuted</td>') == 4


def test_the_error_over_whole_runs_is_drawn_where_it_was_measured() -> None:
    assert 'id="course-title"' not in report()
    html = report_html(example("my1016"), lowered(), verification(example("my1016")))
    assert "Largest error of every component over a run of 10800 s. brush: 0.231 to 0.1." in html


def test_the_dots_of_step_responses_reach_as_far_as_the_board_was_run() -> None:
    alone = text(report())
    assert "run for the first 800 s only" in alone
    assert "the board's reference as dots up to 800 s" in unescape(report())
    html = unescape(report_html(example("my1016"), lowered(), verification(example("my1016"))))
    assert "run for the first" not in html
    assert "the board's reference as dots up to 10800 s" in html
    chart = html[html.index('id="step-brush-title"') :].partition("</svg>")[0]
    dots = re.search(r'class="dots d0" d="([^"]+)"', chart)
    line = re.search(r'class="line s0" d="M[^"h]*L(\S+) (\S+)"', chart)
    assert dots is not None and line is not None
    assert dots[1].count("M") == 4
    assert dots[1].endswith(f"M{line[1]} {line[2]}h0")  # both end where the exact solution does: the error is not seen
    error = html[html.index('id="error-brush-title"') :].partition("</svg>")[0]
    assert "20%: 0 to 0.25." in error


def test_combinations_with_equal_counts_share_a_row() -> None:
    record = verification(example("my1016"))
    own = record["combinations"][0]
    record["combinations"].append(own | {"schedule": "onboard"})
    html = report_html(example("my1016"), lowered(), record)
    assert "<details><summary>What was compared on which target" in html
    assert html.count('<th scope="row">fixed/table, fixed/onboard</th>') == 2
    counts = "2 773 968 words in 2 combinations of arithmetic and schedule, none of them differ"
    assert counts in " ".join(text(html).split())
    wrong = verification(example("my1016"), differing=3)
    wrong["combinations"].append(own | {"schedule": "onboard"})
    html = report_html(example("my1016"), lowered(), wrong)
    assert "<details open><summary>What was compared on which target" in html
    assert html.count('<th scope="row">fixed/table</th><td>states, random profiles</td>') == 1


@pytest.mark.parametrize("name", ["my1016", "two_mass"])
def test_every_chart_is_described_valid_xml(name: str) -> None:
    html = report(name)
    charts = re.findall(r"<svg.*?</svg>", html, re.DOTALL)
    assert len(charts) == sum(5 + (c.order > 1) for c in example(name).model.components)
    for chart in charts:
        root = ET.fromstring(chart)
        titles = [root.find("title"), root.find("desc")]
        assert root.attrib["aria-labelledby"].split() == [t.attrib["id"] for t in titles if t is not None]
        assert all(t is not None and t.text for t in titles)
    identifiers = re.findall(r'\bid="([^"]+)"', html)
    assert len(identifiers) == len(set(identifiers))
    assert "nan" not in "".join(charts)


def test_coordinates_have_one_decimal() -> None:
    for path in re.findall(r' d="([^"]+)"', report()):
        assert not re.search(r"\.\d\d", path)


def test_tables_hold_the_programs_numbers() -> None:
    html, program = report(), lowered()
    for component in program.components:
        assert isinstance(component, FixedComponent)
        rows = {row[1]: row for row in words(component)}
        assert [rows[f"x{i + 1}"][4] for i in range(component.order)] == [
            f"int48, Q{bits}" for bits in component.layout.fraction_bits
        ]
        assert [rows[f"R{i}"][4] for i in range(component.order)] == [
            f"uint32, Q{bits}" for bits in component.layout.rate_fraction_bits
        ]
        for row in rows.values():
            assert 0.0 <= float(row[6]) < 32.0
            assert "".join(f"<td>{cell}</td>" for cell in row[1:]) in html
        assert component.proof is not None
        assert f"<td>{scientific(rounded_up(component.proof.bound_K))}</td>" in html
        table = re.search(r"<pre>(.*?)</pre>", html, re.DOTALL)
        assert table is not None
        numbers = [line.split() for line in table[1].splitlines()]
        for i in range(component.order):
            column = numbers[0].index(f"{component.name}.R{i}")
            assert [int(line[column]) for line in numbers[1:]] == component.rates[:, i].tolist()
        column = numbers[0].index(f"{component.name}.S")
        assert [int(line[column]) for line in numbers[1:]] == component.steady.tolist()


@pytest.mark.parametrize("schedule", ["table", "onboard"])
@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
def test_every_constant_is_traced(arithmetic: Arithmetic, schedule: ScheduleKind) -> None:
    program = lowered("my1016", arithmetic, schedule)
    rows = constants(program)
    for number, component in enumerate(program.components):
        own = [row for row in rows if row[0] == component.name]
        assert {row[1] for row in own} >= {"S", *(f"R{i}" for i in range(component.order))}
        for row in own:
            assert row[4] == "derived" or row[4].startswith((f"$.components[{number}].", "$.domain", "$.sample_time_s"))
    if schedule == "onboard":
        assert any(".exp2[" in row[4] for row in rows)


def test_what_the_file_says_is_escaped() -> None:
    tree = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text())
    components = [tree["components"][1] | {"description": HOSTILE}]
    provenance = {"source": HOSTILE, "method": HOSTILE, "data": [HOSTILE]}
    changes = {"description": HOSTILE, "components": components, "provenance": provenance, "wiring": None, "alarms": []}
    hostile = parse(json.dumps(tree | changes).encode())
    record = verification(hostile, differing=1)
    record["combinations"][0]["targets"][2] |= {"target": HOSTILE, "mismatch": HOSTILE}
    html = report_html(hostile, lower(hostile, "fixed", "table"), record)
    assert "<script" not in html
    assert html.count("&lt;script&gt;") >= 8
    chart = Chart("i", HOSTILE, HOSTILE, HOSTILE, HOSTILE, HOSTILE, (Series(HOSTILE, [0.0, 1.0], [1.0, 2.0]),))
    assert ET.fromstring(svg(chart)).findtext("title") == HOSTILE


@pytest.mark.parametrize("name", ["my1016", "my1016_averaged", "two_mass"])
def test_the_decimal_solution_is_the_exact_one(name: str) -> None:
    model = example(name).model
    solved = ExactSolution(model).simulate(np.full(4000, 153), dict.fromkeys(model.component_names, 20.5))
    for component in model.components:
        parts = [(100 * model.sample_time, 10), (300 * model.sample_time, 10)]
        own = exact_response(component, 153, Decimal("20.5"), parts)
        expected = solved[component.name][[*range(0, 1001, 100), *range(1300, 4001, 300)]]
        np.testing.assert_allclose([float(value) for value in own], expected, rtol=0, atol=1e-9)


def test_a_constant_chart_has_axes() -> None:
    flat = Chart("flat", "Flat", "Flat", "x", "y", "K", (Series("", [3.0], [0.0]),), shade=(0.0, 9.0))
    assert "nan" not in svg(flat)
    assert ticks(0.0, 1.0) == [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]
    assert scientific(-1.25e-6) == "−1.25 × 10⁻⁶"
