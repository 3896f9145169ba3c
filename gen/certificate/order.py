"""The order of a sample: that ``NAME_step`` does what the theorem says, statement by statement.

commanded(pwm): if |PWM| is new, the old q is kept, the schedule evaluated, q's share handed over; then the recursion.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import groupby

from gen.certificate.document import AnyPart, Certificate, Part
from gen.certificate.refuted import Refuted
from gen.certificate.source import Project, spaced

_MARKS = re.compile(r'\b[A-Z0-9_]+_(?:ONE_COPY|SMALL|INLINE)\b|extern "C"|\bstatic\b|\binline\b')


def check_order(project: Project, certificate: Certificate) -> None:
    """Compare the functions that make up a sample with what the theorem is about.

    Raises
    ------
    Refuted
        If one does something else.
    """
    moving = certificate.ambient is not None
    functions = ("change", "commanded", "step", "resume")
    if moving:
        check_ambient(project, certificate)
    for name in functions:
        if name not in project.functions:
            raise Refuted(f"the C++ has no function {name}")
    sample = _FixedSample if certificate.arithmetic == "fixed" else _FloatSample
    text = {name: project.functions[name] for name in functions}
    expected = sample(project.model, certificate.components, text, moving=moving)
    for name, wanted in (
        ("change", expected.change()),
        ("commanded", _commanded(project.model, compared=any(map(expected.carries, certificate.components)))),
        ("step", expected.step()),
        ("resume", _resume(project.model, moving=moving)),
    ):
        found = _statements(text[name], project.model)
        if found != wanted:
            differing = next((f for f, w in zip(found, wanted, strict=False) if f != w), "its length")
            raise Refuted(f"{name} does not do what the proof is about: {differing}")


def check_ambient(project: Project, certificate: Certificate) -> None:
    """Compare what deals with the ambient; what its words are, and how it is told, is measured.

    Raises
    ------
    Refuted
        If one does something else.
    """
    model = project.model
    over = f"{model}_model.state.ambient_mK"
    effects = (project.sources / f"{model}_effects.h").is_file()  # these deal with starts and readings of their own
    for name in ("add_ambient", "ambient_words", "new_ambient", "over_reference", "start", "rise_mK"):
        if name not in project.functions:
            raise Refuted(f"the C++ has no function {name}")
    found = {name: _statements(text, model) for name, text in project.functions.items()}
    word = rf"const int32_t \w+ = {model}_model\.ambient\[\d+\];"
    _known(found["add_ambient"], rf"{word}|now->\w+\[\d+\]\.steady \+= \w+;", "add_ambient")
    _expect(found["ambient_words"][:1], [f"const int32_t over = {over};"], "ambient_words")
    word = rf"{model}_model\.ambient\[\d+\] = {model}_word_of\(over, [\w., ]+\);"
    _known(found["ambient_words"][1:], word, "ambient_words")
    low, high = "-beyond ? -beyond", f"rise_mK) + {over};"
    wanted = ["const int32_t beyond = 1000000000L;", f"return (rise_mK > beyond ? beyond : rise_mK < {low} : {high}"]
    _expect(found["over_reference"], wanted, "over_reference")
    of = "effects_start(component, rise_mK);" if effects else "over_reference(rise_mK);"
    _expect(found["start"][:1], [f"rise_mK = {model}_{of}"], "start")
    if any(over in statement for statement in found["start"][1:]):
        raise Refuted("start does not do what the proof is about: it reads the room twice")
    for part in certificate.parts:
        case = f"case {model.upper()}_{part.name.upper()}:"
        reading = f"{case} return {model}_{part.shape}_rise_mK(&{model}_model.state.{part.at}) - {over};"
        given = f"{case} return {model}_effects_mK({model}_model.effects.{part.name}.shown);"
        if reading not in found["rise_mK"] and not (effects and given in found["rise_mK"]):
            raise Refuted(f"rise_mK does not do what the proof is about: {part.name}")


def _known(found: Sequence[str], pattern: str, name: str) -> None:
    for statement in found:
        if not re.fullmatch(pattern, statement):
            raise Refuted(f"{name} does not do what the proof is about: {statement}")


def _expect(found: Sequence[str], wanted: Sequence[str], name: str) -> None:
    if list(found) != list(wanted):
        differing = next((f for f, w in zip(found, wanted, strict=False) if f != w), "its length")
        raise Refuted(f"{name} does not do what the proof is about: {differing}")


def _statements(text: str, model: str) -> list[str]:
    """A function's statements, without effects and the flag of limits, which come after the recursion."""
    body = spaced(_MARKS.sub("", text).split("{", 1)[1].rsplit("}", 1)[0])
    effects = rf"{model}_effects_step\(pwm\); if \({model}_model\.effects\.limited\) \{{ [^}}]*\}}"
    saturations = rf"if \({model}_model\.saturations\) \{{ [^}}]*\}}"
    body = re.sub(f"{effects}|{saturations}", "", body)
    return [spaced(part) for part in re.split(r"(?<=;)|(?<=\{)|(?<=\})", body) if part.strip()]


