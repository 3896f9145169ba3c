"""What is found by running the emitted C++ on every input: tables, starts, readings, |PWM|.

The library is compiled for this computer without its effects, which come after the recursion.
"""

from __future__ import annotations

from dataclasses import dataclass

from gen.certificate.compiled import printed, scratch
from gen.certificate.document import LOW_BITS, Certificate
from gen.certificate.exact import Ratio, Ratios, ratios
from gen.certificate.refuted import Refuted
from gen.certificate.source import Project

_PROGRAM = """\
#include "{model}.cpp"
#include <cstdio>
#include <cstring>

{stubs}
static int failed(const char *what, long at) {{
    std::printf("\\nfailed %s at %ld\\n", what, at);
    return 1;
}}

int main() {{
    for (long pwm = -32768; pwm <= 32767; ++pwm) {{
        long counts = pwm < 0 ? -pwm : pwm;
        counts = counts < {low} ? {low} : counts > {high} ? {high} : counts;
        if (magnitude((int16_t)pwm) != counts) return failed("magnitude", pwm);
    }}
    for (int pwm = {low}; pwm <= {high}; ++pwm) {{
        {model}_Coefficients now;
        {model}_schedule((uint8_t)pwm, &now);
{tables}        std::printf("\\n");
    }}
{ambient}{parts}    return 0;
}}
"""

#: Bits after the binary point of a word that is read.
_MOST_BITS = 31
_NONE = Ratio(0)
_TABLE = """\
        for (int i = 0; i < {order}; ++i) std::printf("%a ", (double)now.{at}.rate[i]);
        std::printf("%a ", (double)now.{at}.steady);
"""

# Every ambient is told from another one: only a change is dealt with at the next sample.
_AMBIENT = """\
    std::memset((void *)&{model}_model, 0xFF, sizeof {model}_model);
    {model}_begin();
    for (const int32_t &word : {model}_model.ambient) {{
        if (word || {model}_model.state.ambient_mK) return failed("the ambient at the start", word);
    }}
    std::memset((void *)&{model}_model, 0, sizeof {model}_model);
    for (long over = {low}; over <= {high}; ++over) {{
        for (int twice = 0; twice < 2; ++twice) {{
            {model}_model.flags = STARTED;
            {model}_new_ambient((int32_t)(over + {reference}));
            if ({model}_model.state.ambient_mK != over) return failed("the ambient", over);
            {model}_Model copy = {model}_model;
            ambient_words();
            if (std::memcmp(copy.ambient, {model}_model.ambient, sizeof copy.ambient)) return failed("its words", over);
            const bool waits = !({model}_model.flags & STARTED);
            if (waits == (twice || over == 0)) return failed("a change of the ambient", over);
        }}
        {model}_model.state.ambient_mK = 0;
        ambient_words();
    }}
"""

_AMBIENT_TOLD = """\
    const int32_t told[] = {{
        INT32_MIN, {lowest} - 1, {lowest}, {lowest} + 1, {reference}, {highest} - 1, {highest}, {highest} + 1, INT32_MAX
    }};
    for (int k = 0; k < 9; ++k) {{
        const int32_t held = told[k] < {lowest} ? {lowest} : told[k] > {highest} ? {highest} : told[k];
        {model}_channel(0, told[k]);
        if ({model}_model.state.ambient_mK != held - {reference}) return failed("what is told of the ambient", told[k]);
    }}
"""

_AMBIENT_WORD = """\
    {{
        int64_t most = 0, low = 0, high = 0;
        for (int64_t over = {low}; over <= {high}; ++over) {{
            {model}_Coefficients now;
            std::memset((void *)&now, 0, sizeof now);
            {model}_model.state.ambient_mK = (int32_t)over;
            ambient_words();
            add_ambient(&now);
            const int64_t word = now.{at}.steady;
            int64_t away = 1000 * word - over * (INT64_C(1) << {bits});
            if (away < 0) away = -away;
            if (away > most) most = away;
            if (word < low) low = word;
            if (word > high) high = word;
        }}
        std::printf("%lld %lld %lld\\n", (long long)low, (long long)high, (long long)most);
    }}
"""

