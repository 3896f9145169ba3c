"""Units as people write them: in a header, in a row below it, behind a number, in an option."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from functools import lru_cache

TEMPERATURE, CURRENT, VOLTAGE, SPEED, TIME, SHARE, COUNTS, POWER, OTHER = (
    "temperature",
    "current",
    "voltage",
    "speed",
    "time",
    "share",
    "counts",
    "power",
    "other",
)


@dataclass(frozen=True)
class Unit:
    """What a number of this unit is in the unit that run files have.

    Parameters
    ----------
    quantity
        What is measured.
    name
        The unit's plain name, as options and mapping files have it.
    target
        The unit of run files: ``value * scale + offset`` is in it.
    scale, offset
        Of that.
    """

    quantity: str
    name: str
    target: str
    scale: float = 1.0
    offset: float = 0.0


DEGC = Unit(TEMPERATURE, "degC", "degC")
DEGF = Unit(TEMPERATURE, "degF", "degC", 1.0 / 1.8, -32.0 / 1.8)
KELVIN = Unit(TEMPERATURE, "K", "degC", 1.0, -273.15)
PERCENT = Unit(SHARE, "percent", "percent")
PERMILLE = Unit(SHARE, "permille", "percent", 0.1)
DUTY = Unit(SHARE, "duty", "percent", 100.0)
PWM_COUNTS = Unit(COUNTS, "counts", "counts")

_SPELT: dict[Unit, str] = {
    DEGC: "degc degreec degreesc degreecelsius degreescelsius degcelsius "
    "°c c celsius ℃ grad gradc deg ºc 'c *c @c c° ˚c ∘c â°c �c °cel gradcelsius gr.c "
    "celcius centigrade",
    DEGF: "degf degreef degreesf degreefahrenheit degreesfahrenheit degfahrenheit "
    "°f f fahrenheit 'f ℉ gradf ºf *f @f f° ˚f ∘f â°f �f fahr",
    KELVIN: "k kelvin degk °k",
    Unit(CURRENT, "A", "A"): "a amp amps ampere amperes",
    Unit(CURRENT, "mA", "A", 1e-3): "ma milliamp milliamps",
    Unit(VOLTAGE, "V", "V"): "v volt volts vdc",
    Unit(VOLTAGE, "mV", "V", 1e-3): "mv millivolt millivolts",
    Unit(
        SPEED, "rpm", "rpm"
    ): "rpm 1/min u/min min-1 min^-1 min⁻¹ /min r/min rev/min upm r.p.m tr/min tr/mn giri/min omw/min umdr/min",
    Unit(SPEED, "rps", "rpm", 60.0): "rps 1/s u/s s-1 s^-1 r/s rev/s",
    Unit(SPEED, "rad/s", "rpm", 9.549296585513721): "rad/s rads",
    Unit(TIME, "s", "s"): "s sec secs second seconds sek sekunden sekunde secondes secondi segundos seconden",
    Unit(TIME, "ms", "s", 1e-3): "ms msec msecs millis millisecond milliseconds millisekunden",
    Unit(TIME, "us", "s", 1e-6): "us µs μs usec micros microseconds mikrosekunden",
    Unit(TIME, "ns", "s", 1e-9): "ns nanoseconds",
    Unit(TIME, "min", "s", 60.0): "min mins minute minutes minuten minuti minutos",
    Unit(TIME, "h", "s", 3600.0): "h hr hrs hour hours std stunden heures horas uur",
    Unit(TIME, "d", "s", 86400.0): "d day days tage",
    PERCENT: "% percent pct prozent perc",
    PERMILLE: "‰ permille promille",
    DUTY: "duty 0..1 0-1 0…1 fraction",
    PWM_COUNTS: "counts count cnt raw 0..255 0-255 lsb digits",
    Unit(POWER, "W", "W"): "w watt watts",
    Unit(POWER, "kW", "W", 1e3): "kw kilowatt",
    Unit(OTHER, "Nm", "Nm"): "nm n·m n*m",
}
_KNOWN = {spelling: unit for unit, text in _SPELT.items() for spelling in text.split()}
_FACTOR = re.compile(r"([+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?)\s*\*?\s*(.+)", re.ASCII)
_SHARE = re.compile(r"(?:(?P<over>1\s*/\s*\d+)\s*(?P<of>\D.*)|(?P<whole>\D.*?)\s*/\s*(?P<by>10{1,3}))", re.ASCII)
"""Tenths of a unit: `1/10 °C`, `°C/10`."""
_PREFIXED = re.compile(r"(?P<prefix>[Mm]illi|[Cc]enti|[Dd]eci|[mcd])[ -]?(?P<unit>(?i:deg ?c|°c|celsius|kelvin)|K)")
_PREFIXES = {"m": "0.001", "c": "0.01", "d": "0.1"}
_BRACKETED = re.compile(r"^(?P<base>.*?)\s*[\(\[<{](?P<unit>[^\)\]>}]*)[\)\]>}]\s*(?P<after>.*)$")
_BRACKETED_FROM = re.compile(r"[\(\[<{](?P<unit>[^\)\]>}]*)[\)\]>}]")
_SPOKEN = re.compile(r"^(?P<base>.*\S)\s*(?:\s(?:in|/)\s|,\s+|\s*/\s*)(?P<unit>\S+)$", re.IGNORECASE)
_LABEL = re.compile(r"(?:^|[,;]\s*)(?:LBL|label|name)\s*[:=]\s*(?P<label>[^,;]*[^,;\s])", re.IGNORECASE)
_SENSOR = re.compile(r"SEN S/N\s*:\s*(?P<number>[\w-]+)")
_UNIT_FIRST = re.compile(r"(?P<unit>°\s?[CFK]|℃|℉|%) (?:\[[\w.-]+\] ?)?(?P<base>\S.*)")
"""`°C [1-1] Winding`: a testo's unit, channel and name."""
_SPELT_LAST = re.compile(
    r"(?P<base>.*[A-Za-z])(?:[._ ]?(?P<word>(?i:celsius|fahrenheit|kelvin|deg[CF])|(?<=[a-z])(?:Pct|Percent))|"
    r"(?<=emp)(?P<letter>[CFK])|"
    r"(?<=emperature)(?P<full>[CFK])|(?<=ime|sed|amp)(?P<time>Ms|MS|Millis|Us|US|Micros|Secs?|Seconds|Mins?|Minutes|Hours))"
)
"""A unit with nothing before it but a capital, or a point: `tempF`, `winding.fahrenheit`, `windingDegC`, `TimeUS`."""
_FOREIGN = (
    "dba db dbm um µm μm mm cm m in inch mil %rh rh %r.h. %rf adc bit bits mt t gauss kg n kn mn va kva "
    "var kvar mω ω ohm ohms kohm mohm kω pa hpa kpa mpa mbar bar psi torr hz khz mhz j kj wh kwh ah mah "
    "µh uh mh µf uf nf pf wb mwb lux lx lm cd ticks a.u. au arb p.u. pu eu - ppm ppb µg/m³ µg/m3 kg/m3 "
    "kg/m³ g/m3 g/m³ m/s mm/s m/s2 m/s² l/min l/h m3/h m³/h lpm cfm sccm rad mrad steps pulses s/m µs/cm "
    "n·m w/m2 w/m² g/s kg/s kg/h "
)
"""Units of what is no temperature, input or time: no part's reading that has one is in degrees."""
_ANY_DEGREES = frozenset({"deg", "°", "degree", "degrees", "°ré", "°re", "°r", "grad", "grade"})
_ALONE = {"deg", "count", "raw", "digits", "d", "min", "cnt", "duty", "perc", "fraction", "grad"}
"""No units where they only stand behind an underscore or a stroke: `cell_count`, `T_min`, `motor/duty`."""


