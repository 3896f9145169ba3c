"""Lines of printers, kilns and daemons: sections, wanted values, times before them, other lines between."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from gen.runs import read_run
from tests.importing.logs import TRUE, same, take, taken, write

ROWS = 60
WARM = [20.0 + 0.5 * i for i in range(ROWS)]
"""What is heated."""
COOL = [20.0 + 0.1 * i for i in range(ROWS)]


def of_sections() -> str:
    """As a printer's host prints its state: the same names behind each heater's, after a long text about itself."""
    lines = [f"text of the configuration, line {i}" for i in range(20)]
    for i in range(ROWS):
        bed = f"heater_bed: target=60 temp={COOL[i]:.1f} pwm=0.250"
        tool = f"extruder: target=210 temp={WARM[i]:.1f} pwm=0.640"
        lines.append(f"Stats {420126.9 + i:.1f}: gcodein=0 mcu: awake=0.010 {bed} print_time={5.0 + i:.1f} {tool}")
    return "\n".join(lines)


def test_names_that_return_are_those_of_their_section(tmp_path: Path) -> None:
    log = write(tmp_path, of_sections(), name="host.log")
    run = taken(log, tmp_path / "out", input="extruder.pwm")
    np.testing.assert_allclose(run.temps["extruder"], WARM)
    np.testing.assert_allclose(run.temps["heater_bed"], COOL)
    assert set(run.pwm.tolist()) == {163}
    np.testing.assert_allclose(np.diff(run.time_s), 1.0, atol=1e-6)
    with pytest.raises(
        InputError, match=r"2 columns may be the input; expected --input heater_bed\.pwm or --input extr"
    ):
        take(log, tmp_path / "more")


def test_a_long_text_before_the_lines_hides_none_of_them(tmp_path: Path) -> None:
    text = "\n".join(f"[section {i}]" for i in range(700)) + "\n" + "\n".join(of_sections().splitlines() * 20)
    with pytest.raises(InputError, match="columns may be the input"):
        take(write(tmp_path, text, name="host.log"), tmp_path / "out")


def of_a_printer(stamp: bool) -> str:
    lines = ["echo:Marlin 1.1.9", "echo:  M301 P22.20 I1.08 D114.00"]
    for i in range(ROWS):
        before = f"2020-03-01 10:{i // 30:02d}:{2 * i % 60:02d},123 - " if stamp else ""
        lines.append(f"{before}{'Send: ' if stamp else 'SENDING:'}M105")
        said = "Recv: ok" if stamp else "ok"
        lines.append(f"{before}{said} T:{WARM[i]:.2f} /200.00 B:{COOL[i]:.2f} /60.00 @:127 B@:64")
    return "\n".join(lines)


def test_wanted_values_and_commands_between_the_answers(tmp_path: Path) -> None:
    log = write(tmp_path, of_a_printer(False), name="printer.log")
    named = {"T": "hotend_degC", "B": "bed_degC"}
    run = taken(log, tmp_path / "out", time="2", input="@", full_scale=127, columns=named)
    np.testing.assert_allclose(run.temps["hotend"], WARM)
    np.testing.assert_allclose(run.temps["bed"], COOL)
    assert set(run.extras["T_target"].tolist()) == {200.0}
    assert set(run.pwm.tolist()) == {255}
    with pytest.raises(InputError, match=r"or --column B=winding_degC \(20\.\."):
        take(log, tmp_path / "more", time="2", input="@", full_scale=127, columns={"T": ""})


@pytest.mark.parametrize("between", [0, 1, 4, 12])
@pytest.mark.parametrize("stamp", [True, False])
def test_however_many_other_answers_stand_between_a_printers(between: int, stamp: bool, tmp_path: Path) -> None:
    """The bed is a temperature, too: it has a wanted value as the nozzle has. Rounds of lines fool no reader."""
    lines = []
    for i in range(8 * ROWS):
        before = f"10:{i // 30:02d}:{2 * i % 60:02d}.123 -> " if stamp else ""
        lines += [f"{before}echo:busy: processing"] * between
        k = min(i, ROWS - 1)
        lines.append(f"{before}T:{WARM[k]:.2f} /200.00 B:{COOL[k]:.2f} /60.00 @:127 B@:{64 + i % 2}")
    log = write(tmp_path, "\n".join(lines) + "\n", name="printer.log")
    run = taken(log, tmp_path / "out", input="@", full_scale=127.0, **({} if stamp else {"time": "2"}))
    np.testing.assert_allclose(run.temps["T"][:ROWS], WARM)
    np.testing.assert_allclose(run.temps["B"][:ROWS], COOL)
    np.testing.assert_allclose(run.extras["B_power"][:2], [64, 65])
    np.testing.assert_allclose(np.diff(run.time_s), 2.0, atol=1e-6)


def test_a_number_before_the_named_ones_is_their_time_where_it_rises(tmp_path: Path) -> None:
    rows = [f"{2 * i}.5 winding:{WARM[i]:.2f} casing:{COOL[i]:.2f} pwm:204" for i in range(ROWS)]
    run = taken(write(tmp_path, "\n".join(rows) + "\n", name="serial.log"), tmp_path / "out")
    np.testing.assert_allclose(run.temps["winding"], WARM)
    np.testing.assert_allclose(np.diff(run.time_s), 2.0, atol=1e-6)


def test_a_time_before_each_line_is_its_time(tmp_path: Path) -> None:
    log = write(tmp_path, of_a_printer(True), name="serial.log")
    run = taken(log, tmp_path / "out", input="@", full_scale=127, columns={"T": "hotend_degC", "B": "bed_degC"})
    np.testing.assert_allclose(np.diff(run.time_s), 2.0)
    np.testing.assert_allclose(run.temps["hotend"], WARM)


def test_of_a_daemon_s_line_its_own_time_counts_and_strangers_are_counted(tmp_path: Path) -> None:
    lines = []
    for i in range(ROWS):
        clock = f"06:{i // 30:02d}:{2 * i % 60:02d}"
        if i % 20 == 7:
            lines.append(f"Jan 21 {clock} pi systemd[1]: Started Session {i} of user pi.")
        said = f"temp ={WARM[i]:.1f}, target=93.2, pid=1.000, heat_on=2.00, run_time={2 * i}"
        lines.append(f"Jan 21 {clock} pi python[286]: 2019-01-21 {clock},390 INFO oven: {said}")
    log = write(tmp_path, "\n".join(lines), name="daemon.log")
    found = take(log, tmp_path / "out", input="pid", full_scale=1.0, units={"temp": "degF"})
    run = read_run(found.runs[0])
    assert run.time_s.size == ROWS
    np.testing.assert_allclose(np.diff(run.time_s), 2.0)
    np.testing.assert_allclose(run.temps["temp"], (np.array(WARM) - 32.0) / 1.8, atol=1e-6)
    assert found.counted()["count"].tolist() == [3]


def test_a_daemon_s_heating_is_proposed_for_the_input(tmp_path: Path) -> None:
    lines = [f"temp={WARM[i]}, target=93.2, pid=0.5, run_time={2 * i}" for i in range(ROWS)]
    with pytest.raises(InputError, match=r"expected what drives it, such as --input pid --full-scale 0\.5; "):
        take(write(tmp_path, "\n".join(lines)), tmp_path / "out")


def test_of_times_that_run_otherwise_none_is_chosen(tmp_path: Path) -> None:
    lines = [f"temp={WARM[i]} pwm=12.5 cpu_time={7 + 0.05 * i:.2f} print_time={3 + i}" for i in range(ROWS)]
    log = write(tmp_path, "\n".join(lines))
    with pytest.raises(InputError, match=r"cpu_time by 2\.95, print_time by 59: either may be the time"):
        take(log, tmp_path / "out")
    run = taken(log, tmp_path / "out", time="print_time", units={"pwm": "percent"})
    assert run.time_s[-1] == ROWS + 2


def test_degrees_as_a_small_computer_prints_them(tmp_path: Path) -> None:
    lines = [f"2024-05-01 10:{i // 60:02d}:{i % 60:02d} temp={WARM[i]:.1f}'C load=0.50" for i in range(ROWS)]
    run = taken(write(tmp_path, "\n".join(lines)), tmp_path / "out", input="load", full_scale=1.0)
    np.testing.assert_allclose(run.temps["temp"], WARM)


def test_a_processors_time_is_no_time_of_a_log(tmp_path: Path) -> None:
    """Klipper's lines have their own before it; a number that nobody knows has to be told."""
    lines = [
        f"Stats {100.1 + i:.1f}: cputime={1.1 + 0.4 * i:.3f} extruder: target=210 temp={WARM[i]:.1f} pwm=0.640"
        for i in range(ROWS)
    ]
    log = write(tmp_path, "\n".join(lines), name="host.log")
    np.testing.assert_allclose(np.diff(taken(log, tmp_path / "out").time_s), 1.0, atol=1e-6)
    log = write(tmp_path, "\n".join(lines).replace("Stats", "Lines"), name="other.log")
    with pytest.raises(InputError, match="no column is a time among Lines, cputime"):
        take(log, tmp_path / "out")


