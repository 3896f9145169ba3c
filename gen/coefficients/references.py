"""What one part of the document says of another: names of components, columns, ranges of PWM."""

from __future__ import annotations

import re
from collections.abc import Sequence

from gen.coefficients.alarms import (
    MOST_SAMPLES,
    MOST_WEIGHT,
    AlarmRule,
    MissingHeat,
    ModelRule,
    OverTemperature,
    window_counts,
)
from gen.coefficients.base import fault, listed, ordered
from gen.coefficients.names import component_name_fault
from gen.coefficients.provenance import Provenance
from gen.coefficients.wiring import Wiring

_EXTRA_COLUMN = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,25}_degC")


def check_component_names(names: Sequence[str]) -> None:
    """Check that the components' names differ, from each other and from what the emitted library calls its own.

    Raises
    ------
    PydanticCustomError
        Here as below at the first fault; the path starts at the document.
    """
    _unique(names, "components")
    for name in names:
        if (taken := component_name_fault(name)) is not None:
            raise fault(taken)


def check_network_columns(columns: Sequence[str], names: Sequence[str], ambient: str | None) -> None:
    """Check that what a network's channels read is no column of a run with a meaning of its own, but for PWM."""
    taken = {"time_s", "flags", "sensors", "alarms", "protection", ambient or "ambient_degC"}
    taken |= {f"{name}{end}" for name in names for end in ("_degC", "_model_degC")}
    for i, column in enumerate(columns):
        if column in taken:
            at = ("network", "channels", i, "column")
            raise fault(f'"{column}" is a column of a run with a meaning of its own; expected another', *at)


def check_provenance(provenance: Provenance, names: list[str], full_scale: int) -> None:
    """Check error bands and figures against the components' names and the input's full scale."""
    for i, band in enumerate(provenance.error):
        _known(band.component, names, "provenance", "error", i, "component")
        within(band.pwm, (0, full_scale), "the input's full scale", "provenance", "error", i, "pwm")
    for name in provenance.fit:
        _known(name, names, "provenance", "fit", name)


def check_wiring_references(wiring: Wiring, names: list[str], ambient: str | None, full_scale: int) -> None:
    """Check channels, columns and the profile against the components' names, the ambient's column and full scale."""
    _check_thermocouples(wiring, names, ambient)
    _check_columns(wiring, names, ambient)
    _check_profile(wiring, full_scale)


def check_alarm_references(
    alarms: Sequence[AlarmRule], names: list[str], full_scale: int, sample_time_s: float
) -> None:
    """Check rules against the components' names, each other, the input's full scale and the sample time in s."""
    _unique([alarm.name for alarm in alarms], "alarms")
    for i, alarm in enumerate(alarms):
        _known(alarm.component, names, "alarms", i, "component")
        _check_window(alarm, i, full_scale, sample_time_s)
        _check_earlier(alarm, i, [rule.name for rule in alarms[:i]])
        _check_relative(alarm, i, names)
        _check_weights(alarm, i, names)


def check_thermistor_limits(alarms: Sequence[AlarmRule], wiring: Wiring) -> None:
    """Check that no limit is where a part's thermistor tells a temperature no more than coarsely, or not at all."""
    hottest = {one.channel: one.range_degC[1] for one in wiring.thermocouples if one.chip == "NTC"}
    for i, alarm in enumerate(alarms):
        if isinstance(alarm, OverTemperature) and alarm.limit_degC > hottest.get(alarm.component, alarm.limit_degC):
            raise fault(
                f"found {alarm.limit_degC:g}, expected at most {hottest[alarm.component]:.4g}: above it a step of the "
                "converter is more than 1 K of this part's NTC; a smaller series_ohm tells more of the heat",
                "alarms",
                i,
                "limit_degC",
            )


def _check_thermocouples(wiring: Wiring, names: list[str], ambient: str | None) -> None:
    """Each measures something else: a component, the ambient, or a column that is neither."""
    channels: set[str] = set()
    taken = {f"{name}{end}".lower() for name in (*names, "ambient") for end in ("_degC", "_model_degC")}
    taken |= {channel.column.lower() for channel in wiring.channels}
    taken |= {ambient.lower()} if ambient is not None else set()
    for i, thermocouple in enumerate(wiring.thermocouples):
        at = ("wiring", "thermocouples", i, "channel")
        channel = thermocouple.channel
        if channel not in names and not _EXTRA_COLUMN.fullmatch(channel):
            _known(channel, [*names, "ambient"], *at)
        if channel.lower() in channels:
            raise fault(f'"{channel}" has a thermocouple already; expected one each', *at)
        if channel not in names and channel.lower() in taken:
            raise fault(f'the column "{channel}" is taken already; expected another', *at)
        channels.add(channel.lower())


