"""What the board measures: thermocouples, the encoder, and channels beside them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from gen.coefficients.base import Celsius, Note, NotNegative, Part, Positive, fault
from gen.coefficients.wiring.pins import COUNTER_PIN, Pin
from gen.coefficients.wiring.thermistor import ENDS_degC, Thermistor
from gen.model.dynamics import MAX_PWM

ChipName = Literal["MAX6675", "MAX31855", "MAX31856", "MAX31865", "NTC"]
"""What turns a sensor's voltage or resistance into a word; a thermistor's is the board's own converter."""
CHIP_RANGES_degC: dict[str, tuple[float, float]] = {
    "MAX6675": (0.0, 1023.75),
    "MAX31855": (-270.0, 1372.0),
    "MAX31856": (-210.0, 1372.0),
    "MAX31865": (-200.0, 850.0),
    "NTC": ENDS_degC,
}
"""What the words of a chip can mean with a thermocouple of type K, a platinum resistor, or any thermistor."""
REGISTER_CHIPS = frozenset(["MAX31856", "MAX31865"])
"""Those that have to be told what to do, over a line of their own."""
SUPPLY_V = 5.0
"""What the converter compares voltages with."""
MOST_VALUE = 1e5
"""No channel's value is larger, in its unit."""
LEAST_PER_V = 1e-3
"""The board holds thousandths of the unit."""
_SPI = ("cs", "so", "sck")
_PLATINUM = ("rtd_ohm", "reference_ohm", "wires")
_DIVIDER = ("analog_pin", "r25_ohm", "beta_K", "steinhart_hart", "series_ohm", "thermistor_to")