@pytest.mark.parametrize("stamp", ["(2026-11-26 10:00:{s:02d}.{ms:03d}456)", "({epoch}.{ms:03d}456)"])
@pytest.mark.parametrize("together", [True, False])
def test_decoded_frames_of_a_bus(stamp: str, together: bool, tmp_path: Path) -> None:
    """As `candump | cantools decode --single-line` prints them, of one message or of two."""

    def line(i: int, ms: int, said: str) -> str:
        before = stamp.format(s=i, epoch=1_795_687_200 + i, ms=ms)
        return f" {before}  can0  123   [4]  01 02 03 0A :: {said}"

    lines = []
    for i in range(ROWS):
        duty, temps = f"Duty: {60 if i < 40 else 0} %", f"TempWinding: {WARM[i]:.1f} degC, TempAmbient: 20.5 degC"
        parts = [f"Motor({duty}, {temps})"] if together else [f"Motor({duty})", f"Temps({temps})"]
        lines += [line(i, 123 + 100 * k, said) for k, said in enumerate(parts)]
    run = taken(write(tmp_path, "\n".join(lines), name="bus.log"), tmp_path / "out")
    known = np.isfinite(run.temps["TempWinding"])
    np.testing.assert_allclose(run.temps["TempWinding"][known], WARM)
    np.testing.assert_allclose(np.diff(run.time_s[known]), 1.0, atol=1e-6)
    assert run.pwm[known].tolist() == [153] * 40 + [0] * 20
    assert run.ambient is not None
    assert set(run.ambient[known].tolist()) == {20.5}


