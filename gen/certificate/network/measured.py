"""What is found by running the emitted C++ of a network on every input: factors, starts, readings, |PWM|, channels.

Two programs, since the two files of a network may use a name each for itself. Literals of ``long`` are made 32 bits
wide, as they are on the AVR, and the compiler traps what overflows.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf, nextafter

from gen.certificate.compiled import printed, scratch
from gen.certificate.exact import Ratio
from gen.certificate.network.document import Factor, NetworkCertificate
from gen.certificate.source import Project

_LONG = re.compile(r"\b(\d+)(U?)L\b")
#: Compiled once and run once: optimising takes longer than it saves.
_FLAGS = ["-std=gnu++11", "-O0", "-ffp-contract=off", "-fsanitize=undefined", "-fsanitize-undefined-trap-on-error"]
#: Share by which long double results may be off: thirty operations of 2^-64 each.
_LONG_DOUBLE = 2.0**-59

_INTERFACE = """\
#include "interface.inc"
#include <cstdio>
#include <cstring>

static int failed(const char *what, long at) {{
    std::printf("\\nfailed %s at %ld\\n", what, at);
    return 1;
}}

static int64_t whole(int k) {{ return {whole}; }}

// The largest |1000 word - 2^bits thousandths| over a range.
static long long off(long low, long high) {{
    long long most = 0;
    for (long told = low; told <= high; ++told) {{
        long long away = 1000LL * degrees((int32_t)told) - (long long)told * (1LL << {bits});
        away = away < 0 ? -away : away;
        most = away > most ? away : most;
    }}
    return most;
}}

int main() {{
    for (long pwm = -32768; pwm <= 32767; ++pwm) {{
        long counts = pwm < 0 ? -pwm : pwm;
        counts = counts < {low} ? {low} : counts > {high} ? {high} : counts;
        if (magnitude((int16_t)pwm) != counts) return failed("magnitude", pwm);
    }}
    if ({model}_STATES != {states} || {MODEL}_COMPONENTS != {components} || {MODEL}_CHANNELS != {channels}) {{
        return failed("the number of states, components or channels", 0);
    }}
    {model}_begin();
{checks}
    std::printf("%lld %lld\\n", off({ambient_low}, {ambient_high}), off({start_low}, {start_high}));
    long long most = 0;
    for (int64_t fraction = 0; fraction < INT64_C(1) << {bits}; ++fraction) {{
        int64_t away = (int64_t)thousandths_of((int32_t)fraction) * (INT64_C(1) << {bits}) - 1000 * fraction;
        away = away < 0 ? -away : away;
        most = away > most ? away : most;
    }}
    // The whole kelvins add thousands: {bits} bits above the fraction.
    for (int64_t whole = -(INT64_C(1) << (31 - {bits})); whole < INT64_C(1) << (31 - {bits}); ++whole) {{
        const int64_t fractions[] = {{0, 1, (INT64_C(1) << {bits}) / 3, (INT64_C(1) << {bits}) - 1}};
        for (int k = 0; k < 4; ++k) {{
            const int64_t both = thousandths_of((int32_t)(whole * (INT64_C(1) << {bits}) + fractions[k]));
            if (both != thousandths_of((int32_t)fractions[k]) + 1000 * whole) return failed("reading", (long)whole);
        }}
    }}
    std::printf("%lld\\n", most);
    return 0;
}}
"""

_STATE = """\
    if ({model}_{name} != {place}) return failed("the place of {name}", {place});
    if (whole({place}) != {begin}) return failed("begin", {place});
"""
_AT_BEGIN = "(int64_t)degrees({ambient}) * (INT64_C(1) << {bits})"
_STILL = """\
            if (whole({drift}) != 0) return failed("the drift of {name} at a start", asked);