def _check_columns(wiring: Wiring, names: list[str], ambient: str | None) -> None:
    """No column of the board's rows has another one's name."""
    printed = wiring.printed_columns(names)
    if any(chip.channel == "ambient" for chip in wiring.thermocouples):
        column = ambient or "ambient_degC"
        if column in printed:
            raise fault(f'"{column}" is another column of the board\'s rows', "ambient", "channel")
        printed.add(column)
    for i, channel in enumerate(wiring.channels):
        if channel.column in printed:
            at = ("wiring", "channels", i, "column")
            raise fault(f'"{channel.column}" is a column of the board\'s rows already; expected another name', *at)


def _check_profile(wiring: Wiring, full_scale: int) -> None:
    profile = wiring.drive.profile if wiring.drive else None
    for i, step in enumerate(profile.steps if profile else ()):
        at = ("wiring", "drive", "profile", "steps", i, "pwm")
        within((step.pwm, step.pwm), (-full_scale, full_scale), "the input's full scale", *at)


def _check_window(alarm: AlarmRule, i: int, full_scale: int, sample_time_s: float) -> None:
    """Where in speed the rule is evaluated, and for how long it can wait."""
    ordered(*alarm.speed_percent, "alarms", i, "speed_percent")
    if not window_counts(alarm, full_scale):
        low, high = alarm.speed_percent
        raise fault(f"found [{low:g}, {high:g}], which no whole PWM count lies in", "alarms", i, "speed_percent")
    longest = MOST_SAMPLES * sample_time_s
    for key in ("persistence_s", "settle_s"):
        if getattr(alarm, key) > longest:
            raise fault(f"found {getattr(alarm, key):g}, expected at most {longest:g}", "alarms", i, key)


def _check_earlier(alarm: AlarmRule, i: int, earlier: list[str]) -> None:
    """A rule may wait for rules before it only, so that one pass decides all."""
    for key in ("requires", "unless"):
        named = getattr(alarm, key)
        if named is not None and named not in earlier:
            expected = listed(earlier) if earlier else "none, as this is the first rule"
            raise fault(f'found "{named}", expected the name of an earlier rule ({expected})', "alarms", i, key)


def _check_relative(alarm: AlarmRule, i: int, names: list[str]) -> None:
    if not isinstance(alarm, ModelRule) or alarm.relative_to is None:
        return
    others = [name for name in names if name != alarm.component]
    if alarm.relative_to not in others:
        expected = (
            f"the name of another component: {listed(others)}" if others else "none, as there is no other component"
        )
        raise fault(f'found "{alarm.relative_to}", expected {expected}', "alarms", i, "relative_to")
    if alarm.beyond == "error_band":
        raise fault("error bands are of one component each; expected no relative_to beside them", "alarms", i, "beyond")


def _check_weights(alarm: AlarmRule, i: int, names: list[str]) -> None:
    if not isinstance(alarm, MissingHeat) or alarm.weights is None:
        return
    for name, weight in alarm.weights.items():
        _known(name, names, "alarms", i, "weights")
        if weight == 0.0:
            raise fault("found 0, expected another number, or no weight", "alarms", i, "weights", name)
    if alarm.component not in alarm.weights:
        raise fault(f'expected a weight of "{alarm.component}", the rule\'s component', "alarms", i, "weights")
    together = sum(abs(weight) for weight in alarm.weights.values())
    if together > MOST_WEIGHT:
        raise fault(f"found {together:g} together, expected at most {MOST_WEIGHT:g}", "alarms", i, "weights")


def _unique(names: Sequence[str], key: str) -> None:
    seen: dict[str, int] = {}
    for i, name in enumerate(names):
        first = seen.setdefault(name.lower(), i)
        if first != i:
            raise fault(
                f'"{name}" is taken by {key}[{first}] ("{names[first]}"); expected names that differ in more than case',
                *(key, i, "name"),
            )


def _known(name: str, names: list[str], *at: str | int) -> None:
    if name not in names:
        raise fault(f'found "{name}", expected the name of a component: {listed(names)}', *at)


def within(inner: tuple[float, float], outer: tuple[float, float], of: str, *at: str | int) -> None:
    """Check that a range lies in another one; ``of`` says whose that is.

    Raises
    ------
    PydanticCustomError
        When it does not.
    """
    if inner[0] < outer[0] or inner[1] > outer[1]:
        found = f"{inner[0]:g}" if inner[0] == inner[1] else f"[{inner[0]:g}, {inner[1]:g}]"
        raise fault(f"found {found}, expected it within {outer[0]:g}..{outer[1]:g}, {of}", *at)
