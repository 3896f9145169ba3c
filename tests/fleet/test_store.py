"""Runs in a store: the same when read back, once each, whole or not at all, and nowhere else."""

from __future__ import annotations

import json
import uuid
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.dataset as ds
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from gen.errors import InputError
from gen.fleet.folder.names import checked_day, checked_motor, stem_of
from gen.fleet.folder.run_bytes import content_hash, from_bytes, to_bytes
from gen.fleet.folder.store import INCOMING, Store
from gen.fleet.tasks import motor_data
from gen.runs import Run
from tests.fleet.made import run_of

floats = st.floats(allow_nan=True, allow_infinity=False, width=64)
words = st.text(st.characters(codec="utf-8", exclude_characters="\n\r\0"), max_size=8)


@st.composite
def any_runs(draw: st.DrawFn) -> Run:
    rows = draw(st.integers(1, 20))
    column = arrays.arrays(np.float64, rows, elements=floats)
    return Run(
        time_s=np.cumsum(draw(arrays.arrays(np.float64, rows, elements=st.floats(1e-3, 1e4)))),
        pwm=draw(arrays.arrays(np.int64, rows, elements=st.integers(-255, 255))),
        temps={name: draw(column) for name in draw(st.sets(st.sampled_from(["brush", "casing"])))},
        ambient=draw(st.none() | column),
        extras={name: draw(column) for name in draw(st.sets(st.sampled_from(["current_A", "x_degC", "motor"])))},
        comments=draw(st.dictionaries(words, words, max_size=3)),
        rows_in_file=draw(st.none() | st.integers(1, 10**9)),
        doubted=tuple(draw(st.lists(words, max_size=2))),
    )


def same(one: Run, other: Run) -> None:
    mine, yours = one.columns(), other.columns()
    assert list(mine) == list(yours)
    for name, values in mine.items():
        assert values.dtype == yours[name].dtype
        assert values.tobytes() == yours[name].tobytes()
    assert list(one.temps) == list(other.temps)
    assert (one.ambient is None) == (other.ambient is None)
    assert list(one.comments.items()) == list(other.comments.items())
    assert (one.rows_in_file, one.doubted) == (other.rows_in_file, other.doubted)


@given(any_runs())
def test_a_run_is_the_same_when_read_back(run: Run) -> None:
    again = from_bytes(to_bytes(run), "file")
    same(run, again)
    assert content_hash(run) == content_hash(again)


@pytest.mark.parametrize("scheme", ["{}", "file://{}", "memory://{}"])
def test_a_run_is_kept_once_whatever_it_is_called(scheme: str, tmp_path: Path) -> None:
    store = Store(scheme.format(tmp_path / uuid.uuid4().hex))
    run = run_of(1, hours=0.1)
    kept, new = store.add("a-1", "2026-01-02", "monday", run)
    assert new
    assert store.add("a-1", "2026-01-03", "again", run) == (kept, False)
    assert store.motors() == ["a-1"]
    assert store.runs("a-1") == [kept]
    assert store.names(INCOMING) == []
    same(store.run(kept), run)
    assert store.add("b", "2026-01-02", "monday", run)[1]


@pytest.mark.parametrize(
    "bad", ["", ".", "..", "../x", "a/b", "a\\b", "a b", "a\n", "é", "a..b", "a.", "-a", "x" * 65, "a%2f"]
)
def test_a_motor_cannot_lead_out_of_its_place(bad: str) -> None:
    with pytest.raises(InputError, match="--motor"):
        checked_motor(bad)


@given(st.text(max_size=200))
def test_any_name_of_a_file_becomes_one_that_can_be_kept(name: str) -> None:
    made = stem_of(name)
    assert 0 < len(made) <= 80
    assert made.isascii()
    assert not set(made) & set("/\\: ")
    assert not made.startswith(".")


@pytest.mark.parametrize("bad", ["2026-13-01", "2026-1-1", "20260101", "2026-02-30", "today", "2026-01-01\n"])
def test_a_day_is_one_of_the_calendar(bad: str) -> None:
    with pytest.raises(InputError, match="--day"):
        checked_day(bad)