class Thermocouple(Part):
    """One converter chip on bit-banged SPI, and what is plausible from it; a sample beyond that is not used."""

    channel: Annotated[
        str,
        Field(
            description='A component\'s name, "ambient", or a column that is neither, such as gearbox_degC: it is '
            "logged, and told to effects."
        ),
    ]
    cs: Annotated[Pin | None, Field(description="Of a chip; like so and sck needed unless it is an NTC.")] = None
    so: Pin | None = None
    sck: Pin | None = None
    chip: Annotated[
        ChipName,
        Field(
            description="MAX6675 (from 0 degC on) or MAX31855: thermocouple of type K. MAX31856: the same, with "
            "registers. MAX31865: platinum resistor. NTC: a thermistor on an analog pin, without a chip."
        ),
    ] = "MAX6675"
    sdi: Annotated[
        Pin | None, Field(description="Data to the chip, of a MAX31856 or MAX31865; like so and sck it may be shared.")
    ] = None
    rtd_ohm: Annotated[
        Literal[100, 1000] | None, Field(description="Of a MAX31865: PT100 or PT1000; without it 100.")
    ] = None
    reference_ohm: Annotated[
        float | None,
        Field(ge=100, le=100_000, description="Of a MAX31865: its reference resistor; without it 4.3 times rtd_ohm."),
    ] = None
    wires: Annotated[Literal[2, 3, 4] | None, Field(description="Of a MAX31865: to the resistor; without it 4.")] = None
    analog_pin: Annotated[
        Pin | None, Field(description="Of an NTC: A0 or one behind it, between the thermistor and its resistor.")
    ] = None
    r25_ohm: Annotated[float | None, Field(ge=100, le=1e6, description="Of an NTC: its resistance at 25 degC.")] = None
    beta_K: Annotated[
        float | None, Field(ge=1000, le=8000, description="Of an NTC, with r25_ohm: B of its data sheet.")
    ] = None
    steinhart_hart: Annotated[
        tuple[
            Annotated[float, Field(ge=-0.1, le=0.1)],
            Annotated[float, Field(ge=1e-5, le=1e-2)],
            Annotated[float, Field(ge=0, le=1e-5)],
        ]
        | None,
        Field(description="Of an NTC, instead of both: A, B, C of 1/T = A + B ln R + C (ln R)^3, in K and ohm."),
    ] = None
    series_ohm: Annotated[
        float | None, Field(ge=100, le=1e5, description="Of an NTC: the other resistor, on the supply's 5 V or ground.")
    ] = None
    thermistor_to: Annotated[
        Literal["ground", "supply"] | None,
        Field(description="Of an NTC: where its other end is; its resistor is at the other. Without it ground."),
    ] = None
    min_degC: Annotated[
        Celsius | None,
        Field(description="Lowest plausible temperature; without it the domain's lowest (ambient: 10 K less)."),
    ] = None
    max_degC: Annotated[
        Celsius | None,
        Field(
            description="Highest plausible temperature; without it 100 K over the domain's highest, so that an "
            "over-temperature is still seen (ambient: 10 K over).",
        ),
    ] = None
    max_rate_K_per_s: Annotated[
        Positive, Field(le=1000, description="A change faster than this, beyond 1 K of noise, is a jump.")
    ] = 5.0
    stuck_s: Annotated[
        Positive | None,
        Field(
            le=1e6,
            description="The same count for this long is a stuck sensor, provided that the model moved by stuck_K "
            "meanwhile. Without it 30 s; where there is no model (ambient, columns) there is no check.",
        ),
    ] = None
    stuck_K: Annotated[
        NotNegative | None,
        Field(
            le=1000,
            description="See stuck_s; 0: time alone decides. Without it 3 K; ambient and columns 0.",
        ),
    ] = None
    note: Note | None = None

    @model_validator(mode="after")
    def _check(self) -> Thermocouple:
        self._check_keys()
        lowest, highest = self.range_degC
        if self.max_degC is not None and not lowest < self.max_degC <= highest:
            raise fault(
                f"found {self.max_degC:g}, expected at most {highest:g}, which is where a {self.chip} ends", "max_degC"
            )
        if self.min_degC is not None and self.max_degC is not None and self.min_degC >= self.max_degC:
            raise fault(f"found {self.max_degC:g}, expected more than min_degC, which is {self.min_degC:g}", "max_degC")
        return self

    def _check_keys(self) -> None:
        """Each chip has the keys that it needs, and no other's."""
        is_ntc = self.chip == "NTC"
        for key in ("analog_pin", "series_ohm") if is_ntc else _SPI:
            if getattr(self, key) is None:
                raise fault(f'missing key "{key}"')
        for key in _SPI if is_ntc else _DIVIDER:
            if getattr(self, key) is not None:
                expected = "which has no such line; expected none" if is_ntc else "only an NTC has it"
                raise fault(f"the chip is {self._a_chip}: {expected}", key)
        if is_ntc:
            self._check_curve()
        if (self.sdi is None) == (self.chip in REGISTER_CHIPS):
            needs = "expected the pin of its SDI" if self.sdi is None else "which has no such line; expected none"
            raise fault(f"the chip is {self._a_chip}: {needs}", "sdi")
        for key in _PLATINUM:
            if getattr(self, key) is not None and self.chip != "MAX31865":
                raise fault(f"the chip is {self._a_chip}; only a MAX31865 measures a platinum resistor", key)

    def _check_curve(self) -> None:
        """The thermistor's curve is given once, and its divider tells temperatures."""
        if (self.r25_ohm is None) != (self.beta_K is None):
            raise fault('expected "r25_ohm" and "beta_K" together', "r25_ohm" if self.beta_K is None else "beta_K")
        if (self.r25_ohm is None) == (self.steinhart_hart is None):
            raise fault('expected either "r25_ohm" and "beta_K", or "steinhart_hart"')
        if self.thermistor.range_degC() is None:
            raise fault(
                f"found {self.series_ohm:g}: a step of the converter is more than 1 K at every temperature; expected "
                "about the thermistor's resistance where it matters",
                "series_ohm",
            )

    @property
    def _a_chip(self) -> str:
        return "an NTC" if self.chip == "NTC" else f"a {self.chip}"

    @property
    def thermistor(self) -> Thermistor:
        """Of an NTC: its curve and its divider."""
        assert self.series_ohm is not None
        to_supply = self.thermistor_to == "supply"
        if self.steinhart_hart is not None:
            return Thermistor(*self.steinhart_hart, self.series_ohm, to_supply)
        assert self.r25_ohm is not None and self.beta_K is not None
        return Thermistor.of_beta(self.r25_ohm, self.beta_K, self.series_ohm, to_supply=to_supply)

    @property
    def range_degC(self) -> tuple[float, float]:
        """What it can tell: of an NTC where a step of the converter is no more than 1 K."""
        own = self.thermistor.range_degC() if self.chip == "NTC" else None
        return CHIP_RANGES_degC[self.chip] if own is None else own

    @property
    def resistor_ohm(self) -> tuple[float, float]:
        """Of a MAX31865: the platinum resistor at 0 degC, and the reference, ohm."""
        platinum = float(self.rtd_ohm or 100)
        return platinum, 4.3 * platinum if self.reference_ohm is None else self.reference_ohm


