"""The time of every row of a table, in s."""

from __future__ import annotations

from collections.abc import Callable
from zoneinfo import ZoneInfo

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.errors import InputError
from gen.importing import clock, sequence
from gen.importing.converted import Converted, count_units_apart
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.local import in_utc
from gen.importing.mapping import Mapping, TimeForm
from gen.importing.origins import days_since, seconds_since
from gen.importing.table import Cells, Counted
from gen.importing.units import unit_of

_DAY_S = 86_400.0
_LONGEST_S = 1e9
_LATEST_S = 1e12
"""Run files hold no larger number."""
_MOST_ASTRAY = 0.1
"""Of the rows: a clock that is set after a while, or garbage."""
_DAY_DIGITS = 4
"""Of s: a double holds a day of today to 10 us at best."""
_EPOCH_DIGITS = 6
"""Of s: a double holds a second of today to 0.2 us."""

_COUNTERS = {
    "ms": sequence.Round("32-bit milliseconds", 2.0**32 * 1e-3),
    "us": sequence.Round("32-bit microseconds", 2.0**32 * 1e-6),
}
_OF_A_DAY = sequence.Round("the time since midnight", _DAY_S, running=True)
_OF_AN_HOUR = sequence.Round("the minutes of an hour", 3600.0)
_OF_HALF_A_DAY = sequence.Round("the hours of half a day", _DAY_S / 2, 3600.0)
"""Hours from 1 to 12 without AM and PM."""


def timed(evidence: Evidence, index: int, form: TimeForm, made: Converted) -> tuple[FloatArray, str]:
    """Time of every row in s, NaN where it has none; and the instant at which it is 0."""
    table = made.table
    if form.interval_s is not None:
        return np.arange(table.rows, dtype=np.float64) * form.interval_s, ""
    facts = [evidence.facts[name] for name in form.columns]
    first = facts[0]
    unit = unit_of(form.unit)
    if unit is not None and unit.quantity == "time":
        parsed = first.parsed_in(index, unit)
        made.count("row without a time", np.flatnonzero(~np.isfinite(parsed.values)), first.name)
        count_units_apart(first, parsed, unit.name, made)
        time, begun = _numbered(parsed.values, unit.scale, first.name)
        return _within(time, first.name, made), begun
    ns = _instants(facts, index, form.unit, form.order, made)
    if form.zone:
        if zoned(first.columns[index].cells):
            raise InputError(
                "times say how far they are from UTC; expected no --zone", place=made.table.place(0, first.name)
            )
        ns = in_utc(ns, ZoneInfo(form.zone))
    made.count("row without a time", np.flatnonzero(ns == clock.MISSING), first.name)
    if form.unit in ("time of day", "mm:ss"):
        return clock.in_seconds(ns), ""
    time, _ = clock.seconds(ns)
    near = np.isfinite(_within(time, first.name, made))
    time, begin = clock.seconds(np.where(near, ns, clock.MISSING))
    return time, "" if begin is None else _iso(begin)


