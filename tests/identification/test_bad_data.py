"""Broken data: one clear message with the place, or an honest result."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gen.coefficients import load
from gen.errors import InputError
from gen.identification.logs.ambients import ambients_of
from gen.identification.logs.data import make_data, read_data
from gen.identification.logs.sources import Source
from gen.identification.network.data import make_network_data
from gen.identification.parts.identify import identify
from gen.runs import Run, write_run
from tests.command import gen

TIME = np.arange(0.0, 7200.0, 4.0)


def step(tau: float = 1200.0, rise: float = 40.0, pwm: int = 102, ambient: float = 30.0) -> Run:
    part = ambient + rise * (1.0 - np.exp(-TIME / tau))
    noise = np.random.default_rng(pwm).normal(0.0, 0.1, len(TIME))
    return Run(
        TIME,
        np.full(len(TIME), pwm),
        {"brush": np.round((part + noise) * 4) / 4},
        np.full(len(TIME), ambient),
    )


def gen_identify(tmp_path: Path, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return gen("identify", *arguments, "--out", tmp_path / "coeffs.json")


def edit(line: int, change: Callable[[list[str]], list[str]]) -> Callable[[list[str]], list[str]]:
    def applied(lines: list[str]) -> list[str]:
        fields = change(lines[line].split(","))
        return [*lines[:line], ",".join(fields), *lines[line + 1 :]]

    return applied


BROKEN: dict[str, tuple[Callable[[list[str]], list[str]], list[str]]] = {
    "time runs back": (edit(5, lambda f: ["3", *f[1:]]), ["line 6, column time_s", "found 3"]),
    "text in numbers": (edit(9, lambda f: [*f[:2], "hot", f[3]]), ["line 10, column brush_degC", '"hot"']),
    "no pwm": (lambda lines: [line.replace("pwm", "duty") for line in lines], ["line 1", "missing column pwm"]),
    "no temperature": (
        lambda lines: [line.replace("brush_degC", "brush") for line in lines],
        ["missing column <component>_degC", "brush"],
    ),
    "in Fahrenheit by its name": (
        lambda lines: [line.replace("brush_degC", "brush_degF") for line in lines],
        ["brush_degF is not in degC"],
    ),
    "a name that cannot be built": (
        lambda lines: [line.replace("brush_degC", "2nd brush_degC") for line in lines],
        ["column 2nd brush_degC", "C identifier"],
    ),
    "all missing": (
        lambda lines: [lines[0], *(",".join([*line.split(",")[:2], "", line.split(",")[3]]) for line in lines[1:])],
        ["nothing can be identified", "brush is left out: no run holds enough samples"],
    ),
    "constant channel": (
        lambda lines: [lines[0], *(",".join([*line.split(",")[:2], "31", line.split(",")[3]]) for line in lines[1:])],
        ["brush is left out", "it does not react"],
    ),
    "one row": (lambda lines: lines[:2], ["found 1 row", "expected at least"]),
    "never driven": (
        lambda lines: [lines[0], *(",".join([line.split(",")[0], "0", *line.split(",")[2:]]) for line in lines[1:])],
        ["found PWM 0 in every row"],
    ),
    "empty": (lambda _: [""], ["the file is empty"]),
}


@pytest.mark.parametrize("fault", BROKEN)
def test_a_fault_is_one_message_with_its_place_and_exit_2(fault: str, tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    write_run(path, step())
    change, expected = BROKEN[fault]
    path.write_text("\n".join(change(path.read_text().splitlines())))
    done = gen_identify(tmp_path, path)
    assert done.returncode == 2, done.stdout
    assert len(done.stderr.strip().splitlines()) == 1
    assert str(path) in done.stderr
    for text in expected:
        assert text in done.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.csv"]


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    done = gen_identify(tmp_path, tmp_path / "none.csv")
    assert done.returncode == 2
    assert "none.csv: there is no such file" in done.stderr


def test_a_step_without_change_of_pwm_is_enough(tmp_path: Path) -> None:
    """PWM never changes: one speed, from cold. The file says that it holds there only."""
    path = tmp_path / "run.csv"
    write_run(path, step())
    done = gen_identify(tmp_path, path, "--model", "parts")
    assert done.returncode == 0, done.stderr
    loaded = load(tmp_path / "coeffs.json")
    assert loaded.model.validity == (102, 102)
    assert loaded.model.component("brush").steady_rise([102])[0] == pytest.approx(40.0, abs=0.2)
    assert "next run: PWM" in done.stdout


def test_a_run_shorter_than_what_is_looked_for_in_it_is_told(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    write_run(path, step())
    done = gen_identify(tmp_path, path, "--model", "parts", "--sample-time", "3600")
    assert done.returncode == 2
    assert "no time constant below 1.08e+05 s is looked for" in done.stderr
    assert not (tmp_path / "coeffs.json").exists()


def test_a_hot_start_is_not_called_fahrenheit() -> None:
    """60 K above a room of 30 degC: in Fahrenheit that would be 32 degC, and 100 K above it 54."""
    run = step()
    for rise, said in ((60.0, True), (100.0, False)):
        hot = Run(run.time_s, run.pwm, {"brush": run.temps["brush"] + rise}, run.ambient)
        assert any("Fahrenheit" in w for w in make_data([Source("run.csv", hot)], None).warnings) is said


def test_fahrenheit_is_suspected() -> None:
    run = step()
    hot = Run(run.time_s, run.pwm, {"brush": run.temps["brush"] * 1.8 + 32.0}, run.ambient)
    data = make_data([Source("run.csv", hot)], None)
    assert any("Fahrenheit" in warning for warning in data.warnings)
    assert not any("Fahrenheit" in w for w in make_data([Source("run.csv", run)], None).warnings)


def test_a_run_of_nothing_but_missing_samples_is_left_out_and_said() -> None:
    empty = Run(TIME, np.full(len(TIME), 204), {"brush": np.full(len(TIME), np.nan)}, np.full(len(TIME), 30.0))
    data = make_data([Source("empty.csv", empty), Source("run.csv", step())], None)
    assert [record.run for record in data.records["brush"]] == ["run"]
    assert any("empty.csv" in warning and "0 sample(s)" in warning for warning in data.warnings)
    found = identify(data, lambda _: None)["brush"]
    assert found.speeds == [102]


def test_gaps_and_irregular_sampling_do_not_matter() -> None:
    rng = np.random.default_rng(1)
    keep = np.sort(rng.choice(len(TIME), 500, replace=False))
    keep = keep[(keep < 300) | (keep > 600)]
    run = step()
    brush = run.temps["brush"][keep].copy()
    brush[::7] = np.nan
    sparse = Run(run.time_s[keep], run.pwm[keep], {"brush": brush}, np.full(len(keep), 30.0))
    found = identify(make_data([Source("run.csv", sparse)], None), lambda _: None)["brush"]
    assert found.fit.steady[0] == pytest.approx(40.0, abs=0.4)
    assert np.exp(found.fit.theta[0, 0]) == pytest.approx(1200.0, rel=0.03)


def test_without_ambient_a_cold_start_says_it_and_a_warm_one_asks() -> None:
    cold = step()
    data = make_data([Source("run.csv", Run(cold.time_s, cold.pwm, cold.temps))], None)
    assert data.ambient_fixed == pytest.approx(30.0, abs=0.5)
    assert any("cold start is assumed" in warning for warning in data.warnings)
    warm = Run(cold.time_s, cold.pwm, {**cold.temps, "casing": cold.temps["brush"] + 20.0})
    with pytest.raises(InputError, match="--ambient"):
        make_data([Source("run.csv", warm)], None)
    noted = Run(cold.time_s, cold.pwm, cold.temps, comments={"ambient_degC": "29.5"})
    assert make_data([Source("run.csv", noted)], None).ambient_fixed == 29.5
    for word in ("warm", "nan", "inf", "-400"):
        noted = Run(cold.time_s, cold.pwm, cold.temps, comments={"ambient_degC": word})
        with pytest.raises(InputError, match=f'# ambient_degC: found "{word}", expected a temperature'):
            make_data([Source("run.csv", noted)], None)


def test_what_begins_warmer_than_rooms_are_and_cools_did_not_begin_in_its_room() -> None:
    """As a furnace does that was hot when the log began; what only gets warmer from 70 degC on did not either."""
    time, rng = 10.0 * np.arange(400.0), np.random.default_rng(3)
    power = np.where(time < 2000.0, 0, 150)
    plate = 24.0 + 106.0 * np.exp(-np.minimum(time, 2000.0) / 900.0) + 0.02 * np.maximum(time - 2000.0, 0.0)
    run = Run(time, power, {"plate": plate + rng.normal(0.0, 0.1, time.size)})
    data = make_network_data([Source("hot.csv", run)], None)
    assert data.ambient_fixed == 22.0
    assert data.fine[0].room_K == 8.0
    assert any("hot.csv: no ambient_degC, and a warm start; 22 degC" in warning for warning in data.warnings)
    for begin, room in ((130.0, 22.0), (55.0, 55.0)):
        warming = replace(run, temps={"plate": begin + 0.02 * time})
        assert make_network_data([Source("hot.csv", warming)], None).ambient_fixed == pytest.approx(room)
    beside = replace(run, temps={"plate": run.temps["plate"] - 95.0})  # begins at 35: it may be a hot day
    assert make_network_data([Source("warm.csv", beside)], None).ambient_fixed == pytest.approx(35.0, abs=0.5)


def test_a_warm_run_stands_in_the_room_of_the_cold_one() -> None:
    cold = step()
    warm = {name: values + 12.0 for name, values in cold.temps.items()}
    sources = [Source("warm.csv", Run(cold.time_s, cold.pwm, warm)), Source("cold.csv", replace(cold, ambient=None))]
    data = make_data(sources, None)
    assert any("warm.csv: no ambient_degC, and a warm start; 30" in warning for warning in data.warnings)
    first = [float(record.raw_rise[0]) for record in data.records["brush"]]
    assert first == pytest.approx([12.0, 0.0], abs=0.5)


@pytest.mark.parametrize(
    ("starts", "cold"),
    [
        # Two runs of two sensors, one of three, or three of one, at one level.
        ([(21.8, 22.0), (22.6, 22.4)], [True, True]),
        ([(21.8, 22.0, 22.3)], [True]),
        ([(22.0,), (22.3,), (21.9,)], [True, True, True]),
        # The one that was run before stands in their room.
        ([(21.8, 22.0), (22.6, 22.4), (39.0, 31.0)], [True, True, False]),
        # One may be warm as easily as cold, so may two readings, and levels that differ.
        ([(21.8, 22.0)], [False]),
        ([(22.0,), (22.3,)], [False, False]),
        ([(34.0, 34.5), (44.0, 44.2)], [False, False]),
        ([(34.0, 39.0), (34.2, 39.1)], [False, False]),
    ],
)
def test_what_begins_at_one_level_began_cold(starts: list[tuple[float, ...]], cold: list[bool]) -> None:
    time = 10.0 * np.arange(100.0)
    sources = [
        Source(f"{k}.csv", Run(time, np.full(100, 100), {f"part{s}": b + 0.01 * time for s, b in enumerate(begin)}))
        for k, begin in enumerate(starts)
    ]
    found = ambients_of(sources, None, [], estimated=True)
    assert found.cold == cold
    assert found.unsure_K == (0.5 if any(cold) else 5.0)
    # Where somebody says it, nothing is read from how runs begin.
    assert not any(ambients_of(sources, 20.0, [], estimated=True).cold)


def test_an_unsettled_run_shows_what_it_extrapolates() -> None:
    short = step(tau=1200.0)
    cut = slice(0, 300)  # 20 minutes: 63 % of the way
    assert short.ambient is not None
    run = Run(short.time_s[cut], short.pwm[cut], {"brush": short.temps["brush"][cut]}, short.ambient[cut])
    found = identify(make_data([Source("run.csv", run)], None), lambda _: None)["brush"]
    width = found.spread.factor * found.spread.deviation[found.fit.layout.thetas]
    assert found.settled[102] == pytest.approx(0.63, abs=0.05)
    assert width > 0.15
    assert abs(found.fit.steady[0] - 40.0) < width


def test_ten_million_rows(tmp_path: Path) -> None:
    """In memory, as reading them is the run reader's business; every row counts and it takes seconds."""
    count = 10_000_000
    time = np.linspace(0.0, 10800.0, count, dtype=np.float64)
    true = 30.0 + 40.0 * (1.0 - np.exp(-time / 1200.0))
    noisy = true + np.random.default_rng(1).normal(0.0, 0.5, count)
    run = Run(time, np.full(count, 102), {"brush": noisy}, np.full(count, 30.0))
    data = make_data([Source("run.csv", run)], None)
    record = data.records["brush"][0]
    assert record.count.sum() == count
    assert len(record.time) < 1000
    found = identify(data, lambda _: None, most=1)["brush"]
    assert found.fit.steady[0] == pytest.approx(40.0, abs=0.02)