def is_foreign(text: str) -> bool:
    """Whether a text is a unit of something that is no temperature, input or time."""
    return text.strip().casefold() in _FOREIGN.split()


def is_any_degree(text: str) -> bool:
    """Whether a text says degrees, and not of what."""
    return text.strip().casefold() in _ANY_DEGREES


@lru_cache(maxsize=4096)
def unit_of(text: str) -> Unit | None:
    """The unit that a text names, or None; ``0.25degC`` is a count of a quarter degree.

    Parameters
    ----------
    text
        As in a header or an option.
    """
    spelt = re.sub(r"[\s_]+", "", text.strip().strip("[]()<>{}")).replace("deg.", "deg").casefold()
    if spelt in _KNOWN or spelt.rstrip(".") in _KNOWN:
        return _KNOWN.get(spelt) or _KNOWN[spelt.rstrip(".")]
    scaled = _FACTOR.fullmatch(_with_factor(text.strip().strip("[]()<>{}")))
    if scaled and (unit := unit_of(scaled[2])) and _FACTOR.fullmatch(scaled[2]) is None:
        factor = float(scaled[1])
        if factor:
            return Unit(unit.quantity, f"{scaled[1]}{unit.name}", unit.target, unit.scale * factor, unit.offset)
    return None


def _with_factor(text: str) -> str:
    """A factor before its unit, however a part of one was written: `1/10 °C`, `°C/10`, `0,1 °C`, `m°C`."""
    share = _SHARE.fullmatch(text)
    if share:
        digits = re.sub(r"\D", "", share["over"][1:]) if share["over"] else share["by"]
        return f"{1.0 / float(digits):g} {share['of'] or share['whole']}" if float(digits) else text
    prefixed = _PREFIXED.fullmatch(text)
    if prefixed:
        return f"{_PREFIXES[prefixed['prefix'][0].lower()]} {prefixed['unit']}"
    return re.sub(r"^(\d+),(\d+)(?=\D)", r"\1.\2", text)


