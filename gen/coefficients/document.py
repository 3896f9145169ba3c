"""The coefficient document, format "gen-coefficients", version 1."""

from __future__ import annotations

import re
from typing import Annotated, Literal

from pydantic import Field, model_validator

from gen.coefficients.alarms import MOST_RULES, MOST_SAMPLES, AlarmRule, OverTemperature, window_counts
from gen.coefficients.base import Celsius, Counts, Name, Number, Part, Positive, fault, listed, ordered
from gen.coefficients.effects import EffectEntry, check_effects
from gen.coefficients.schedule import ScheduleEntry
from gen.coefficients.wiring import Wiring

SKETCH_FILES = frozenset(["board", "commands", "config", "console", "crc32", "device", "drive", "encoder"])
SKETCH_FILES |= {"channels", "indicator", "memory", "observer", "output", "selftest", "thermocouples"}
"""Headers of the emitted sketch; the model's own header would hide behind one of the same name."""

CountRange = tuple[Counts, Counts]
_EXTRA_COLUMN = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,25}_degC")
CelsiusRange = tuple[Celsius, Celsius]
ColumnName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=64)]


class Input(Part):
    """The model's input: the PWM command."""

    name: ColumnName
    full_scale: Annotated[int, Field(ge=1, le=255, description="The count that is 100 % (8-bit PWM).")]
    nominal_speed_rpm: Annotated[Positive, Field(description="Speed at full scale.")]


class Ambient(Part):
    """The ambient temperature: a fixed value, or a measured channel with the value as its fallback."""

    fixed_degC: Celsius | None = None
    channel: ColumnName | None = None

    @model_validator(mode="after")
    def _check(self) -> Ambient:
        if self.fixed_degC is None and self.channel is None:
            raise fault('found neither, expected "fixed_degC", "channel" or both')
        return self


class Validity(Part):
    """Where the schedules were identified."""

    pwm: Annotated[CountRange, Field(description="[lowest, highest] |PWM| in counts.")]
    outside: Annotated[
        Literal["extrapolate", "hold"],
        Field(description="hold: outside, gain and poles keep their value at the nearest end."),
    ]


class Domain(Part):
    """What the firmware has to stand; everything is proven for this domain."""

    pwm: Annotated[CountRange, Field(description="[lowest, highest] |PWM| in counts.")]
    ambient_degC: CelsiusRange
    temperature_degC: Annotated[CelsiusRange, Field(description="Measured and start temperatures.")]


class Accuracy(Part):
    """The largest guaranteed error in K with which a build is accepted."""

    fixed_limit_K: Positive = 1e-5
    float_limit_K: Positive = 1e-3
    fast_limit_K: Positive = 1e-4  # no longer used: files of version 1 may hold it

    def limit(self, arithmetic: str) -> tuple[float, str]:
        """Give the limit of one kind of build, K, and the name of its entry."""
        entry = f"{arithmetic}_limit_K"
        return float(getattr(self, entry)), entry


class PoleEntry(Part):
    """One pole in rad/s; without imag it is real."""

    real: ScheduleEntry
    imag: ScheduleEntry | None = None


class ComponentEntry(Part):
    """One component: rise T over ambient with A(d/dt) T = K |PWM|, A = real(poly(poles)), monic."""

    name: Name
    description: str = ""
    order: Annotated[int, Field(ge=1, le=4)]
    gain: Annotated[ScheduleEntry, Field(description="K in K/s^order per PWM count.")]
    negative_gain: Annotated[
        Literal["zero"] | None,
        Field(description="zero: where the gain is negative outside the validity range it is taken as 0."),
    ] = None
    poles: Annotated[tuple[PoleEntry, ...], Field(min_length=1, max_length=4, description="As many as the order.")]

    @model_validator(mode="after")
    def _check(self) -> ComponentEntry:
        if len(self.poles) != self.order:
            raise fault(f"found {len(self.poles)} pole(s), expected {self.order}, as many as the order", "poles")
        return self