def test_read_data_reads_files(tmp_path: Path) -> None:
    write_run(tmp_path / "a.csv", step())
    data = read_data([tmp_path / "a.csv"], None)
    assert list(data.records) == ["brush"]
    assert data.ambient_measured


def test_one_wild_first_reading_is_no_room() -> None:
    """A sensor before its first conversion, in a log so coarse that a part might have warmed as quickly."""
    run = replace(step(ambient=24.0), ambient=None)
    slow = Run(run.time_s[::2] * 5, run.pwm[::2], {"brush": run.temps["brush"][::2]})
    slow.temps["brush"][0] = 3.75
    data = make_data([Source("glitch.csv", slow)], None)
    assert data.ambient_fixed == pytest.approx(24.0, abs=1.0)
    warm = Run(slow.time_s, slow.pwm, {"brush": np.where(slow.time_s < 1.0, 24.0, slow.temps["brush"])})
    assert make_data([Source("sound.csv", warm)], None).ambient_fixed == pytest.approx(24.0, abs=0.3)


def test_one_sensor_under_two_names_is_told() -> None:
    first, second = step(), step(rise=60.0, pwm=204)
    renamed = replace(second, temps={"carbon": second.temps["brush"]})
    for make in (make_data, make_network_data):
        said = [
            w for w in make([Source("a.csv", first), Source("b.csv", renamed)], None).warnings if "no other run" in w
        ]
        assert [warning.partition(":")[0] for warning in said] == ["a.csv", "b.csv"]
        assert "a.csv: brush is in no other run, and carbon not in this one" in said[0]
        assert not [
            w for w in make([Source("a.csv", first), Source("b.csv", second)], None).warnings if "no other" in w
        ]


def test_a_run_without_any_part_is_told() -> None:
    """Its columns may only be called otherwise (`winding` for `winding_degC`)."""
    first, second = step(), step(rise=60.0, pwm=204)
    bare = replace(second, temps={}, extras={"winding": second.temps["brush"]})
    for make in (make_data, make_network_data):
        warnings = make([Source("a.csv", first), Source("b.csv", bare)], None).warnings
        said = [warning for warning in warnings if "holds no temperature of a part" in warning]
        assert [warning.partition(":")[0] for warning in said] == ["b.csv"]
