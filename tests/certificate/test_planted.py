"""Defects planted in tables, shifts, the order of work, the certificate and its claims: each must be refuted."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import gen
from gen.errors import CheckFailed
from tests.campaign import share
from tests.certificate.projects import built, small

Edit = Callable[[str], str]


@pytest.fixture(scope="module")
def emitted(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """One project for each arithmetic: orders 1 and 2 (carried), 3 (corrected in fixed point)."""
    found = {}
    for arithmetic in ("fixed", "float"):
        folder = tmp_path_factory.mktemp(arithmetic)
        found[arithmetic] = built(folder, small(1, 2, 3), arithmetic, "table")
    return found


def planted(emitted: Path, folder: Path, name: str, edit: Edit) -> Path:
    """A copy of the project with one file edited."""
    copy = folder / "copy"
    shutil.copytree(emitted, copy)
    path = next(copy.rglob(name))
    text = path.read_text()
    changed = edit(text)
    assert changed != text, "the defect was not planted"
    path.write_text(changed)
    return copy


def replaced(old: str, new: str, nth: int = 0) -> Edit:
    """The nth place of a regular expression replaced."""

    def edit(text: str) -> str:
        place = list(re.finditer(old, text))[nth]
        return text[: place.start()] + place.expand(new) + text[place.end() :]

    return edit


def added(pattern: str, step: int, nth: int = 0) -> Edit:
    """``step`` added to the number that is the pattern's only group."""

    def edit(text: str) -> str:
        place = list(re.finditer(pattern, text))[nth]
        return text[: place.start(1)] + str(int(place[1]) + step) + text[place.end(1) :]

    return edit


def certificate(change: Callable[[dict[str, Any]], None], part: int = 0) -> Edit:
    """A change of one component of the certificate."""

    def edit(text: str) -> str:
        tree = json.loads(text)
        change(tree["components"][part])
        return json.dumps(tree)

    return edit


def scaled(key: str, factor: float) -> Callable[[dict[str, Any]], None]:
    """A number, or all numbers of a list, made larger or smaller."""

    def change(part: dict[str, Any]) -> None:
        value = part[key]
        part[key] = [factor * one for one in value] if isinstance(value, list) else factor * value

    return change


def claimed(change: Callable[[dict[str, Any]], None]) -> Edit:
    """A change of what the manifest claims of the first component."""

    def edit(text: str) -> str:
        tree = json.loads(text)
        change(tree["components"][0]["proof"])
        return json.dumps(tree)

    return edit


def _narrower(part: dict[str, Any]) -> None:
    part["error"][0] *= 0.7


def _other_pole(part: dict[str, Any]) -> None:
    part["equation"]["poles"][0]["real"]["exponentials"][0][0] *= 1.0 + 1e-7


def _other_gain(part: dict[str, Any]) -> None:
    part["equation"]["gain"]["pieces"][0][2][0] *= 1.0 + 1e-7


def _wider_start(part: dict[str, Any]) -> None:
    part["start_mK"][1] += 1000


def ambient(key: str, step: int) -> Edit:
    """Another ambient in the certificate."""

    def edit(text: str) -> str:
        tree = json.loads(text)
        tree["ambient"][key] += step
        return json.dumps(tree)

    return edit


def _no_ambient(text: str) -> str:
    tree = json.loads(text)
    del tree["ambient"]
    return json.dumps(tree)


def _finer(part: dict[str, Any]) -> None:
    part["fraction_bits"][0] += 1