class Encoder(Part):
    """Speed feedback."""

    pin: Pin
    pulses_per_revolution: Annotated[int, Field(ge=1, le=65535)]
    method: Annotated[
        Literal["interrupt", "counter"] | None,
        Field(
            description="counter: Timer 5 counts, on the Mega's pin 47 only. Without it: counter on pin 47, else "
            "interrupt."
        ),
    ] = None
    stall_pwm: Annotated[int, Field(ge=1, le=MAX_PWM, description="|PWM| from which on the motor must turn.")] = 51
    stall_s: Annotated[Positive, Field(le=3600, description="No pulse for this long at such a PWM is a stall.")] = 2.0
    note: Note | None = None

    @property
    def counts_in_hardware(self) -> bool:
        """Whether Timer 5 counts the pulses."""
        return self.method == "counter" or (self.method is None and self.pin == COUNTER_PIN)


class ChannelInput(Part):
    """What effects are told beside the PWM, and run files hold: a voltage, or a contact to ground."""

    column: Annotated[
        str,
        Field(
            pattern=r"^[A-Za-z][A-Za-z0-9_]{0,30}$",
            description="Its column in run files, the unit at the end: current_A.",
        ),
    ]
    analog_pin: Annotated[Pin | None, Field(description="A0 or one behind it: a voltage of 0..5 V.")] = None
    contact_pin: Annotated[Pin | None, Field(description="1 while it is closed to ground, else 0.")] = None
    zero_V: Annotated[float, Field(ge=-5, le=10, description="Voltage at which the value is 0.")] = 0.0
    per_V: Annotated[float, Field(description="Change of the value for each volt, in its unit.")] = 1.0
    min: Annotated[float | None, Field(description="Lowest plausible value; without it the one at 0 V.")] = None
    max: Annotated[float | None, Field(description="Highest plausible value; without it the one at 5 V.")] = None
    note: Note | None = None

    @property
    def limits(self) -> tuple[float, float]:
        """The plausible range, in the unit."""
        if self.contact_pin is not None:
            return 0.0, 1.0
        ends = sorted(self.per_V * (volts - self.zero_V) for volts in (0.0, SUPPLY_V))
        return ends[0] if self.min is None else self.min, ends[1] if self.max is None else self.max

    @model_validator(mode="after")
    def _check(self) -> ChannelInput:
        if (self.analog_pin is None) == (self.contact_pin is None):
            raise fault('expected either "analog_pin" or "contact_pin"')
        if not LEAST_PER_V <= abs(self.per_V) <= MOST_VALUE:
            raise fault(
                f"found {self.per_V:g}, expected {LEAST_PER_V:g}..{MOST_VALUE:g}, or the same below zero", "per_V"
            )
        low, high = self.limits
        if not -MOST_VALUE <= low < high <= MOST_VALUE:
            raise fault(
                f"found a range of {low:g}..{high:g}, expected one within -{MOST_VALUE:g}..{MOST_VALUE:g}", "max"
            )
        return self