def _within(time: FloatArray, column: str, made: Converted) -> FloatArray:
    """Leave out a few times that no log reaches; refuse where they are many, as where s become ms on the way."""
    finite = time[np.isfinite(time)]
    if not finite.size:
        return time
    middle = float(np.sort(finite)[finite.size // 2])  # one of them, where half are of another time
    if abs(middle) > _LATEST_S:
        raise InputError(f"found times of about {middle:g} s, expected less than 30 years", place=f"column {column}")
    astray = np.abs(time - middle) > _LONGEST_S
    rows = np.flatnonzero(astray)
    if rows.size > _MOST_ASTRAY * time.size:
        raise InputError(
            f"found a time of {time[rows[0]]:g} s where most are about {middle:g} s; expected one unit of time in all "
            "rows (s became ms, or a clock was set?), and less than 30 years",
            place=made.table.place(int(rows[0]), column),
        )
    made.count("time more than 30 years from the others, left out", rows, column)
    return np.where(astray, np.nan, time)


def _numbered(values: FloatArray, scale: float, name: str) -> tuple[FloatArray, str]:
    """Numbers in a unit of time; those since 1970, or since long before, count from the first."""
    finite = values[np.isfinite(values)]
    first = float(finite[0]) if finite.size else 0.0
    counted = seconds_since(first * scale, name) if scale <= 1.0 else None
    if counted is None and 1e9 < first * scale < 2.5e9:
        since = np.round(values - first, _EPOCH_DIGITS) if scale == 1.0 else values - first
        return _scaled(since, scale), _iso(round(float(_scaled(finite[:1], scale)[0]) * 1e6) * 1000)
    if counted is not None:
        begin = round((first * scale + counted[0]) * 1e3) * 10**6
        return np.round(_scaled(values - first, scale), _EPOCH_DIGITS), _iso(begin)
    of_days = days_since(first) if scale == _DAY_S else None
    if of_days is not None:
        begin = round((first + of_days[0]) * _DAY_S * 1e3) * 10**6
        return np.round((values - first) * _DAY_S, _DAY_DIGITS), _iso(begin)
    return _scaled(values, scale), ""


def _scaled(values: FloatArray, scale: float) -> FloatArray:
    """In s; a division by 1000 is rounded correctly, a product with 0.001 is not."""
    parts = round(1.0 / scale) if scale < 1.0 else 0
    exact = parts > 0 and abs(parts * scale - 1.0) < 1e-12
    return np.asarray(values / parts if exact else values * scale, dtype=np.float64)


def _iso(ns: int) -> str:
    return str(np.datetime64(ns // 10**6, "ms"))


def _instants(facts: list[Facts], index: int, unit: str, order: str, made: Converted) -> IntArray:
    cells = facts[0].columns[index].cells
    if not isinstance(cells, list):
        if cells.dtype.kind != "M":
            raise InputError(f"holds numbers, expected a {unit}", place=f"column {facts[0].name}")
        return clock.of_instants(cells)  # type: ignore[arg-type]
    if unit == "mm:ss":
        return _read(facts[0], index, clock.minutes)
    if unit == "timestamp":
        return _read(facts[0], index, clock.instants, order)
    if unit == "date and time":
        times = facts[1].columns[index].cells
        if not isinstance(times, list):
            raise InputError("holds numbers, expected times of day", place=f"column {facts[1].name}")
        return clock.together(_read(facts[0], index, clock.instants, order), _read(facts[1], index, clock.of_day))
    ns, nights = clock.over_midnight(_read(facts[0], index, clock.of_day))
    if nights:
        made.counted.append(Counted("midnight passed", nights, f"column {facts[0].name}"))
    return ns


def _read(facts: Facts, index: int, read: Callable[..., IntArray], *order: str) -> IntArray:
    """Times of one table's texts; they are read once, which takes long."""
    key: tuple[int | str, ...] = (index, str(read.__name__), *order)
    if key not in facts.times_read:
        facts.times_read[key] = read(facts.columns[index].cells, *order)
    return facts.times_read[key]


def ticks_of(evidence: Evidence, index: int, mapping: Mapping) -> sequence.Ticks:
    """What kind of clock the times are of."""
    form = mapping.time
    if not form.columns:
        return sequence.Ticks()
    facts = evidence.facts[form.columns[0]]
    unit = unit_of(form.unit)
    if unit is not None and unit.quantity == "time":
        values = facts.parsed_in(index, unit).values
        whole = bool(np.all(values[np.isfinite(values)] % 1.0 == 0.0))
        counter = _COUNTERS.get(unit.name) if whole else None
        return sequence.Ticks((counter, _OF_A_DAY) if counter else (_OF_A_DAY,))
    cells = facts.columns[index].cells
    if form.unit == "mm:ss":
        return sequence.Ticks((_OF_AN_HOUR,))
    return sequence.Ticks((_OF_HALF_A_DAY,) if form.unit == "time of day" else (), not form.zone and not zoned(cells))


def zoned(cells: Cells) -> bool:
    """Whether times say how far they are from UTC."""
    return isinstance(cells, list) and clock.zoned(cells)
