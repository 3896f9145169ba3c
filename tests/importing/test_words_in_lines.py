"""Lines that name words among their numbers: a mode, a direction, an error."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gen.importing.reading.pairs import names_in, words_in
from tests.importing.logs import TRUE, same, take, taken, write

KNOWN = TRUE[["time_s", "pwm", "winding_degC", "casing_degC"]]
LINES: dict[str, Callable[[float, float, float, float, str], str]] = {
    "first": lambda t, p, w, c, word: f"mode={word} t={t}s pwm={p:g} winding={w}C casing={c}C",
    "before the input": lambda t, p, w, c, word: f"t={t}s mode={word} pwm={p:g} winding={w}C casing={c}C",
    "before a temperature": lambda t, p, w, c, word: f"t={t}s, pwm={p:g}, mode={word}, winding={w}C, casing={c}C",
    "last": lambda t, p, w, c, word: f"t={t}s pwm={p:g} winding={w}C casing={c}C mode={word}",
    "spaces": lambda t, p, w, c, word: f"t = {t}s mode = {word} pwm = {p:g} winding = {w}C casing = {c}C",
    "quotes": lambda t, p, w, c, word: f't={t}s mode="{word} for now" pwm={p:g} winding={w}C casing={c}C',
    "colons": lambda t, p, w, c, word: f"T: {t}s mode: {word} pwm: {p:g} winding: {w}C casing: {c}C",
    "colon first": lambda t, p, w, c, word: f"mode:{word} T:{t}s pwm:{p:g} winding:{w}C casing:{c}C",
    "logfmt": lambda t, p, w, c, word: f'level=info msg="a row" t={t}s err={word} pwm={p:g} winding={w}C casing={c}C',
    "brackets": lambda t, p, w, c, word: f"[{t}] mode={word} pwm={p:g} winding={w}C casing={c}C",
    "hex": lambda t, p, w, c, word: f"t={t}s flags=0x{len(word):02X} pwm={p:g} winding={w}C casing={c}C",
}


@pytest.mark.parametrize("line", LINES)
def test_words_that_change_lose_no_line(line: str, tmp_path: Path) -> None:
    rows = [
        LINES[line](time, pwm, winding, casing, "HEAT" if pwm else "OVT" if i % 7 else "none")
        for i, (time, pwm, winding, casing) in enumerate(KNOWN.to_numpy())
    ]
    found = take(write(tmp_path, "\n".join(rows)), tmp_path / "out", units={"pwm": "counts"})
    assert found.counted().empty
    same(taken(tmp_path / "log.csv", tmp_path / "again", units={"pwm": "counts"}), KNOWN)


@pytest.mark.parametrize(("unit", "each_s"), [("min", 60.0), ("h", 3600.0), ("us", 1e-6), ("ms", 1e-3)])
def test_a_unit_of_times_behind_them(unit: str, each_s: float, tmp_path: Path) -> None:
    """None of it goes to the next name."""
    rows = [
        f"t={10 * i}{unit} pwm={pwm:g} winding={winding}C load={i % 7}W casing={casing}C"
        for i, (_, pwm, winding, casing) in enumerate(KNOWN.to_numpy())
    ]
    run = taken(write(tmp_path, "\n".join(rows)), tmp_path / "out", units={"pwm": "counts"})
    np.testing.assert_allclose(run.time_s, 10 * each_s * np.arange(len(TRUE)), atol=1e-9)
    assert run.pwm.tolist() == TRUE["pwm"].tolist()
    np.testing.assert_array_equal(run.temps["casing"], TRUE["casing_degC"])


def test_a_direction_is_that_of_the_input(tmp_path: Path) -> None:
    rows = [
        f"t={time}s pwm={pwm:g} dir={'REV' if time > 30 else 'FWD'} winding={winding}C"
        for time, pwm, winding in TRUE[["time_s", "pwm", "winding_degC"]].to_numpy()
    ]
    run = taken(write(tmp_path, "\n".join(rows)), tmp_path / "out", units={"pwm": "counts"})
    np.testing.assert_array_equal(run.pwm, np.where(TRUE["time_s"] > 30, -TRUE["pwm"], TRUE["pwm"]))


def test_a_unit_that_a_line_names(tmp_path: Path) -> None:
    rows = [
        f"t={time}s pwm={pwm:g} winding={winding * 1.8 + 32:.2f} winding_unit=degF"
        for time, pwm, winding in TRUE[["time_s", "pwm", "winding_degC"]].to_numpy()
    ]
    run = taken(write(tmp_path, "\n".join(rows)), tmp_path / "out", units={"pwm": "counts"})
    np.testing.assert_allclose(run.temps["winding"], TRUE["winding_degC"], atol=1e-6)


@pytest.mark.parametrize(
    ("line", "names", "words"),
    [
        ("t=0 mode=HEAT pwm=153", ("t", "pwm"), {"mode": "HEAT"}),
        ("t=0 pwm=off winding=22", ("t", "winding"), {"pwm": "off"}),
        ("t=0 winding=nan casing=21", ("t", "winding", "casing"), {}),
        ("sensor=casing temp=21 sensor=winding temp=22", ("casing temp", "winding temp"), {}),
        ("T: 0.5 heater: bed temp: 21", ("T", "bed temp"), {}),
        ("mcu: awake=0.01 extruder: target=210 temp=20", ("awake", "target", "temp"), {}),
        ("[app] Motor: winding of copper: 21, casing: 20", ("winding of copper", "casing"), {}),
        ("winding temp: 21.5 C dir: REV pwm: 3", ("winding temp", "pwm"), {"dir": "REV"}),
        ("date=2026-03-02 time=08:15:00 pwm=3", ("pwm",), {"date": "2026-03-02", "time": "08:15:00"}),
    ],
)
def test_what_a_line_names(line: str, names: tuple[str, ...], words: dict[str, str]) -> None:
    assert names_in(line) == names
    assert words_in(line) == words