# `away` is 1000 word - 2^bits mK: off by that in units of 2^-bits mK; the start's word has `low_bits` more.
_PART = """\
    {{
        {model}_begin();
        if (std::strcmp({model}_component_name({number}), "{name}")) return failed("the name of {name}", {number});
        auto &state = {model}_model.state.{at};
        int64_t most = 0;
        for (int64_t rise = {low}; rise <= {high}; ++rise) {{
            {model}_start({number}, (int32_t)rise);
            const int64_t word = (int64_t)state.x[0].hi * (1 << {low_bits}) + state.x[0].lo;
            __int128 away = (__int128)1000 * word - (__int128)rise * (INT64_C(1) << ({bits} + {low_bits}));
            bool rests = true;
            for (int i = 1; i < {order}; ++i) rests = rests && !state.x[i].hi && !state.x[i].lo;
            for (int i = 0; i < {order}; ++i) rests = rests && {model}_model.now.{at}.rate[i] == 0;
            if (!rests) return failed("start of {name}", (long)rise);
            if (away < 0) away = -away;
            if (away > most) most = (int64_t)away;
        }}
        {model}_start({number}, {low});
        const int32_t lowest = state.x[0].hi;
        {model}_start({number}, {high});
        const int32_t highest = state.x[0].hi;
        const int32_t beyond[] = {{INT32_MIN, {low} - 1, {high} + 1, INT32_MAX}};
        for (int k = 0; k < 4; ++k) {{
            {model}_start({number}, beyond[k]);
            if (state.x[0].hi != (k < 2 ? lowest : highest)) return failed("limit of {name}", beyond[k]);
        }}
        std::printf("%lld ", (long long)most);
        most = 0;
        for (int64_t fraction = 0; fraction < INT64_C(1) << {bits}; ++fraction) {{
            state.x[0].hi = (int32_t)fraction;
            int64_t away = (int64_t){reading} * (INT64_C(1) << {bits}) - 1000 * fraction;
            if (away < 0) away = -away;
            if (away > most) most = away;
        }}
        // The whole kelvins add thousands: {bits} bits above the fraction.
        for (int64_t whole = -(INT64_C(1) << (31 - {bits})); whole < INT64_C(1) << (31 - {bits}); ++whole) {{
            const int64_t fractions[] = {{0, 1, (INT64_C(1) << {bits}) / 3, (INT64_C(1) << {bits}) - 1}};
            for (int k = 0; k < 4; ++k) {{
                state.x[0].hi = (int32_t)fractions[k];
                const int64_t alone = {reading};
                state.x[0].hi = (int32_t)(whole * (INT64_C(1) << {bits}) + fractions[k]);
                const int64_t both = {reading};
                if (both != alone + 1000 * whole) return failed("reading of {name}", (long)whole);
            }}
        }}
        std::printf("%lld\\n", (long long)most);
    }}
"""

_EFFECTS = """\
void {model}_effects_begin(void) {{}}
int32_t {model}_effects_start(uint8_t, int32_t rise_mK) {{ return rise_mK; }}
void {model}_effects_started(uint8_t) {{}}
void {model}_effects_step(int16_t) {{}}
"""


@dataclass(frozen=True)
class Measured:
    """What the C++ gives for one component.

    Attributes
    ----------
    table
        R0 .. R[n-1] and S, shape (P, n + 1), as the board multiplies with them.
    first_pwm
        |PWM| of the table's first row.
    start_K
        The largest distance of a start from what was asked for.
    reading_K
        The largest distance of ``NAME_rise_mK`` from the word that it reads.
    ambient, ambient_K
        Lowest and highest word that an ambient is added to S as, and its largest distance from the ambient.
    """

    table: Ratios
    first_pwm: int
    start_K: Ratio
    reading_K: Ratio
    ambient: tuple[int, int] = (0, 0)
    ambient_K: Ratio = _NONE


