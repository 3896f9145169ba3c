"""What the guarantee says, in words: one text for the emitted header, README and report."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass

from gen.lowering.effects.program import Channel
from gen.lowering.network.program import NetworkProgram
from gen.lowering.program import Program

#: Columns of a comment in the emitted C++.
_WIDTH = 118


@dataclass(frozen=True)
class Clause:
    """One thing that the guarantee depends on or leaves out.

    Attributes
    ----------
    title
        What it is about, to be read on into the text.
    text
        A sentence or more; code stands between backquotes.
    """

    title: str
    text: str


def contract(program: Program) -> tuple[Clause, ...]:
    """The guarantee's clauses for a project; none where no part has one."""
    if all(part.proof is None for part in program.parts):
        return ()
    model = program.model
    if program.network is not None:
        return _network_clauses(program, program.network)
    lowest, highest = model.domain_pwm
    domain = f"{lowest}..{highest}"
    return clauses(model.name, f"{model.sample_time:g} s", domain, _exceptions(program), ambient=program.ambient)


def _network_clauses(program: Program, network: NetworkProgram) -> tuple[Clause, ...]:
    """The clauses for a network, in which the ambient and channels act on temperatures."""
    model, name = program.model, program.model.name
    low, high = (end / 1000.0 for end in network.start_mC)
    lowest, highest = model.domain_pwm
    others = ", ".join(channel.column for channel in program.channels[1:])
    told = "of the ambient" + (f" and of {others}" if others else "")
    return (
        Clause(
            "Of which output",
            "The model's own word for what a part's sensor shows is never further from the exact solution than the "
            f"bound above. `{name}_rise_mK()` and `{name}_temperature_mC()` round it to the nearest thousandth of a "
            "kelvin, and take off the ambient that was told last.",
        ),
        Clause(
            "From which start",
            f"From any temperatures of the parts between {low:g} and {high:g} degC: `{name}_begin()` starts at the "
            f"ambient, `{name}_start()` at the rise that it is told. One outside is limited and flagged; the guarantee "
            "is then about the limited one. Nodes that nobody measures start where they would rest between the others, "
            "in the exact solution, too.",
        ),
        Clause(
            "Between which events",
            f"For every sequence of PWM, {told} as they are told, of any length, from one `{name}_begin()` and "
            f"`{name}_start()` of all parts to the next. A reset of the board ends it, unless `{name}_resume()` goes "
            "on with the very words, channels and PWM of the last sample. Time that passes during a reset is not "
            "modelled.",
        ),
        Clause(
            "Under which assumptions",
            f"Every sample lasts {model.sample_time:g} s. |PWM| and channels are held over a sample; |PWM| is limited "
            f"to {lowest}..{highest}, channels to their ranges. The exact solution is that of the coefficient file's "
            "network. The board computes the same words as the C++ that `gen verify` compares.",
        ),
        Clause(
            "What is no part of it",
            "Errors of sensors, of the measured ambient, and of the model itself: how well it fits the motor.",
        ),
    )


def clauses(
    name: str, sample_time: str, domain: str, exceptions: str = "", ambient: Channel | None = None
) -> tuple[Clause, ...]:
    """The guarantee's clauses.

    Parameters
    ----------
    name
        What the library's functions begin with.
    sample_time
        With its unit.
    domain
        The |PWM| for which all is proven.
    exceptions
        Sentences about parts of which less holds, each with a space before it.
    ambient
        The one whose changes pass the parts' dynamics, or None.
    """
    over, told, held, equation = "rise over ambient", "", "", "the coefficient file's equation"
    if ambient is not None:
        over, told = f"rise over {ambient.neutral / 1000:g} degC", ", and of the ambient as it is told"
        held = f" The ambient is limited to {ambient.low / 1000:g}..{ambient.high / 1000:g} degC."
        equation += ", in which the ambient drives the part as a steady rise does"
    return (
        Clause(
            "Of which output",
            f"The model's own word for a part's {over} is never further from the exact solution than "
            f"`bound_K` in `certificate.json`. `{name}_rise_mK()` and `{name}_temperature_mC()` round it to the "
            "nearest thousandth of a kelvin, which adds up to 0.5001 thousandths: `reading_K`.",
        ),
        Clause(
            "From which start",
            f"From any rise of the part's start range (`start_mK`), at rest, and from the first sample on: "
            f"`{name}_begin()` starts at 0, `{name}_start()` at the rise that it is told. One outside of the range is "
            "limited to it and flagged; the guarantee is then about the limited one.",
        ),
        Clause(
            "Between which events",
            f"For every sequence of PWM{told}, of any length, from one `{name}_start()` of the part to its next. A "
            f"reset of the board or `{name}_begin()` ends it, unless `{name}_resume()` goes on with the very words and "
            "the PWM of the last sample. Time that passes during a reset is not modelled.",
        ),
        Clause(
            "Under which assumptions",
            f"Every sample lasts {sample_time}. |PWM| is held over a sample, and limited to {domain}.{held} The exact "
            f"solution is that of {equation}. The board computes the same words as the C++ that "
            "`gen verify` compares.",
        ),
        Clause(
            "What is no part of it",
            "Errors of sensors, of the measured ambient, and of the model itself: how well it fits the motor."
            + exceptions,
        ),
        Clause(
            "Proven anew",
            "`gen check FOLDER`, told the project's folder, proves it from the emitted C++ and `certificate.json`, "
            "with nothing of what made them.",
        ),
    )


def _exceptions(program: Program) -> str:
    """Of which parts less is guaranteed, in sentences with a space before each."""
    text = ""
    without = [part.name for part in program.parts if part.proof is None]
    if without:
        text += f" Nothing is guaranteed of {_listed(without)}."
    affected = [part.name for part in program.effects.components] if program.effects is not None else []
    if affected:
        text += (
            f" Effects: of {_listed(affected)} the guarantee is about the baseline's word alone, and not about what is "
            "given out."
        )
    return text


def as_comment(clauses: tuple[Clause, ...]) -> list[str]:
    """The clauses as lines of a C++ comment, without backquotes."""
    lines = []
    for clause in clauses:
        text = f"{clause.title}: {clause.text}".replace("`", "")
        lines += textwrap.wrap(text, _WIDTH, initial_indent="// * ", subsequent_indent="//   ")
    return lines


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