SCHEDULE, STEP, WORD, MODEL = "small_schedule.cpp", "small_step.h", "small_word.h", "small.cpp"
OVER = r"small_model\.state\.ambient_mK"
AMBIENT: dict[str, tuple[str, Edit]] = {
    "counted twice at a start": (
        MODEL,
        replaced(r"( rise_mK = small_over_reference\(rise_mK\);\n)", r"\1 rise_mK += small_model.state.ambient_mK;\n"),
    ),
    "left out at a change": (MODEL, replaced(r"    add_ambient\(now\);\n", "")),
    "left out of a resume": (MODEL, replaced(r"    add_ambient\(&small_model\.now\);\n", "")),
    "old words at a resume": (MODEL, replaced(r"    ambient_words\(\);\n    add_ambient", "    add_ambient")),
    "added before the schedule": (
        MODEL,
        replaced(r"( +small_schedule\(pwm, now\);\n)( +add_ambient\(now\);\n)", r"\2\1"),
    ),
    "left out of one component": (MODEL, replaced(r"    now->b\[0\]\.steady \+= b;\n", "")),
    "taken off": (MODEL, replaced(r"steady \+= a;", "steady -= a;")),
    "another word's factor": (MODEL, added(r"ambient\[0\] = small_word_of\(over, (\d+)", 1)),
    "added to a rate": (MODEL, replaced(r"now->a\[0\]\.steady \+= a;", "now->a[0].rate[0] += (uint32_t)a;")),
    "a change that nothing follows": (MODEL, replaced(r" +small_model\.flags &= \(uint8_t\)~STARTED;\n", "", nth=0)),
    "words of the ambient before": (
        MODEL,
        replaced(rf"( +{OVER} = over;\n)( +ambient_words\(\);\n)", r"\2\1"),
    ),
    "another reference": (MODEL, replaced(r"thousandths - \(30000L\)", "thousandths - (30001L)")),
    "an end of its range": (MODEL, replaced(r"thousandths > 40000L", "thousandths > 41000L")),
    "a start over the reference": (MODEL, replaced(r"    rise_mK = small_over_reference\(rise_mK\);\n", "")),
    "a start that adds it twice": (
        MODEL,
        replaced(
            r"(    rise_mK = small_over_reference\(rise_mK\);\n)", r"\1    rise_mK += small_model.state.ambient_mK;\n"
        ),
    ),
    "a start that takes it off": (MODEL, replaced(rf"rise_mK\) \+ {OVER}", "rise_mK) - small_model.state.ambient_mK")),
    "a begin that keeps it": (MODEL, replaced(rf"    {OVER} = 0;\n", "")),
    "a reading over the reference": (MODEL, replaced(rf" - {OVER};", ";")),
    "a reading that adds it": (MODEL, replaced(rf" - {OVER};", " + small_model.state.ambient_mK;", nth=1)),
    "a wider range": ("certificate.json", ambient("high_mC", 1000)),
    "a colder end": ("certificate.json", ambient("low_mC", -5000)),
    "a reference that is another": ("certificate.json", ambient("reference_mC", 1)),
    "none in the certificate": ("certificate.json", _no_ambient),
}
FIXED: dict[str, tuple[str, Edit]] = {
    # Tables.
    "R0 of order 1, a unit in ten thousand": (SCHEDULE, added(r"\{(\d{6,})UL\}", 20_000)),
    "R1 of order 2": (SCHEDULE, added(r"\{\d+UL, (\d+)UL\}", 5_000)),
    "S of order 1, a thousandth of a kelvin": (SCHEDULE, added(r"\{\d+UL\}, (-?\d+)L", 9_000)),
    "R2 of order 3": (SCHEDULE, added(r"\{\d+UL, \d+UL, (\d+)UL\}", 3_000)),
    "the last row's R0": (SCHEDULE, added(r"\{(\d{6,})UL\}", 20_000, nth=-1)),
    "two rows changed places": (SCHEDULE, replaced(r"(?m)^( +\{\{.*\n)( +\{\{.*\n)", r"\2\1", nth=2)),
    "the first row twice": (SCHEDULE, replaced(r"pwm - 96", "pwm - 97")),
    # Shifts and statements of the recursion.
    "a product kept from another bit": (STEP, replaced(r"small_high(?:32|24|16)\(", "small_high24(")),
    "order 1's product from another bit": (STEP, replaced(r"small_subtract24", "small_subtract32")),
    "x2 >> one more": (STEP, added(r"small_right(\d+)\(state->x\[1\]\)", 1)),
    "the unit in the middle left out": (STEP, replaced(r" \+ 1;", ";")),
    "another rate": (STEP, replaced(r"now->rate\[0\]", "now->rate[1]", nth=1)),
    "S added": (STEP, replaced(r"x\[0\]\.hi - now->steady", "x[0].hi + now->steady")),
    "no x1 += x2": (STEP, replaced(r" +small_add\(state->x\[0\], small_right\d+\(state->x\[1\]\)\);\n", "")),
    "q twice": (STEP, replaced(r"( +small_add\(state->x\[1\], q\);\n)", r"\1\1")),
    "a carry's sign": (STEP, replaced(r"before - after", "after - before")),
    "a carry's place": (STEP, replaced(r"(small_carry\(&state->x\[0\], .*), -?\d+\);", r"\1, 8);")),
    "a shift of 16-bit numbers": (STEP, replaced(r"hi >> 17\)", "hi >> 16)")),
    "the twelfth": (STEP, replaced(r"\* 344 >> 8", "* 444 >> 8")),
    "the sign of d": (STEP, replaced(r"small_word\(change", "small_word(-change")),
    "reading another bit": (STEP, replaced(r"high >> (\d+)\) \* 1000", r"high >> \1) * 1001")),
    "reading rounded down": (STEP, replaced(r"\* 125u \+ \d+UL", "* 125u + 0UL")),
    # What the smallest functions do.
    "a residue lost": (WORD, replaced(r"65536 \+ word\.lo", "65536")),
    "a byte product more left out": (WORD, replaced(r"column < columns", "column <= columns")),
    "2^16 / 13": (WORD, replaced(r"\* 5461 \+", "* 5041 +")),
    # The order of a sample.
    "the schedule before the old q": (
        MODEL,
        replaced(r"(    const int32_t part1_before = .*\n)(    small_schedule\(pwm, now\);\n)", r"\2\1"),
    ),
    "no schedule at a new PWM": (MODEL, replaced(r"if \(changed\)", "if (!changed)")),
    "a domain of one more": (MODEL, replaced(r"counts > 119u \? 119u", "counts > 120u ? 120u")),
    "a start's range": (MODEL, replaced(r"rise_mK > 70000L", "rise_mK > 90000L")),
    "a start's factor": (MODEL, added(r"rise_mK, (\d+)L, \d+u", 1)),
    "rates kept at a start": (MODEL, replaced(r"memset\(rate, 0,", "memset(rate, 1,")),
    # The certificate and what is claimed.
    "a bound 1 % too small": ("certificate.json", certificate(scaled("bound_K", 0.99))),
    "order 3's bound 1 % too small": ("certificate.json", certificate(scaled("bound_K", 0.99), part=2)),
    "a reading's bound 1 % too small": ("certificate.json", certificate(scaled("reading_K", 0.99))),
    "errors half as wide": ("certificate.json", certificate(scaled("error", 0.5))),
    "order 3's errors half as wide": ("certificate.json", certificate(scaled("error", 0.5), part=2)),
    "one width of order 2's errors": ("certificate.json", certificate(_narrower, part=1)),
    "ranges 1 % too narrow": ("certificate.json", certificate(scaled("reach", 0.99), part=2)),
    "another pole": ("certificate.json", certificate(_other_pole)),
    "another gain": ("certificate.json", certificate(_other_gain, part=1)),
    "a wider start": ("certificate.json", certificate(_wider_start)),
    "words of half the unit": ("certificate.json", certificate(_finer, part=1)),
    "the manifest's bound": ("manifest.json", claimed(scaled("bound_K", 0.9))),
    "the comment's bound": (STEP, replaced(r"never more than [\d.]+e-(\d+) K", r"never more than 1.0e-09 K")),
}
FLOAT: dict[str, tuple[str, Edit]] = {
    "a stored byte": (SCHEDULE, replaced(r"\{0x[1-9A-F].", "{0x00")),
    "a column's base": (SCHEDULE, replaced(r"0x(\w{5})\w{3}UL", r"0x\1FFFUL")),
    "a product left out": (STEP, replaced(r"    q = now->rate\[1\] \* q;\n", "")),
    "x2 added with another shift": (STEP, added(r"small_read\(&state->x\[1\]\), (\d+)\)", 1)),
    "the carried share": (STEP, replaced(r"const float carried = [\d.e-]+f", "const float carried = 0.001f")),
    "q not corrected for what was carried": (STEP, replaced(r"return q - back;", "return q;")),
    "an accumulator rounded to its unit": ("small_accumulator.cpp", replaced(r"256\.0f / static", "255.0f / static")),
    "a bound 1 % too small": ("certificate.json", certificate(scaled("bound_K", 0.99))),
    "order 3's errors half as wide": ("certificate.json", certificate(scaled("error", 0.5), part=2)),
}


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
def test_what_was_emitted_is_proven(emitted: dict[str, Path], arithmetic: str) -> None:
    found = gen.check(emitted[arithmetic])
    assert [part.name for part in found.parts] == ["part0", "part1", "part2"]
    assert found.unproven == ()


@pytest.mark.campaign
@pytest.mark.parametrize("defect", share(FIXED))
def test_a_defect_in_fixed_point_is_refuted(emitted: dict[str, Path], tmp_path: Path, defect: str) -> None:
    with pytest.raises(CheckFailed):
        gen.check(planted(emitted["fixed"], tmp_path, *FIXED[defect]))


@pytest.mark.campaign
@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
@pytest.mark.parametrize("defect", share(AMBIENT))
def test_a_defect_of_the_ambient_is_refuted(
    emitted: dict[str, Path], tmp_path: Path, defect: str, arithmetic: str
) -> None:
    with pytest.raises(CheckFailed):
        gen.check(planted(emitted[arithmetic], tmp_path, *AMBIENT[defect]))


@pytest.mark.campaign
@pytest.mark.parametrize("defect", share(FLOAT))
def test_a_defect_in_float_is_refuted(emitted: dict[str, Path], tmp_path: Path, defect: str) -> None:
    with pytest.raises(CheckFailed):
        gen.check(planted(emitted["float"], tmp_path, *FLOAT[defect]))