def test_lines_of_several_kinds_fill_their_own_columns_where_they_tell_their_times(tmp_path: Path) -> None:
    timed = "".join(
        f"I ({1000 * i}) drive: duty={60 if i < 40 else 0}%\nI ({1000 * i + 20}) sensors: winding={WARM[i]:.1f}C\n"
        for i in range(ROWS)
    )
    run = taken(write(tmp_path, timed, name="monitor.txt"), tmp_path / "out")
    known = np.isfinite(run.temps["winding"])
    np.testing.assert_allclose(run.temps["winding"][known], WARM)
    assert run.pwm[known].tolist() == [153] * 40 + [0] * 20


@pytest.mark.parametrize(
    "head",
    [
        lambda s: f"[{1000 * s} ms]",
        lambda s: f"({1000 * s}ms)",
        lambda s: f"{1000 * s} ms:",
        lambda s: f"[{s:12.6f}]",
        lambda s: f"[00:{s // 60:02d}:{s % 60:02d}.000,250] <inf> bench:",
    ],
    ids=["milliseconds in brackets", "in parentheses", "before a colon", "of a kernel", "of Zephyr"],
)
def test_what_stands_before_a_line_is_its_time(head: Callable[[int], str], tmp_path: Path) -> None:
    rows = [f"{head(2 * i)} PWM={204 if i < 40 else 0} winding={WARM[i]:.1f}C" for i in range(ROWS)]
    run = taken(write(tmp_path, "\n".join(["Booting v1.2", *rows]) + "\n", name="serial.txt"), tmp_path / "out")
    np.testing.assert_allclose(run.time_s, 2.0 * np.arange(ROWS), atol=1e-9)
    np.testing.assert_allclose(run.temps["winding"], WARM)
    assert run.pwm.tolist() == [204] * 40 + [0] * 20


