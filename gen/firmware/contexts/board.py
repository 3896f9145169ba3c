"""What the templates of the sketch are told about the board: pins, limits in the board's units, JSON paths."""

from __future__ import annotations

from typing import TypedDict

from gen.firmware.alarm_text import AlarmText


class Pin(TypedDict):
    """A pin: its Arduino number and label, its port's letter and bit, the JSON path of where it was given."""

    pin: int
    label: str
    letter: str
    bit: int
    path: str


class ThermocoupleContext(TypedDict):
    """A sensor with its chip; limits are in counts of 0.25 degC, `component` is None where none has the channel.

    `platinum` is the number of its table, `configuration` what its first register holds (a MAX31865's).
    """

    number: int
    channel: str
    component: int | None
    column: bool
    told: str | None
    lines: dict[str, Pin]
    converter: str
    platinum: int
    configuration: str
    resistors: str
    lowest: int
    highest: int
    lowest_degC: str
    highest_degC: str
    step: int
    max_rate: str
    stuck_samples: int
    stuck_mK: int
    stuck_text: str


class InputContext(Pin):
    """A voltage or a contact: zero + (sum of conversions times scale >> shift), in thousandths."""

    number: int
    column: str
    analog: bool
    mux: int
    zero: int
    scale: int
    shift: int
    low: int
    high: int
    neutral: int
    told: str | None


class EncoderContext(Pin):
    """Speed feedback; `factor` turns pulses in a time of `unit_us` into revolutions per minute."""

    counter: bool
    interrupt: int | None
    pulses_per_revolution: int
    shift: int
    unit_us: int
    factor: int
    most: int
    wide: bool
    limit: int
    fastest_rpm: int
    shortest_us: int
    overspeed_rpm: int
    turning_rpm: int
    stall_pwm: int
    stall_samples: int
    stall_s: str


class Timer(TypedDict):
    """A timer that makes PWM, what it runs with, and on which of the driver's lines."""

    number: int
    runs: str
    lines: list[str]


class ProfileStep(TypedDict):
    """A step of the built-in profile."""

    samples: int
    pwm: int
    s: str


class DriveContext(TypedDict):
    """The motor's driver: a PWM input for each direction, or one with a direction input."""

    forward: Pin | None
    reverse: Pin | None
    pwm: Pin | None
    direction: Pin | None
    forward_high: bool
    timers: list[Timer]
    pause_samples: int
    ramp_step: int
    steps: list[ProfileStep]
    repeat: bool
    autostart: bool


class ObserveContext(TypedDict):
    """Pins on which another controller's PWM is measured."""

    forward: Pin
    reverse: Pin | None


class MemoryContext(TypedDict):
    """Copies of the states in EEPROM."""

    cycles: str
    identity: str
    record_bytes: int
    slots: int
    firmware_at: int
    interval_samples: int
    interval_s: str
    tolerance_counts: int
    tolerance_K: str
    years: str


class LatchContext(TypedDict):
    """Where the latched alarms lie in EEPROM."""

    at: int
    slots: int
    bytes: int


class SensorsContext(TypedDict):
    """The thermocouples, and the checks of their samples.

    `measured` are those at a component, `column_chips` those whose temperature is a column of its own, `ambient_chip`
    the one of the surroundings. `kinds` are the chips that there are, `platinum_tables` counts at every 1024th code of
    a MAX31865, `platinum_range` where they end.
    """

    chips: list[ThermocoupleContext]
    measured: list[ThermocoupleContext]
    column_chips: list[ThermocoupleContext]
    ambient_chip: ThermocoupleContext | None
    read_samples: int
    reading_ms: int
    conversion_ms: int
    conversion_millis: int
    confirmations: int
    plausible_samples: int
    faster: int
    noise_counts: int
    longest_samples: int
    kinds: list[str]
    platinum_tables: list[tuple[int, ...]]
    platinum_bits: int
    platinum_range: tuple[int, int]
    count_mK: int


class InputsContext(TypedDict):
    """Voltages and contacts; `conversions` make a voltage, `didr` turns its pins' digital inputs off.

    `told_pwm` is the channel's name in the C++ where a network reads PWM with its sign.
    """

    channels: list[InputContext]
    analog: list[InputContext]
    contacts: list[InputContext]
    told_pwm: str | None
    conversions: int
    settling: int
    didr: list[int]


class RowsContext(TypedDict):
    """The rows of the console's log and the buffer that they leave from."""

    row_samples: int
    row_every: str
    columns: list[str]
    row_bytes: int
    ring_bytes: int
    ambient_column: str


class DeviceContext(SensorsContext, InputsContext, RowsContext):
    """The whole sketch; a part that is not wired is empty or None."""

    cold_mK: int
    baud: int
    late_ms: int
    start_samples: int
    start_s: str
    led: int | None
    button: int | None
    encoder: EncoderContext | None
    drive: DriveContext | None
    observe: ObserveContext | None
    memory: MemoryContext | None
    latch: LatchContext | None
    relay: Pin | None
    protects: bool
    timeout_samples: int
    idle_timers: list[int]
    alarms: list[str]
    alarm_texts: tuple[AlarmText, ...]