"""
_CHANNEL = """\
    if ({model}_model.channel[{number}] != {neutral}L) return failed("the neutral value of a channel", {number});
    {{
        const long told[] = {{INT32_MIN, {low} - 1L, {low}, {low} + 1, {high} - 1, {high}, {high} + 1L, INT32_MAX}};
        for (int k = 0; k < 8; ++k) {{
            if (told[k] < INT32_MIN || told[k] > INT32_MAX) continue;
            {model}_channel({number}, (int32_t)told[k]);
            const long held = told[k] < {low} ? {low} : told[k] > {high} ? {high} : told[k];
            if ({model}_model.channel[{number}] != held) return failed("what a channel holds", {number});
        }}
        {model}_channel({number}, {neutral});
    }}
"""
# A start puts node and reading to rest at what was asked for, within the range; hidden nodes are dealt with elsewhere.
_COMPONENT = """\
    {{
        if (std::strcmp({model}_component_name({number}), "{name}")) return failed("the name of {name}", {number});
        const Reading reading = reading_of({number});
        if (reading.node != {node} || reading.state != {state}{drift}) return failed("the state of {name}", {number});
        for (long asked = {low} - 2; asked <= {high} + 2; ++asked) {{
            const long held = asked < {low} ? {low} : asked > {high} ? {high} : asked;
            {model}_start({number}, (int32_t)(asked - ({neutral})));
            int64_t word = (int64_t)degrees((int32_t)held) - reading.offset;
{less}            word *= INT64_C(1) << {low_bits};
            if (whole({node}) != word || whole({state}) != word) return failed("start of {name}", asked);
{still}        }}
        std::printf("%ld {words}\\n", (long)reading.offset{gain});
    }}
"""
# What is taken off a reading for its gain, and what the program prints of it; how much that is, is proven elsewhere.
_LESS = """\
            word -= read_more(over_base(&reading, (int32_t)word, degrees({neutral})), reading.back);
"""
_GAIN = ", (unsigned long)reading.gain, (unsigned long)reading.back, (int)reading.about_ambient, (int)reading.opposite"

_FACTORS = """\
#include "sample.inc"
#include <cfloat>
#include <cstdio>

static_assert(LDBL_MANT_DIG >= 64, "long double is too short");

{exact}
template <typename Exact> void compare(int32_t (*board)(int32_t), Exact exact, long low, long high, int bits) {{
    long double most = 0.0L, least = 1e300L, largest = 0.0L;
    bool natural = true;
    for (long told = low; told <= high; ++told) {{
        long double margin = 0.0L, value = exact(told / 1000.0L, &margin);
        value = value > 0.0L ? value : 0.0L;
        margin *= {unit}L;
        const int32_t word = board((int32_t)told);
        natural = natural && word >= 0;
        long double away = value - (long double)word * __builtin_ldexpl(1.0L, -bits);
        away = (away < 0.0L ? -away : away) + margin;
        most = away > most ? away : most;
        least = value - margin < least ? value - margin : least;
        largest = value + margin > largest ? value + margin : largest;
    }}
    std::printf("%a %a %a %d\\n", (double)most, (double)least, (double)largest, (int)natural);
}}