def test_lines_of_one_time_that_each_name_one_number(tmp_path: Path) -> None:
    """As scripts for converters print, sensor by sensor."""
    lines = []
    for i, row in enumerate(TRUE.itertuples()):
        at = pd.Timestamp("2026-03-02 08:15:00") + pd.Timedelta(seconds=10 * i)
        lines += [f"{at} RTD1 = {row.winding_degC} C", f"{at} RTD2 = {row.casing_degC} C", f"{at} PWM = {row.pwm}"]
    run = taken(write(tmp_path, "\n".join(lines), name="rtd.log"), tmp_path / "out", units={"PWM": "counts"})
    known = TRUE[["pwm", "winding_degC", "casing_degC"]].assign(time_s=10.0 * np.arange(len(TRUE)))
    same(run, known, {"winding_degC": "RTD1_degC", "casing_degC": "RTD2_degC"})


ROUNDS: dict[str, Callable[[int, float, float, int], list[str]]] = {
    "millis among them": lambda t, w, c, p: [f"millis: {1000 * t}", f"Winding: {w} *C", f"Casing: {c} *C", f"PWM: {p}"],
    "a time above": lambda t, w, c, p: [
        f"--- {pd.Timestamp('2026-03-02 08:15') + pd.Timedelta(seconds=t)} ---",
        *(f"winding temp = {w} C", f"casing temp = {c} C", f"pwm = {p}"),
    ],
    "a monitor's times": lambda t, w, c, p: [
        f"08:{15 + t // 60:02d}:{t % 60:02d}.120 -> winding = {w}°C",
        f"08:{15 + t // 60:02d}:{t % 60:02d}.124 -> casing = {c}°C",
        f"08:{15 + t // 60:02d}:{t % 60:02d}.125 -> pwm = {p}",
    ],
}


@pytest.mark.parametrize("form", ROUNDS)
def test_lines_that_name_one_number_each_are_rows_round_by_round(form: str, tmp_path: Path) -> None:
    """One line is damaged: its number is missing, and nothing else is shifted."""
    frame = TRUE[["pwm", "winding_degC", "casing_degC"]]
    lines = [line for i, (p, w, c) in enumerate(frame.to_numpy()) for line in ROUNDS[form](10 * i, w, c, int(p))]
    at = next(i for i, line in enumerate(lines) if "asing" in line and i > 60)
    lines[at] = lines[at][: lines[at].index("asing")]
    log = write(tmp_path, "\n".join(lines), name="monitor.log")
    units = {name: "counts" for name in ("PWM", "pwm") if name in "".join(lines)}
    run = taken(log, tmp_path / "out", units=units)
    np.testing.assert_allclose(run.time_s - run.time_s[0], 10.0 * np.arange(len(TRUE)))
    np.testing.assert_allclose(run.temps["winding"], TRUE["winding_degC"])
    known = np.isfinite(run.temps["casing"])
    assert (~known).sum() == 1
    np.testing.assert_allclose(run.temps["casing"][known], TRUE["casing_degC"][known])
    assert run.pwm.tolist() == TRUE["pwm"].tolist()


def test_rounds_without_times_say_how_to_print_them(tmp_path: Path) -> None:
    lines = [line for row in TRUE.itertuples() for line in (f"Winding: {row.winding_degC}", f"PWM: {row.pwm}")]
    log = write(tmp_path, "\n".join(lines), name="monitor.log")
    with pytest.raises(InputError, match=r"or --time SECONDS for .*; better, print millis\(\) in a line of each round"):
        take(log, tmp_path / "out")
    same(taken(log, tmp_path / "out", time="0.5", units={"PWM": "counts"}), TRUE[["time_s", "pwm", "winding_degC"]])
