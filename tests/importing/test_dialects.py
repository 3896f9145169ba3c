"""A known table, written in a dialect drawn at random, comes back as the same numbers."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from hypothesis import given, settings
from hypothesis import strategies as st

from gen.errors import InputError
from gen.runs import read_run
from tests.importing.logs import same, take

TIMES = {"s": 1.0, "ms": 1000.0, "min": 1 / 60, "h": 1 / 3600}
DEGREES = {"°C": (1.0, 0.0), "degC": (1.0, 0.0), "°F": (1.8, 32.0), "degF": (1.8, 32.0), "K": (1.0, 273.15)}
INPUTS = {"counts": 255.0, "%": 100.0, "duty": 1.0}


@dataclass(frozen=True)
class Dialect:
    """How a logger writes."""

    delimiter: str
    decimal: str
    encoding: str
    newline: str
    time: str
    degrees: str
    drive: str
    units: str
    quotes: bool
    order: tuple[int, ...]
    comments: int


@st.composite
def dialects(draw: st.DrawFn) -> Dialect:
    delimiter = draw(st.sampled_from([",", ";", "\t", "|"]))
    quotes = draw(st.booleans())
    decimal = "." if delimiter == "," and not quotes else draw(st.sampled_from([".", ","]))
    return Dialect(
        delimiter=delimiter,
        decimal=decimal,
        encoding=draw(st.sampled_from(["utf-8", "utf-8-sig", "cp1252", "latin-1", "utf-16"])),
        newline=draw(st.sampled_from(["\n", "\r\n", "\r"])),
        time=draw(st.sampled_from(list(TIMES))),
        degrees=draw(st.sampled_from(list(DEGREES))),
        drive=draw(st.sampled_from(list(INPUTS))),
        units=draw(st.sampled_from(["brackets", "row"])),
        quotes=quotes,
        order=tuple(draw(st.permutations(range(5)))),
        comments=draw(st.integers(0, 3)),
    )


@st.composite
def tables(draw: st.DrawFn) -> pd.DataFrame:
    """Temperatures in hundredths that begin cold; times in whole tenths of a second."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    rows = draw(st.integers(30, 80))
    steps = rng.integers(1, 60, rows)
    begin = draw(st.integers(1700, 2600))
    winding = (begin + np.maximum(np.cumsum(rng.integers(-30, 90, rows)), -300)) / 100
    pwm = rng.integers(-255, 256, rows)
    return pd.DataFrame(
        {
            "time_s": (np.cumsum(steps) - steps[0]) / 10,
            "pwm": pwm,
            "winding_degC": winding,
            "casing_degC": begin / 100 + np.arange(rows) / 50,
            "ambient_degC": np.full(rows, begin / 100),
        }
    )


def written(frame: pd.DataFrame, how: Dialect) -> bytes:
    """The log's bytes; numbers in the shortest form that is exact."""
    scale, offset = DEGREES[how.degrees]
    columns = {
        "Time": frame.time_s * TIMES[how.time],
        "PWM": frame.pwm / 255 * INPUTS[how.drive],
        **{name: frame[f"{name.lower()}_degC"] * scale + offset for name in ("Winding", "Casing", "Ambient")},
    }
    units = [how.time, how.drive, *[how.degrees] * 3]
    names = list(columns)
    chosen = [(names[i], units[i]) for i in how.order]
    heads = [f"{name} [{unit}]" if how.units == "brackets" else name for name, unit in chosen]
    lines = [f"# line {i} of the preamble" for i in range(how.comments)]
    rows = [heads] if how.units == "brackets" else [heads, [unit for _, unit in chosen]]
    cells = [[repr(float(value)).replace(".", how.decimal) for value in columns[name]] for name, _ in chosen]
    rows += [list(row) for row in zip(*cells, strict=True)]
    for row in rows:
        lines.append(how.delimiter.join(f'"{cell}"' if how.quotes else cell for cell in row))
    return how.newline.join([*lines, ""]).encode(how.encoding)


@settings(max_examples=80, deadline=None)
@given(tables(), dialects())
def test_a_table_in_any_dialect_comes_back(frame: pd.DataFrame, how: Dialect) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.csv"
        path.write_bytes(written(frame, how))
        found = take(path, Path(folder) / "runs")
        assert list(found.guesses().confidence < 0.6) == [False] * len(found.guesses())
        same(read_run(found.runs[0]), frame)


@settings(max_examples=25, deadline=None)
@given(tables(), dialects())
def test_a_second_import_by_the_mapping_that_the_first_one_wrote_is_the_same(frame: pd.DataFrame, how: Dialect) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path, mapping = Path(folder) / "log.csv", Path(folder) / "map.toml"
        path.write_bytes(written(frame, how))
        first = take(path, Path(folder) / "first", mapping=mapping)
        assert first.mapping == mapping
        before = mapping.read_bytes()
        second = take(path, Path(folder) / "second", mapping=mapping)
        assert second.mapping is None
        assert mapping.read_bytes() == before
        assert second.guesses().confidence.eq(1.0).all()
        assert first.runs[0].read_bytes() == second.runs[0].read_bytes()


TEXT = st.text(max_size=300).map(lambda text: text.encode("utf-8", "surrogatepass"))
GOOD = [b"time_s,pwm,winding_degC\n", b"0,1,2\n", b"1;2;3\n", b"1,2,3\n", b"2,2,3\n"]
BAD = [b'"', b"\x00", b"\xff\xfe", b"#", b"{", b"[", b"1e999,nan,-\n", b"T1:23.4 T2:25\n", b"2024-13-45 99:99:99,1,2\n"]
PIECES = st.lists(st.one_of(st.sampled_from(GOOD), st.sampled_from(BAD), st.binary(max_size=30)), max_size=40).map(
    b"".join
)


@settings(max_examples=200, deadline=None)
@given(
    st.one_of(st.binary(max_size=400), TEXT, PIECES), st.sampled_from(["log.csv", "log.mat", "log.xlsx", "log.json"])
)
def test_whatever_a_file_holds_it_is_taken_or_refused_in_one_line(data: bytes, name: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path, out = Path(folder) / name, Path(folder) / "runs"
        path.write_bytes(data)
        try:
            found = take(path, out)
        except InputError as error:
            assert str(error).startswith(str(path))
            assert len(error.message) < 1500
            assert [item.name for item in Path(folder).iterdir()] == [name]
        else:
            for run in found.runs:
                read_run(run)