class ErrorBand(Part):
    """What the model is known to be off by, in a range of PWM."""

    component: str
    pwm: CountRange
    model_minus_measured_K: Annotated[tuple[Number, Number], Field(description="[lowest, highest]")]
    note: str = ""

    @model_validator(mode="after")
    def _check(self) -> ErrorBand:
        ordered(*self.pwm, "pwm")
        ordered(*self.model_minus_measured_K, "model_minus_measured_K")
        return self


class Provenance(Part):
    """Where the numbers come from, and how good they are."""

    source: str
    method: str = ""
    data: tuple[str, ...] = ()
    fit: Annotated[
        dict[str, dict[str, Number]], Field(description="By component: figures of the fit, unit in the name.")
    ] = Field(default_factory=dict)
    error: tuple[ErrorBand, ...] = ()


class Document(Part):
    """A coefficient file."""

    format: Literal["gen-coefficients"]
    version: Literal[1]
    name: Name
    description: str = ""
    sample_time_s: Annotated[Positive, Field(le=3600)]
    input: Input
    ambient: Ambient
    validity: Validity
    domain: Domain
    accuracy: Accuracy = Accuracy()
    components: Annotated[tuple[ComponentEntry, ...], Field(min_length=1, max_length=16)]
    provenance: Provenance | None = None
    wiring: Wiring | None = None
    alarms: Annotated[tuple[AlarmRule, ...], Field(max_length=MOST_RULES)] = ()
    effects: Annotated[
        tuple[EffectEntry, ...], Field(max_length=32, description="What `gen refine` found, added to the components.")
    ] = ()

    @model_validator(mode="after")
    def _check(self) -> Document:
        if self.name.lower() in SKETCH_FILES:
            raise fault(f'"{self.name}" is the name of a file of the sketch; expected another name', "name")
        self._check_ranges()
        names = [component.name for component in self.components]
        _unique(names, "components")
        _unique([alarm.name for alarm in self.alarms], "alarms")
        self._check_references(names)
        return self

    def _check_ranges(self) -> None:
        ordered(*self.domain.pwm, "domain", "pwm")
        ordered(*self.validity.pwm, "validity", "pwm")
        ordered(*self.domain.ambient_degC, "domain", "ambient_degC")
        ordered(*self.domain.temperature_degC, "domain", "temperature_degC")
        _within(self.domain.pwm, (0, self.input.full_scale), "the input's full scale", "domain", "pwm")
        _within(self.validity.pwm, self.domain.pwm, "the domain", "validity", "pwm")
        fixed = self.ambient.fixed_degC
        if fixed is not None:
            _within((fixed, fixed), self.domain.ambient_degC, "the domain", "ambient", "fixed_degC")

    def _check_references(self, names: list[str]) -> None:
        for i, band in enumerate(self.provenance.error if self.provenance else ()):
            _known(band.component, names, "provenance", "error", i, "component")
            _within(
                band.pwm,
                (0, self.input.full_scale),
                "the input's full scale",
                "provenance",
                "error",
                i,
                "pwm",
            )
        for name in self.provenance.fit if self.provenance else ():
            _known(name, names, "provenance", "fit", name)
        check_effects(self.effects, names)
        self._check_thermocouples(names)
        self._check_columns(names)
        profile = self.wiring.drive.profile if self.wiring and self.wiring.drive else None
        for i, step in enumerate(profile.steps if profile else ()):
            full = self.input.full_scale
            place = ("wiring", "drive", "profile", "steps", i, "pwm")
            _within((step.pwm, step.pwm), (-full, full), "the input's full scale", *place)
        for i, alarm in enumerate(self.alarms):
            _known(alarm.component, names, "alarms", i, "component")
            self._check_window(alarm, "alarms", i)
            earlier = [rule.name for rule in self.alarms[:i]]
            for key in ("requires", "unless"):
                named = getattr(alarm, key)
                if named is not None and named not in earlier:
                    expected = listed(earlier) if earlier else "none, as this is the first rule"
                    raise fault(f'found "{named}", expected the name of an earlier rule ({expected})', "alarms", i, key)
            if not isinstance(alarm, OverTemperature) and alarm.relative_to is not None:
                others = [name for name in names if name != alarm.component]
                if alarm.relative_to not in others:
                    raise fault(
                        f'found "{alarm.relative_to}", expected the name of another component: {listed(others)}',
                        "alarms",
                        i,
                        "relative_to",
                    )
                if alarm.beyond == "error_band":
                    raise fault(
                        "error bands are of one component each; expected no relative_to beside them",
                        "alarms",
                        i,
                        "beyond",
                    )

    def _check_thermocouples(self, names: list[str]) -> None:
        wiring = self.wiring or Wiring()
        channels: set[str] = set()
        taken = {f"{name}{end}".lower() for name in (*names, "ambient") for end in ("_degC", "_model_degC")}
        taken |= {channel.column.lower() for channel in wiring.channels}
        taken |= {self.ambient.channel.lower()} if self.ambient.channel is not None else set()
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

    @property
    def thermocouple_columns(self) -> tuple[str, ...]:
        """Columns with a thermocouple of their own: they are neither a component nor the ambient."""
        known = {"ambient", *(component.name for component in self.components)}
        wired = self.wiring.thermocouples if self.wiring is not None else ()
        return tuple(thermocouple.channel for thermocouple in wired if thermocouple.channel not in known)

    def _check_columns(self, names: list[str]) -> None:
        """No column of the board's rows has another one's name."""
        wiring = self.wiring
        if wiring is None:
            return
        printed = wiring.printed_columns(names)
        if any(chip.channel == "ambient" for chip in wiring.thermocouples):
            ambient = self.ambient.channel or "ambient_degC"
            if ambient in printed:
                raise fault(f'"{ambient}" is another column of the board\'s rows', "ambient", "channel")
            printed.add(ambient)
        for i, channel in enumerate(wiring.channels):
            if channel.column in printed:
                at = ("wiring", "channels", i, "column")
                raise fault(f'"{channel.column}" is a column of the board\'s rows already; expected another name', *at)

    def _check_window(self, alarm: AlarmRule, *at: str | int) -> None:
        ordered(*alarm.speed_percent, *at, "speed_percent")
        if not window_counts(alarm, self.input.full_scale):
            low, high = alarm.speed_percent
            raise fault(f"found [{low:g}, {high:g}], which no whole PWM count lies in", *at, "speed_percent")
        for key in ("persistence_s", "settle_s"):
            longest = MOST_SAMPLES * self.sample_time_s
            if getattr(alarm, key) > longest:
                raise fault(f"found {getattr(alarm, key):g}, expected at most {longest:g}", *at, key)


def _unique(names: list[str], key: str) -> None:
    seen: dict[str, int] = {}
    for i, name in enumerate(names):
        first = seen.setdefault(name.lower(), i)
        if first != i:
            raise fault(
                f'"{name}" is taken by {key}[{first}] ("{names[first]}"); expected names that differ in more than case',
                key,
                i,
                "name",
            )


def _known(name: str, names: list[str], *at: str | int) -> None:
    if name not in names:
        raise fault(f'found "{name}", expected the name of a component: {listed(names)}', *at)


def _within(inner: tuple[float, float], outer: tuple[float, float], of: str, *at: str | int) -> None:
    if inner[0] < outer[0] or inner[1] > outer[1]:
        found = f"{inner[0]:g}" if inner[0] == inner[1] else f"[{inner[0]:g}, {inner[1]:g}]"
        raise fault(f"found {found}, expected it within {outer[0]:g}..{outer[1]:g}, {of}", *at)