def measure(project: Project, certificate: Certificate) -> dict[str, Measured]:
    """Compile the library and run it on everything that there is.

    Raises
    ------
    ToolMissing
        If there is no g++.
    Refuted
        If it does not compile, or does not do what it should.
    """
    low, high = certificate.domain_pwm
    for part in certificate.parts:
        if part.fraction_bits[0] > _MOST_BITS:
            raise Refuted(f"{part.name}: {part.fraction_bits[0]} bits after the point of a word of 32")
    parts, model = certificate.parts, certificate.model
    effects = (project.sources / f"{model}_effects.h").is_file()  # then the words of some are not what is given out
    numbers = {part.name: number for number, part in enumerate(certificate.components)}
    program = _PROGRAM.format(
        model=model,
        low=low,
        high=high,
        stubs=_EFFECTS.format(model=model) if effects else "",
        ambient=_of_ambient(certificate, effects=effects),
        tables="".join(_TABLE.format(order=part.order, at=part.at) for part in parts),
        parts="".join(
            _PART.format(
                model=model,
                at=part.at,
                name=part.name,
                number=numbers[part.name],
                reading=f"{model}_{part.shape}_rise_mK(&state)"
                if effects
                else f"{model}_rise_mK({numbers[part.name]})",
                order=part.order,
                low=part.start_mK[0],
                high=part.start_mK[1],
                bits=part.fraction_bits[0],
                low_bits=LOW_BITS[certificate.arithmetic],
            )
            for part in parts
        ),
    )
    lines = _output(project, program).splitlines()
    rows = high - low + 1
    table = ratios([float.fromhex(text) for text in line.split()] for line in lines[:rows])
    found, first = {}, 0
    words = [(0, 0, 0) for _ in parts]
    if certificate.ambient is not None:
        for k, line in enumerate(lines[rows : rows + len(parts)]):
            lowest, highest, most = (int(text) for text in line.split())
            words[k] = lowest, highest, most
        rows += len(parts)
    for part, line, (lowest, highest, most) in zip(parts, lines[rows:], words, strict=True):
        start, reading = (int(text) * Ratio(1, 1000 << part.fraction_bits[0]) for text in line.split())
        start /= 1 << LOW_BITS[certificate.arithmetic]
        off = most * Ratio(1, 1000 << part.fraction_bits[0])
        own = table[:, first : first + part.order + 1]
        found[part.name] = Measured(own, low, start, reading, (lowest, highest), off)
        first += part.order + 1
    return found


def _of_ambient(certificate: Certificate, *, effects: bool) -> str:
    """What tries every ambient; nothing where none acts."""
    if certificate.ambient is None:
        return ""
    (low, high), model = certificate.ambient.over_mK, certificate.model
    given = {
        "model": model,
        "low": low,
        "high": high,
        "reference": certificate.ambient.reference_mC,
        "lowest": certificate.ambient.low_mC,
        "highest": certificate.ambient.high_mC,
    }
    text = _AMBIENT.format(**given) + ("" if effects else _AMBIENT_TOLD.format(**given))
    for part in certificate.parts:
        text += _AMBIENT_WORD.format(model=model, low=low, high=high, at=part.at, bits=part.fraction_bits[0])
    return text


def _output(project: Project, program: str) -> str:
    with scratch() as folder:
        main = folder / "measure.cpp"
        main.write_text(program, encoding="utf-8")
        names = (f"{project.model}_schedule.cpp", f"{project.model}_accumulator.cpp")
        others = [project.sources / name for name in names if (project.sources / name).is_file()]
        flags = ["-std=gnu++11", "-O2", "-ffp-contract=off", f"-I{project.sources}"]
        return printed(folder, [main, *others], flags)