def _last_unit(text: str) -> re.Match[str] | None:
    """The last pair of brackets that holds a unit: `Core Temperatures (avg) [°C]`."""
    found = [
        match
        for at in range(len(text))
        if text[at] in "([<{" and (match := _BRACKETED_FROM.match(text, at)) and unit_of(match["unit"])
    ]
    if not found:
        return None
    at = found[-1].start()
    return re.match(rf"^(?P<base>.{{{at}}})[\(\[<{{](?P<unit>[^\)\]>}}]*)[\)\]>}}]\s*(?P<after>.*)$", text)


def _labelled(before: str, within: str) -> tuple[str, Unit, str] | None:
    """`Temp, °F (LGR S/N: 123, LBL: Winding)`: a unit before brackets that say which sensor; its label is the name."""
    spoken = _SPOKEN.match(before.strip())
    unit = unit_of(spoken["unit"]) if spoken else None
    if spoken is None or unit is None:
        return None
    label, sensor = _LABEL.search(within), _SENSOR.search(within)
    if label:
        return label["label"].strip(), unit, spoken["unit"]
    return f"{spoken['base']} {sensor['number'] if sensor else within}".strip(), unit, spoken["unit"]


def split_name(header: str) -> tuple[str, Unit | None, str]:
    """Part a column's name from the unit in it.

    Parameters
    ----------
    header
        ``Winding Temp (°C)``, ``I [mA]``, ``T1_degF``, ``t / s``.

    Returns
    -------
    base
        The name without the unit.
    unit
        What was recognised, or None.
    written
        The unit as it was written, recognised or not; empty without one.
    """
    text = unicodedata.normalize("NFC", header.strip())  # an accent may be a letter of its own
    before = _UNIT_FIRST.fullmatch(text)
    if before:
        return before["base"], unit_of(before["unit"]), before["unit"]
    bracketed = _last_unit(text) or _BRACKETED.match(text)
    labelled = _labelled(bracketed["base"], bracketed["unit"]) if bracketed and not unit_of(bracketed["unit"]) else None
    if labelled is not None:
        return labelled
    of_a_device = bracketed and not bracketed["base"] and unit_of(bracketed["unit"]) is None
    if bracketed and of_a_device and bracketed["after"] and not is_foreign(bracketed["unit"]):  # `[PLC]Drive.DutyPct`
        return split_name(bracketed["after"])
    if bracketed and (bracketed["base"] or bracketed["after"]):
        base = f"{bracketed['base'].strip()} {bracketed['after']}".strip()
        return base, unit_of(bracketed["unit"]), bracketed["unit"].strip()
    spoken = _SPOKEN.match(text)
    path = spoken is not None and spoken["unit"].casefold() in _ALONE and f"/{spoken['unit']}" in text  # of a topic
    if spoken and not path and (unit := unit_of(spoken["unit"])):
        return spoken["base"], unit, spoken["unit"]
    degrees = re.fullmatch(r"(.+?)[\s_]*((?:Â?°|[˚º∘\ufffd])\s?[CFK]|℃|℉|[%‰])", text)
    if degrees:
        return degrees[1], unit_of(degrees[2]), degrees[2]
    spelt = _SPELT_LAST.fullmatch(text)
    written = (spelt["word"] or spelt["letter"] or spelt["full"] or spelt["time"]) if spelt else ""
    if spelt and (unit := unit_of(written)):
        return spelt["base"], unit, written
    parts = re.split(r"[_\s]+", text)
    for count in (2, 1):  # `deg_C` is two of them
        if len(parts) <= count:
            continue
        written = "".join(parts[-count:])
        unit = unit_of(written)
        if unit is not None and written.casefold() not in _ALONE and not written[0].isdigit():
            base = re.split(r"[_\s]+(?=" + r"[_\s]+".join(map(re.escape, parts[-count:])) + "$)", text)[0]
            return base, unit, written
    return text, None, ""
