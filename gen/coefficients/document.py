"""The coefficient document, format "gen-coefficients", version 2."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field, model_validator
from pydantic.config import JsonDict

from gen.coefficients.alarms import MOST_RULES, AlarmRule
from gen.coefficients.base import Celsius, ColumnName, CountRange, Name, Part, Positive, fault, ordered
from gen.coefficients.checks.protection_checks import check_protection
from gen.coefficients.effects import EffectEntry, check_effects
from gen.coefficients.forecast import Forecast, check_forecast
from gen.coefficients.network import NetworkEntry
from gen.coefficients.protection import MOST_PROTECTIONS, Protection
from gen.coefficients.provenance import Provenance
from gen.coefficients.references import (
    check_alarm_references,
    check_component_names,
    check_network_columns,
    check_provenance,
    check_thermistor_limits,
    check_wiring_references,
    within,
)
from gen.coefficients.schedule import ScheduleEntry
from gen.coefficients.wiring import BoardName, Wiring
from gen.model.dynamics import MAX_PWM

SKETCH_FILES = frozenset(
    [
        "board",
        "channels",
        "commands",
        "commissioned",
        "commissioning",
        "commissioning_words",
        "config",
        "console",
        "converter",
        "cpu",
        "crc32",
        "device",
        "drive",
        "encoder",
        "guard",
        "indicator",
        "latch",
        "memory",
        "observer",
        "oscillator",
        "output",
        "relay",
        "selftest",
        "snapshot",
        "supply",
        "thermocouples",
        "warm",
        "writing",
        "zero",
    ]
)
"""Headers of the emitted sketch; the model's own header would hide behind one of the same name."""

CelsiusRange = tuple[Celsius, Celsius]


class StandsFor(Part):
    """What the PWM counts stand for where the runs were driven by another quantity: current, power, throttle, speed."""

    quantity: Annotated[str, Field(min_length=1, max_length=200, description="Its name, as the log has it.")]
    unit: Annotated[str, Field(min_length=1, max_length=40, description="Of its values.")]
    full_scale: Annotated[Positive, Field(description="Its value at the input's full scale, in that unit.")]
    rest: Annotated[
        Annotated[float, Field(allow_inf_nan=False)] | None,
        Field(description="Its value at 0 counts, in that unit (4 of 4 to 20 mA); left out: 0."),
    ] = None

    @model_validator(mode="after")
    def _check(self) -> StandsFor:
        if self.rest is not None and self.rest >= self.full_scale:
            raise fault(f"found {self.rest:g}, expected less than the full scale of {self.full_scale:g}", "rest")
        for key, text in (("quantity", self.quantity), ("unit", self.unit)):
            if not text.isprintable() or not text.strip():
                raise fault(f"found {text!r}, expected words on one line", key)
        return self


class Input(Part):
    """The model's input: the PWM command."""

    name: ColumnName
    full_scale: Annotated[int, Field(ge=1, le=MAX_PWM, description="The count that is 100 % (8-bit PWM).")]
    nominal_speed_rpm: Annotated[Positive, Field(description="Speed at full scale.")]
    stands_for: Annotated[
        StandsFor | None, Field(description="What the counts stand for; left out: they are a motor's PWM.")
    ] = None

    @property
    def meaning(self) -> str:
        """What the counts stand for, in words for those who read what is made of the file; empty: a motor's PWM."""
        told = self.stands_for
        if told is None:
            return ""
        rest = f", 0 counts = {told.rest:g}" if told.rest else ""
        return f"{told.quantity}: {self.full_scale} counts = {told.full_scale:g} {told.unit}{rest}"


class Ambient(Part):
    """The ambient temperature: a fixed value, or a measured channel with the value as its fallback."""

    fixed_degC: Celsius | None = None
    channel: ColumnName | None = None
    at_once: Annotated[
        bool | None,
        Field(description="Components follow a change of the ambient at once, and not with their own dynamics."),
    ] = None

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
        Field(description="hold: outside, schedules and curves keep their value at the nearest end."),
    ]


class Domain(Part):
    """What the firmware has to stand; everything is proven for this domain."""

    pwm: Annotated[CountRange, Field(description="[lowest, highest] |PWM| in counts.")]
    ambient_degC: CelsiusRange
    temperature_degC: Annotated[CelsiusRange, Field(description="Measured and start temperatures.")]


class Accuracy(Part):
    """The largest guaranteed error in K with which a build is accepted, and what becomes of one without a guarantee."""

    fixed_limit_K: Positive = 1e-5
    float_limit_K: Positive = 1e-3
    unproven: Annotated[
        Literal["refuse", "saturate"],
        Field(description="saturate: a component of which nothing can be proven is built; its additions saturate."),
    ] = "refuse"
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


_EITHER: JsonDict = {
    "oneOf": [
        {"required": ["components"], "properties": {"network": {"type": "null"}}},
        {"required": ["network"], "properties": {"network": {"type": "object"}}, "not": {"required": ["components"]}},
    ]
}
"""What the published schema says of the two kinds of model."""


