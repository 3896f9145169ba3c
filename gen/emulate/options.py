"""What the options of `gen emulate` mean; every fault in them is named with its option."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Collection, Sequence
from itertools import pairwise
from math import inf
from pathlib import Path

import numpy as np

from gen.emulate.plants.plant import FULL_PWM, Ran
from gen.emulate.session import Event
from gen.errors import InputError
from gen.record.profile import Profile
from gen.rig import SENSOR_FAULTS, SensorFault
from gen.rig.signals import Signal
from gen.runs import read_run

_PRESS_S = 0.3
_OFF_S = 1.0


def parse_number(text: str, option: str, what: str) -> float:
    """Read a finite number.

    Raises
    ------
    InputError
        When it is none.
    """
    try:
        number = float(text)
    except ValueError:
        number = float("nan")
    if not np.isfinite(number):
        raise InputError(f'found "{text}", expected {what}', place=option)
    return number


def parse_signal(
    text: str, option: str, *, column: str, straight: bool, within: tuple[float, float] = (-inf, inf)
) -> Signal:
    """Read a quantity over time: ``30``, ``0:30,3600:32``, or a CSV with ``time_s``, ``pwm`` and a column.

    Parameters
    ----------
    text, option
        The option.
    column
        The CSV's column.
    straight
        Whether it moves in straight lines from time to time; else each value holds until the next time.
    within
        The least and the largest value that can be.

    Raises
    ------
    InputError
        When it is none of these.
    """
    if re.fullmatch(r"[-+\d.:,eE\s]+", text):
        if ":" not in text:
            number = parse_number(text, option, "a number, pairs time:value, or a CSV file")
            _check_within([number], within, option)
            return number
        pairs = [pair.split(":") for pair in text.split(",")]
        if any(len(pair) != 2 for pair in pairs):
            raise InputError(f'found "{text}", expected pairs such as 0:30,3600:32', place=option)
        times = [parse_number(pair[0], option, "a time in s") for pair in pairs]
        values = [parse_number(pair[1], option, "a number") for pair in pairs]
    else:
        path = Path(text)
        if not path.is_file():
            raise InputError(f'found "{text}", expected a number, pairs time:value, or a CSV file', place=option)
        run = read_run(path, ())
        measured = run.ambient if column == "ambient_degC" else run.extras.get(column)
        if measured is None:
            raise InputError(f"has no column {column}", file=text)
        known = ~np.isnan(measured)
        times, values = run.time_s[known].tolist(), measured[known].tolist()
    if not times or any(b <= a for a, b in pairwise(times)):
        raise InputError("expected times that grow", place=option)
    _check_within(values, within, option)
    if straight:
        return lambda t: float(np.interp(t, times, values))
    return lambda t: values[max(0, bisect_right(times, t) - 1)]


def _check_within(values: Sequence[float], within: tuple[float, float], option: str) -> None:
    low, high = within
    for value in values:
        if not low <= value <= high:
            raise InputError(f"found {value:g}, expected {low:g} to {high:g}", place=option)


def parse_start(text: str | None, parts: Collection[str]) -> dict[str, float] | Ran:
    """Read the temperatures at the start: ``brush=60,casing=50``, or ``PWM:SECONDS`` that the motor has run before.

    Parameters
    ----------
    text
        The option.
    parts
        Names of the motor's parts.

    Raises
    ------
    InputError
        When it is neither, or names a part that the motor does not have.
    """
    if text is None:
        return {}
    ran = re.fullmatch(r"(-?\d+):(\d+(?:\.\d*)?)", text)
    if ran:
        pwm, seconds = int(ran[1]), float(ran[2])
        if abs(pwm) > FULL_PWM or not seconds > 0.0:
            raise InputError(f'found "{text}", expected PWM -{FULL_PWM}..{FULL_PWM} and more than 0 s', place="--start")
        return Ran(pwm, seconds)
    start = {}
    for pair in text.split(","):
        name, equals, number = pair.partition("=")
        if not equals or name not in parts:
            raise InputError(
                f'found "{pair}", expected PWM:SECONDS or name=degC with one of {", ".join(parts)}', place="--start"
            )
        start[name] = parse_number(number, "--start", "a temperature in degC")
    return start


def parse_told(texts: tuple[str, ...]) -> dict[str, Signal]:
    """Read ``COLUMN=VALUE`` over time, any number of times; each value holds until the next.

    Raises
    ------
    InputError
        When one is of another form.
    """
    told: dict[str, Signal] = {}
    for text in texts:
        column, equals, signal = text.partition("=")
        if not equals or not column or column in told:
            raise InputError(f'found "{text}", expected COLUMN=VALUE, each column once', place="--channel")
        told[column] = parse_signal(signal, "--channel", column=column, straight=False)
    return told


def parse_sensor_faults(texts: tuple[str, ...], channels: list[str]) -> dict[str, tuple[SensorFault, ...]]:
    """Read ``CHANNEL:KIND:START:END[:SIZE]``, any number of times.

    Raises
    ------
    InputError
        When one is of another form, or its channel has no thermocouple.
    """
    option, faults = "--sensor-fault", dict[str, tuple[SensorFault, ...]]()
    for text in texts:
        parts = text.split(":")
        if len(parts) not in (4, 5):
            raise InputError(f'found "{text}", expected CHANNEL:KIND:START:END[:SIZE]', place=option)
        channel, kind = parts[:2]
        if channel not in channels:
            raise InputError(f'found "{channel}", expected one of {", ".join(channels)}', place=option)
        known = next((name for name in SENSOR_FAULTS if name == kind), None)
        if known is None:
            raise InputError(f'found "{kind}", expected one of {", ".join(SENSOR_FAULTS)}', place=option)
        start, end = (parse_number(part, option, "a time in s") for part in parts[2:4])
        if not 0.0 <= start < end:
            raise InputError(f'found "{text}", expected an end after the start', place=option)
        fault = SensorFault(known, start, end)
        if len(parts) == 5:
            fault = SensorFault(known, start, end, size_K=parse_number(parts[4], option, "a size in K"))
        faults[channel] = (*faults.get(channel, ()), fault)
    return faults


def parse_events(
    duration_s: float,
    *,
    button: tuple[str, ...] = (),
    reset: tuple[float, ...] = (),
    power_cut: tuple[str, ...] = (),
    brown_out: tuple[str, ...] = (),
    send: tuple[str, ...] = (),
    flood: tuple[str, ...] = (),
) -> list[Event]:
    """Read what happens to the board.

    Parameters
    ----------
    duration_s
        Length of the run, s; nothing may happen later.
    button, power_cut, brown_out, flood
        ``TIME`` or ``TIME:SECONDS``.
    reset
        Times.
    send
        ``TIME:TEXT``.

    Raises
    ------
    InputError
        When one is of another form.
    """
    events: list[Event] = []
    for text in button:
        at, hold = _time_and_length(text, "--button", _PRESS_S)
        events += [Event(at, "press"), Event(at + hold, "release")]
    events += [Event(at, "reset") for at in reset]
    events += [
        Event(at, "power_cut", off) for at, off in (_time_and_length(t, "--power-cut", _OFF_S) for t in power_cut)
    ]
    events += [Event(at, "brown_out", off) for at, off in (_time_and_length(t, "--brown-out", 0.01) for t in brown_out)]
    events += [Event(at, "flood", span) for at, span in (_time_and_length(t, "--flood", 1.0) for t in flood)]
    for text in send:
        time_text, colon, line = text.partition(":")
        if not colon or not line.isascii() or not line.isprintable():
            raise InputError(f'found "{text}", expected TIME:TEXT', place="--send")
        events.append(Event(parse_number(time_text, "--send", "a time in s"), "send", data=line.encode() + b"\n"))
    for event in events:
        if not 0.0 <= event.time_s < duration_s and event.kind != "release":
            raise InputError(
                f"found {event.kind} at {event.time_s:g} s, expected 0..{duration_s:g} s, the run's length",
                place="events",
            )
    return events


def check_profile(profile: Profile, duration_s: float) -> None:
    """Refuse a profile whose steps lie behind the run's end.

    Raises
    ------
    InputError
        When one does.
    """
    if profile and profile[-1][0] >= duration_s:
        raise InputError(
            f"its last step is at {profile[-1][0]:g} s, behind the run's end at {duration_s:g} s", place="--profile"
        )


def _time_and_length(text: str, option: str, default_s: float) -> tuple[float, float]:
    time_text, colon, length_text = text.partition(":")
    at = parse_number(time_text, option, "TIME or TIME:SECONDS")
    length = parse_number(length_text, option, "TIME or TIME:SECONDS") if colon else default_s
    if not length > 0.0:
        raise InputError(f'found "{text}", expected more than 0 s', place=option)
    return at, length