class _Sample:
    """What a sample consists of.

    Parameters
    ----------
    model
        The C++ names' prefix.
    parts
        All components, in order.
    text
        Of the functions: which of two ways to write the same they take.
    moving
        Whether the ambient is added to what is settled to.
    """

    def __init__(self, model: str, parts: Sequence[AnyPart], text: dict[str, str], *, moving: bool) -> None:
        self.model, self.parts, self.text, self.moving = model, parts, text, moving

    def change(self) -> list[str]:
        """A new |PWM|."""
        model = self.model
        carried = [part for part in self.parts if self.carries(part)]
        pointer = f"{model}_State *const state = &{model}_model.state;"
        lines = [pointer] if carried or pointer in self.text["change"] else []
        lines.append(f"{model}_Coefficients *const now = &{model}_model.now;")
        for part in carried:
            lines.append(f"const {self.kind(part)} {part.name}_before = {self.old_q(part)};")
        lines.append(f"{model}_schedule(pwm, now);")
        if self.moving:
            lines.append("add_ambient(now);")
        for part in carried:
            lines += self.handed_over(part)
        return lines

    def step(self) -> list[str]:
        """A sample."""
        raise NotImplementedError

    def carries(self, part: AnyPart) -> bool:
        """Whether a component hands q's share over."""
        raise NotImplementedError

    def handed_over(self, part: AnyPart) -> list[str]:
        """What does so."""
        raise NotImplementedError

    def old_q(self, part: AnyPart) -> str:
        """The expression that gives what is kept of q."""
        raise NotImplementedError

    def kind(self, part: AnyPart) -> str:
        """Its type."""
        raise NotImplementedError

    def call(self, part: AnyPart, function: str, *arguments: str) -> str:
        """A call of a component's function; an unproven one counts its limits."""
        counted = () if isinstance(part, Part) else (f"&{self.model}_model.saturations",)
        return f"{self.model}_{part.shape}_{function}({', '.join((*arguments, *counted))})"

    def guard(self, result: str) -> list[str]:
        """Whether anything was commanded: either of two ways to write it."""
        new, first = f"pwm != {self.model}_model.command", f"!({self.model}_model.flags & STARTED)"
        tests = [f"if ({new} || {first}) {{", f"if (__builtin_expect({first} || {new}, 0)) {{"]
        test = next((test for test in tests if test in self.text["step"]), tests[0])
        return [test, f"{result}commanded(pwm);", "}"]

    def advanced(self, shape: str, members: Sequence[AnyPart], *, alone: bool) -> list[str]:
        """All components of a shape, ``alone`` those that are one without a loop."""
        at = f"{shape.lower()}[{0 if alone else 'i'}]"
        call = (
            self.call(members[0], "advance", f"&{self.model}_model.state.{at}", f"&{self.model}_model.now.{at}") + ";"
        )
        if alone:
            return [call]
        return ["for (uint8_t i = 0;", f"i < {len(members)};", "++i) {", call, "}"]

    def shapes(self) -> list[tuple[str, list[AnyPart]]]:
        """Components of one shape together."""
        ordered = sorted(self.parts, key=lambda part: part.shape)
        return [(shape, list(members)) for shape, members in groupby(ordered, key=lambda part: part.shape)]