int main() {{
{calls}
    return 0;
}}
"""


@dataclass(frozen=True)
class Span:
    """What the C++ gives for a factor.

    Attributes
    ----------
    error
        The word's largest distance from the factor, at every value that its channel can hold.
    low, high
        Ends of the factor.
    natural
        Whether no word is negative.
    """

    error: float
    low: float
    high: float
    natural: bool


@dataclass(frozen=True)
class Shown:
    """What the C++ has of a component's sensor.

    Attributes
    ----------
    offset
        Added to what is read, in words.
    gain, back
        Of its gain: the unsigned words with which what is shown, and a start, are computed.
    about_ambient, opposite
        What these are multiplied with: the distance from the ambient, not from 0 degC; the other way round.
    """

    offset: int
    gain: int = 0
    back: int = 0
    about_ambient: bool = False
    opposite: bool = False


@dataclass(frozen=True)
class Measured:
    """What was found.

    Attributes
    ----------
    ambient, start
        Largest distance of ``degrees`` from what it is told, over the ambient's range and that of starts, in words.
    sensors
        Of each component.
    reading_K
        Largest distance of ``thousandths_of`` from the word that it is told.
    """

    ambient: float
    start: float
    sensors: dict[str, Shown]
    reading_K: float


def measure(project: Project, certificate: NetworkCertificate, low_bits: int) -> Measured:
    """Run the interface.

    Raises
    ------
    ToolMissing
        If there is no g++.
    Refuted
        If it does not compile, or does not do what it should.
    """
    model, (ambient, *_) = project.model, certificate.equations.channels
    word = f"{model}_model.state.T[k]"
    checks = [
        _STATE.format(
            model=model,
            name=state.name,
            place=k,
            begin="0" if state.drifts_to_K is not None else _AT_BEGIN.format(ambient=ambient.neutral, bits=low_bits),
        )
        for k, state in enumerate(certificate.states)
    ]
    for number, channel in enumerate(certificate.equations.channels):
        checks.append(_CHANNEL.format(model=model, number=number, **channel.model_dump(exclude={"column"})))
    for number, part in enumerate(certificate.components):
        checks.append(
            _COMPONENT.format(
                model=model,
                number=number,
                name=part.name,
                node=part.node,
                state=part.state,
                drift=f" || reading.drift != {part.drift or 0}" if certificate.has_drifts else "",
                still=_STILL.format(name=part.name, drift=part.drift) if part.drift is not None else "",
                low=certificate.start_mC[0],
                high=certificate.start_mC[1],
                neutral=ambient.neutral,
                low_bits=low_bits,
                less=_LESS.format(neutral=ambient.neutral) if certificate.has_gains else "",
                words="%lu %lu %d %d" if certificate.has_gains else "",
                gain=_GAIN if certificate.has_gains else "",
            )
        )
    program = _INTERFACE.format(
        model=model,
        MODEL=model.upper(),
        bits=certificate.fraction_bits,
        low=certificate.domain_pwm[0],
        high=certificate.domain_pwm[1],
        states=len(certificate.states),
        components=len(certificate.components),
        channels=len(certificate.equations.channels),
        ambient_low=ambient.low,
        ambient_high=ambient.high,
        start_low=certificate.start_mC[0],
        start_high=certificate.start_mC[1],
        checks="".join(checks),
        whole=f"(int64_t){word}.hi * (1 << {low_bits}) + {word}.lo",
    )
    lines = _output(project, program, "interface.inc", "").split("\n")
    count = len(certificate.components)
    sensors = {part.name: _sensor(line) for part, line in zip(certificate.components, lines[:count], strict=True)}
    told, start = (_up(int(word) / 1000) for word in lines[count].split())
    return Measured(told, start, sensors, _up(float(Ratio(int(lines[count + 1]), 1000 << certificate.fraction_bits))))


def _sensor(line: str) -> Shown:
    offset, *of_gain = map(int, line.split())
    if not of_gain:
        return Shown(offset)
    gain, back, about_ambient, opposite = of_gain
    return Shown(offset, gain, back, bool(about_ambient), bool(opposite))


def spans(
    project: Project, certificate: NetworkCertificate, calls: Sequence[tuple[str, int]]
) -> dict[tuple[str, int], list[Span | None]]:
    """Compare functions of a channel's value with every factor of that channel.

    Parameters
    ----------
    project, certificate
        Whose.
    calls
        Functions of ``NAME_step.cpp``, and the channel that each is told.

    Returns
    -------
    dict
        By call: what was found for each factor of the certificate, None for those of other channels.

    Raises
    ------
    ToolMissing
        If there is no g++.
    Refuted
        If it does not compile, or a number overflows.
    """
    own = certificate.equations
    exact = [_exact(number, factor) for number, factor in enumerate(own.factors)]
    lines, pairs = [], []
    for name, channel in calls:
        for number, factor in enumerate(own.factors):
            if factor.channel == channel:
                told = own.channels[channel]
                lines.append(f"    compare({name}, exact{number}, {told.low}, {told.high}, {factor.bits});")
                pairs.append((name, channel, number))
    found: dict[tuple[str, int], list[Span | None]] = {call: [None] * len(own.factors) for call in calls}
    if not pairs:
        return found
    program = _FACTORS.format(exact="".join(exact), calls="\n".join(lines), unit=repr(_LONG_DOUBLE))
    for pair, line in zip(pairs, _output(project, program, "", "sample.inc").split("\n"), strict=False):
        *ends, natural = line.split()
        error, low, high = (float.fromhex(word) for word in ends)
        found[pair[:2]][pair[2]] = Span(_up(error), max(0.0, nextafter(low, -inf)), _up(high), natural == "1")
    return found


def _exact(number: int, factor: Factor) -> str:
    """C++ of a factor in long double, and of the magnitudes that it is made of."""
    lines = [f"static long double exact{number}(long double x, long double *size) {{"]
    if factor.polynomial:
        lines.append("    long double value = 0.0L, big = x < 0.0L ? -x : x;")
        for coefficient in factor.polynomial:
            lines.append(f"    value = value * x + {_literal(coefficient)};")
            lines.append(f"    *size = *size * big + {_literal(abs(coefficient))};")
        return "\n".join([*lines, "    return value;", "}", ""])
    lines.append(f"    if (x <= {_literal(factor.at[0])}) {{")
    lines.append(f"        *size = {_literal(abs(factor.value[0]))};")
    lines.append(f"        return {_literal(factor.value[0])};")
    lines.append("    }")
    points = list(zip(factor.at, factor.value, strict=True))
    for (a, y), (b, z) in pairwise(points):
        steep = abs(float((Ratio(z) - Ratio(y)) / (Ratio(b) - Ratio(a)))) * (1.0 + 2.0**-40)
        size = abs(y) + abs(z) + 2.0 * steep * max(abs(a), abs(b))
        lines.append(f"    if (x <= {_literal(b)}) {{")
        lines.append(f"        *size = {_literal(_up(size))};")
        lines.append(
            f"        return {_literal(y)} + ({_literal(z)} - {_literal(y)}) * (x - {_literal(a)}) / "
            f"({_literal(b)} - {_literal(a)});"
        )
        lines.append("    }")
    lines.append(f"    *size = {_literal(abs(factor.value[-1]))};")
    return "\n".join([*lines, f"    return {_literal(factor.value[-1])};", "}", ""])


def _literal(value: float) -> str:
    return f"({value.hex()}L)"


def _up(value: float) -> float:
    return nextafter(value, inf) if value else value


def _output(project: Project, program: str, interface: str, sample: str) -> str:
    """Compile a program with one of the network's files in it, and run it."""
    model = project.model
    with scratch() as folder:
        main = folder / "main.cpp"
        main.write_text(program, encoding="utf-8")
        sources = [main]
        for name, own in ((f"{model}.cpp", interface), (f"{model}_step.cpp", sample)):
            copy = folder / (own or name)
            text = (project.sources / name).read_text(encoding="utf-8")
            copy.write_text(_LONG.sub(_as_32_bits, text), encoding="utf-8")
            sources += [] if own else [copy]
        for name in (f"{model}_schedule.cpp", f"{model}_accumulator.cpp"):
            sources += [project.sources / name] if (project.sources / name).is_file() else []
        return printed(folder, sources, [*_FLAGS, f"-I{folder}", f"-I{project.sources}"])


def _as_32_bits(literal: re.Match[str]) -> str:
    return f"static_cast<{'uint32_t' if literal[2] else 'int32_t'}>({literal[1]})"