def test_what_cannot_be_moved_to_its_place_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = Store(str(tmp_path))
    files: Any = store._reached[0]

    def refuse(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(type(files), "mv", refuse)
    with pytest.raises(KeyboardInterrupt):
        store.add("a", "2026-01-01", "run", run_of(1, hours=0.1))
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


@pytest.mark.parametrize("damage", [b"", b"PAR1", b"not parquet"])
def test_a_file_that_is_no_run_is_told_by_name(damage: bytes, tmp_path: Path) -> None:
    store = Store(str(tmp_path))
    kept, _ = store.add("a", "2026-01-01", "run", run_of(1, hours=0.1))
    store.write(kept.path, damage)
    with pytest.raises(InputError, match=kept.name):
        store.run(kept)


def test_a_dataset_of_all_motors_can_be_asked(tmp_path: Path) -> None:
    store = Store(str(tmp_path))
    for motor in ("a", "b"):
        store.add(motor, "2026-01-01", "run", run_of(ord(motor), hours=0.1))
    data = ds.dataset(str(tmp_path / "runs"), partitioning="hive")
    table = data.to_table(filter=ds.field("motor") == "b", columns=["time_s", "casing_degC", "motor", "day"])
    assert set(table.column("motor").to_pylist()) == {"b"}
    assert set(table.column("day").to_pylist()) == {"2026-01-01"}


def test_a_run_that_an_earlier_gen_stored_is_read(tmp_path: Path) -> None:
    """As a store on disk has it, written down here and not by today's writer."""
    said: dict[str, Any] = {"version": 1, "components": ["brush"], "ambient": True, "comments": [["fault", "none"]]}
    said |= {"rows_in_file": 40, "doubted": []}
    columns: dict[str, Any] = {
        "time_s": [0.0, 1.0],
        "pwm": [0, 90],
        "brush_degC": [21.0, 21.5],
        "ambient_degC": [20.0, 20.0],
    }
    table = pa.table({**columns, "fan_percent": [0.0, 50.0]})
    pq.write_table(table.replace_schema_metadata({b"gen.run": json.dumps(said)}), tmp_path / "run")
    run = from_bytes((tmp_path / "run").read_bytes(), "run")
    assert run.pwm.tolist() == [0, 90]
    assert run.temps["brush"].tolist() == [21.0, 21.5]
    assert run.ambient is not None
    assert run.ambient.tolist() == [20.0, 20.0]
    assert run.extras["fan_percent"].tolist() == [0.0, 50.0]
    assert (run.comments, run.rows_in_file) == ({"fault": "none"}, 40)


def names(store: Store, motor: str) -> list[str]:
    """Names of a motor's runs as they were given, in the store's order."""
    return [kept.name.partition("-")[0] for kept in store.runs(motor)]


def begun(seed: int, started: str, first_s: float = 0.0) -> Run:
    run = run_of(seed, hours=0.05)
    return replace(run, time_s=run.time_s + first_s, comments={"started": started} if started else {})


def test_the_newest_run_of_a_day_is_the_last_that_began(tmp_path: Path) -> None:
    """Whatever runs are called, and in which order they are stored."""
    store = Store(str(tmp_path))
    for seed, (name, started) in enumerate(
        [
            ("run2", "2026-03-04T15:00:00"),
            ("run9", "2026-03-04T08:00:00.250Z"),
            ("run10", "2026-03-04T23:00:00+09:00"),
            ("before", "2026-03-03 23:59:59"),
        ]
    ):
        store.add("a", started[:10], name, begun(seed, started))
    assert names(store, "a") == ["before", "run9", "run10", "run2"]


def test_pieces_of_one_log_begin_with_their_first_rows(tmp_path: Path) -> None:
    """`gen import --split` lets the times of all go on from one `started`."""
    store = Store(str(tmp_path))
    for seed, (name, first_s) in enumerate([("a", 7200.0), ("b", 0.0), ("c", 3600.0)]):
        store.add("a", "2026-03-04", name, begun(seed, "2026-03-04T05:06:07", first_s))
    assert names(store, "a") == ["b", "c", "a"]


def test_runs_that_say_no_time_are_in_the_order_in_which_people_number_them(tmp_path: Path) -> None:
    """So are those that an earlier gen stored, with no beginning in their names."""
    store = Store(str(tmp_path))
    for seed, name in enumerate(["run10", "run9", "run2", "run"]):
        store.add("a", "2026-03-04", name, begun(seed, "2026-03-04" if name == "run9" else ""))
    for name in ("run11-0123456789abcdef", "run3-fedcba9876543210", "foreign"):
        store.write(f"runs/motor=a/day=2026-03-04/{name}.parquet", b"")
    store.write("runs/motor=a/day=2026-03-03/run99-0123456789abcdef.parquet", b"")
    store.add("a", "2026-03-04", "known", begun(9, "2026-03-04T00:00:00"))
    expected = ["run99", "foreign", "run", "run2", "run3", "run9", "run10", "run11", "known"]
    assert names(store, "a") == expected


def test_a_day_that_is_given_takes_the_place_of_what_a_run_says(tmp_path: Path) -> None:
    """A board's clock that was never set would make it the oldest."""
    store = Store(str(tmp_path))
    store.add("a", "2026-03-03", "set", begun(1, "2026-03-03T12:00:00"))
    store.add("a", "2026-03-04", "unset", begun(2, "1970-01-01T00:00:07"))
    assert names(store, "a") == ["set", "unset"]


@pytest.mark.parametrize("started", ["1", "2026-02-30T00:00:00", "0001-01-01T00:00:00+09:00", "9999-12-31T23:59:59"])
def test_a_beginning_that_is_none_is_no_obstacle(started: str, tmp_path: Path) -> None:
    store = Store(str(tmp_path))
    store.add("a", started[:10] if len(started) > 10 else "2026-01-01", "run", begun(1, started, 3600.0))
    assert names(store, "a") == ["run"]


def test_only_a_long_run_is_thinned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Up to twice the rows that are wanted it is read as it is."""
    store, run = Store(str(tmp_path)), run_of(3)
    store.add("a", "2026-01-01", "run", run)
    (kept,) = store.runs("a")
    rows = run.time_s.size
    monkeypatch.setattr(motor_data, "MOST_ROWS", rows // 2 + 1)
    found = motor_data.read(store, kept)
    assert np.array_equal(found.time_s, run.time_s)
    assert np.array_equal(found.pwm, run.pwm)
    assert all(np.array_equal(found.temps[name], run.temps[name]) for name in run.temps)
    monkeypatch.setattr(motor_data, "MOST_ROWS", rows // 4)
    assert motor_data.read(store, kept).time_s.size <= rows // 2