class Document(Part):
    """A coefficient file."""

    model_config = ConfigDict(json_schema_extra=_EITHER)

    format: Literal["gen-coefficients"]
    version: Literal[2]
    name: Name
    description: str = ""
    sample_time_s: Annotated[Positive, Field(le=3600)]
    input: Input
    ambient: Ambient
    validity: Validity
    domain: Domain
    accuracy: Accuracy = Accuracy()
    components: Annotated[
        tuple[ComponentEntry, ...], Field(min_length=1, max_length=16, description="The parts by transfer functions.")
    ] = ()
    network: Annotated[NetworkEntry | None, Field(description="Or the motor as one network.")] = None
    provenance: Provenance | None = None
    wiring: Wiring | None = None
    alarms: Annotated[tuple[AlarmRule, ...], Field(max_length=MOST_RULES)] = ()
    protection: Annotated[
        tuple[Protection, ...],
        Field(
            max_length=MOST_PROTECTIONS,
            description="Causes and actions; those that are not named have defaults where a motor is driven.",
        ),
    ] = ()
    forecast: Annotated[
        Forecast | None, Field(description="How long the motor may run on at its PWM, and which PWM it can hold.")
    ] = None
    effects: Annotated[
        tuple[EffectEntry, ...], Field(max_length=32, description="What `gen refine` found, added to the components.")
    ] = ()

    @model_validator(mode="after")
    def _check(self) -> Document:
        if self.name.lower() in SKETCH_FILES:
            raise fault(f'"{self.name}" is the name of a file of the sketch; expected another name', "name")
        self._check_model()
        self._check_ranges()
        self._check_references()
        return self

    def _check_model(self) -> None:
        if (self.network is None) == (not self.components):
            found = "neither" if self.network is None else "both"
            raise fault(f'found {found}, expected one of "components" and "network"')
        if self.network is None:
            return
        if self.ambient.at_once is not None:
            raise fault('a network\'s ambient acts through its paths; expected no "at_once"', "ambient", "at_once")
        if self.effects:
            raise fault('a network holds effects as its own terms; expected no "effects" beside it', "effects")
        if self.accuracy.unproven != "refuse":
            raise fault("a network is built with a guarantee or not at all", "accuracy", "unproven")

    @property
    def board(self) -> BoardName:
        """The board that the firmware is for; without wiring the Mega."""
        return self.wiring.board if self.wiring is not None else "mega"

    @property
    def component_names(self) -> list[str]:
        """Names of the components, or of the network's nodes that have a sensor."""
        if self.network is not None:
            return [node.name for node in self.network.nodes if node.sensor is not None]
        return [component.name for component in self.components]

    def _check_ranges(self) -> None:
        ordered(*self.domain.pwm, "domain", "pwm")
        ordered(*self.validity.pwm, "validity", "pwm")
        ordered(*self.domain.ambient_degC, "domain", "ambient_degC")
        ordered(*self.domain.temperature_degC, "domain", "temperature_degC")
        within(self.domain.pwm, (0, self.input.full_scale), "the input's full scale", "domain", "pwm")
        within(self.validity.pwm, self.domain.pwm, "the domain", "validity", "pwm")
        fixed = self.ambient.fixed_degC
        if fixed is not None:
            within((fixed, fixed), self.domain.ambient_degC, "the domain", "ambient", "fixed_degC")

    def _check_references(self) -> None:
        names = self.component_names
        full_scale = self.input.full_scale
        check_component_names(names)
        if self.network is not None:
            columns = [channel.column for channel in self.network.channels]
            check_network_columns(columns, names, self.ambient.channel)
        if self.provenance is not None:
            check_provenance(self.provenance, names, full_scale)
        check_effects(self.effects, names)
        if self.wiring is not None:
            check_wiring_references(self.wiring, names, self.ambient.channel, full_scale)
            self._check_zero(self.wiring)
        check_alarm_references(self.alarms, names, full_scale, self.sample_time_s)
        if self.wiring is not None:
            check_thermistor_limits(self.alarms, self.wiring)
        check_protection(
            self.protection,
            self.alarms,
            self.wiring,
            full_scale,
            self.sample_time_s,
            forecast=self.forecast,
            commissions=self._commissions,
        )
        if self.forecast is not None:
            nodes = self.network.nodes if self.network is not None else ()
            parts = dict.fromkeys([*names, *(node.name for node in nodes)])
            check_forecast(self.forecast, self.alarms, list(parts), self.sample_time_s)

    def _check_zero(self, wiring: Wiring) -> None:
        """What is learnt at a cold start needs something to compare, and a place to stay."""
        if wiring.zero is None:
            return
        if not self._commissions:
            raise fault('found it without "memory", or without a thermocouple at a part', "wiring", "zero")
        if all(chip.channel != "ambient" for chip in wiring.thermocouples):
            raise fault("found it without a thermocouple at the ambient, which says what cold is", "wiring", "zero")

    @property
    def _commissions(self) -> bool:
        """Whether the board can be commissioned: it has thermocouples to tell apart, and keeps what was found."""
        if self.wiring is None or self.wiring.memory is None:
            return False
        return any(chip.channel in self.component_names for chip in self.wiring.thermocouples)

    @property
    def thermocouple_columns(self) -> tuple[str, ...]:
        """Columns with a thermocouple of their own: they are neither a component nor the ambient."""
        known = {"ambient", *self.component_names}
        wired = self.wiring.thermocouples if self.wiring is not None else ()
        return tuple(thermocouple.channel for thermocouple in wired if thermocouple.channel not in known)