class _FixedSample(_Sample):
    def kind(self, part: AnyPart) -> str:
        return "int32_t" if isinstance(part, Part) else "int64_t"

    def carries(self, part: AnyPart) -> bool:
        return part.order > 1 and f"{self.model}_{part.shape}_carry(" in self.text["change"]

    def old_q(self, part: AnyPart) -> str:
        return self.call(part, "drive", f"&state->{part.at}", f"&now->{part.at}")

    def handed_over(self, part: AnyPart) -> list[str]:
        return [self.call(part, "carry", f"&state->{part.at}", f"{part.name}_before", self.old_q(part)) + ";"]

    def step(self) -> list[str]:
        shapes = self.shapes()
        lines = self.guard("")
        for proven in (False, True):  # on the AVR what is proven is one block of assembly
            for shape, members in shapes:
                if isinstance(members[0], Part) is proven:
                    lines += self.advanced(shape, members, alone=len(members) == 1)
        return lines


class _FloatSample(_Sample):
    def kind(self, part: AnyPart) -> str:
        return "float"

    def carries(self, part: AnyPart) -> bool:
        return part.order > 1

    def old_q(self, part: AnyPart) -> str:
        return f"{self.model}_{part.shape}_increment(&state->{part.at}, &now->{part.at})"

    def handed_over(self, part: AnyPart) -> list[str]:
        carry = self.call(part, "carry", f"&state->{part.at}", f"&now->{part.at}", f"{part.name}_before")
        return [
            f"const float {part.name}_q = {carry};",
            self.call(part, "advance", f"&state->{part.at}", f"{part.name}_q") + ";",
        ]

    def step(self) -> list[str]:
        carried = [part for part in self.parts if self.carries(part)]
        lines = ["uint8_t done = 0;", *self.guard("done = ")] if carried else self.guard("")
        for part in carried:
            state, now = f"&{self.model}_model.state.{part.at}", f"&{self.model}_model.now.{part.at}"
            lines += [
                "for (uint8_t run = done;",
                f"run < {part.substeps};",
                "++run) {",
                f"const float q = {self.model}_{part.shape}_increment({state}, {now});",
                self.call(part, "advance", state, "q") + ";",
                "}",
            ]
        for shape, members in self.shapes():
            if members[0].order == 1:
                lines += self.advanced(shape, members, alone=False)
        return lines


def _commanded(model: str, *, compared: bool) -> list[str]:
    """A command: where q is handed over, only another magnitude counts; else the schedule anew does no harm."""
    flags, change = model.upper(), "change(within);"
    lines = [
        f"const uint8_t kept = {model}_model.flags & (STARTED | {flags}_START_CLAMPED | {flags}_SATURATED);",
        "const uint8_t within = magnitude(pwm);",
        f"{model}_model.command = pwm;",
        f"{model}_model.flags = (uint8_t)(kept | STARTED | pwm_flags(pwm, within));",
    ]
    if not compared:
        return [*lines, change]
    changed = f"const uint8_t changed = within != magnitude({model}_model.command) || !(kept & STARTED);"
    return [*lines[:2], changed, *lines[2:], "if (changed) {", change, "}", "return changed;"]


def _resume(model: str, *, moving: bool) -> list[str]:
    return [
        "const uint8_t within = magnitude(pwm);",
        f"{model}_model.command = pwm;",
        f"{model}_model.flags = (uint8_t)(STARTED | pwm_flags(pwm, within));",
        f"{model}_schedule(within, &{model}_model.now);",
        *(["ambient_words();", f"add_ambient(&{model}_model.now);"] if moving else []),
    ]
