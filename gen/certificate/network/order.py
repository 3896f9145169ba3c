"""The order of a sample, of a start and of a reading: the interface of a network has the expected statements.

What they call is run or read elsewhere.
"""

from __future__ import annotations

import re

from gen.certificate.network.document import NetworkCertificate
from gen.certificate.refuted import Refuted
from gen.certificate.source import Project, spaced

_MARKS = re.compile(r'\b[A-Z0-9_]+_(?:ONE_COPY|SMALL)\b|extern "C"|\bstatic\b|\binline\b')


def check_order(project: Project, certificate: NetworkCertificate) -> None:
    """Compare the functions of the interface with what the theorem is about.

    Raises
    ------
    Refuted
        If one does something else.
    """
    model, low = project.model, certificate.domain_pwm[0]
    row = f"(uint8_t)(within - {low}u)" if low else "within"
    rest = " if (reading.drift) { rest_at(reading.drift, 0); }" if certificate.has_drifts else ""
    rest += " rest_hidden();" if certificate.hidden else ""
    drifts = "".join(f" rest_at(N_{state.name}, 0);" for state in certificate.states if state.drifts_to_K is not None)
    offset = "reading.offset + drifted(&reading)" if certificate.has_drifts else "reading.offset"
    neutral = "".join(
        f" N_model.channel[{name}] = {told.neutral}L;"
        for name, told in zip(_channels(project), certificate.equations.channels, strict=False)
    )
    word = "N_model.state.T[state]"
    seen = "const int32_t word = degrees(ambient + rise_mK) - reading.offset; "
    shown = f"return thousandths_of(upper(reading.state) + {offset} - degrees(N_model.channel[M_CHANNEL_AMBIENT]));"
    if certificate.has_gains:
        seen = (
            "const int32_t seen = degrees(ambient + rise_mK) - reading.offset; "
            "const int32_t word = seen - read_more(over_base(&reading, seen, degrees(ambient)), reading.back); "
        )
        shown = (
            "const int32_t word = upper(reading.state), ambient = degrees(N_model.channel[M_CHANNEL_AMBIENT]); "
            "return thousandths_of(word + shown_more(over_base(&reading, word, ambient), reading.gain) + "
            f"{offset} - ambient);"
        )
    expected = {
        "begin": (
            f"N_model.flags = 0;{neutral} const int32_t ambient = degrees(N_model.channel[M_CHANNEL_AMBIENT]); "
            "for (uint8_t state = 0; state < N_STATES; ++state) { rest_at(state, ambient); }"
            f"{drifts} N_model.limited = 0;"
        ),
        "start": (
            "if (component >= M_COMPONENTS) { return; } "
            "const int32_t ambient = N_model.channel[M_CHANNEL_AMBIENT], "
            f"low = {certificate.start_mC[0]}L - ambient, high = {certificate.start_mC[1]}L - ambient; "
            "uint8_t flags = N_model.flags; if (rise_mK < low) { rise_mK = low; flags |= M_START_CLAMPED; } "
            "else if (rise_mK > high) { rise_mK = high; flags |= M_START_CLAMPED; } N_model.flags = flags; "
            "const Reading reading = reading_of(component); "
            f"{seen}rest_at(reading.node, word); rest_at(reading.state, word);{rest}"
        ),
        "reading_of": "Reading reading; memcpy_P(&reading, &READING[component], sizeof reading); return reading;",
        "rest_at": f"{word}.lo = 0; {word}.hi = word;",
        "upper": f"return {word}.hi;",
        "channel": (
            "if (channel >= M_CHANNELS) { return; } "
            "const int32_t low = (int32_t)pgm_read_dword(&CHANNEL_LOW[channel]), "
            "high = (int32_t)pgm_read_dword(&CHANNEL_HIGH[channel]); "
            "if (thousandths < low || thousandths > high) { thousandths = thousandths < low ? low : high; "
            "if (N_model.limited < 0xFFFFu) { ++N_model.limited; } } N_model.channel[channel] = thousandths;"
        ),
        "step": (
            "const uint8_t within = magnitude(pwm); N_model.command = pwm; "
            "N_model.flags = (uint8_t)((N_model.flags & M_START_CLAMPED) | STARTED | pwm_flags(pwm, within) | "
            "(N_model.limited ? M_SATURATED : 0)); "
            f"N_advance({row}, degrees(N_model.channel[M_CHANNEL_AMBIENT]));"
        ),
        "resume": ("N_model.command = pwm; N_model.flags = (uint8_t)(STARTED | pwm_flags(pwm, magnitude(pwm)));"),
        "rise_mK": (
            f"if (component >= M_COMPONENTS) {{ return 0; }} const Reading reading = reading_of(component); {shown}"
        ),
    }
    if certificate.has_gains:
        expected["over_base"] = (
            "const int32_t base = reading->about_ambient ? ambient : 0; "
            "return reading->opposite ? base - word : word - base;"
        )
    if certificate.has_drifts:
        expected["drifted"] = "return reading->drift ? upper(reading->drift) : 0;"
    for name, wanted in expected.items():
        if name not in project.functions:
            raise Refuted(f"the C++ has no function {name}")
        found = spaced(_MARKS.sub("", project.functions[name]).split("{", 1)[1].rsplit("}", 1)[0])
        if found != re.sub(r"\b([NM])_", lambda prefix: f"{model if prefix[1] == 'N' else model.upper()}_", wanted):
            raise Refuted(f"{name} does not do what the proof is about")


def _channels(project: Project) -> list[str]:
    """The channels' enumerators as `begin` names them: what they hold is found by running it."""
    return re.findall(rf"{project.model}_model\.channel\[(\w+)\] =", project.functions.get("begin", ""))
