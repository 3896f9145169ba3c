"""The order of a sample: that ``NAME_step`` does what the theorem says, statement by statement.

commanded(pwm): if |PWM| is new, the old q is kept, the schedule evaluated, q's share handed over; then the recursion.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from gen.certificate.document import Certificate, Part
from gen.certificate.refuted import Refuted
from gen.certificate.source import Project, spaced

_MARKS = re.compile(r'\b[A-Z0-9_]+_(?:ONE_COPY|SMALL)\b|extern "C"|\bstatic\b|\binline\b')


def check_order(project: Project, certificate: Certificate) -> None:
    """Compare the functions that make up a sample with what the theorem is about.

    Raises
    ------
    Refuted
        If one does something else.
    """
    others = [part.name for part in certificate.components if not isinstance(part, Part)]
    for name in ("change", "commanded", "step", "resume"):
        if name not in project.functions:
            raise Refuted(f"the C++ has no function {name}")
    expected = {
        "change": _change(project, certificate),
        "commanded": _commanded(project),
        "step": _step(project, certificate),
        "resume": _resume(project),
    }
    for name, wanted in expected.items():
        found = _statements(project.functions[name], certificate, others)
        if found != [spaced(statement) for statement in wanted]:
            differing = next((f for f, w in zip(found, wanted, strict=False) if f != spaced(w)), "its length")
            raise Refuted(f"{name} does not do what the proof is about: {differing}")


def _statements(text: str, certificate: Certificate, others: Sequence[str]) -> list[str]:
    """The function's statements, without what belongs to unproven components, to effects and to the flag of limits."""
    model = certificate.model
    body = _MARKS.sub("", text).split("{", 1)[1].rsplit("}", 1)[0]
    effects = rf"{model}_effects_step\(pwm\); if \({model}_model\.effects\.limited\) \{{ [^}}]*\}}"
    saturations = rf"if \({model}_model\.saturations\) \{{ [^}}]*\}}"
    body = re.sub(f"{effects}|{saturations}", "", spaced(body))
    found = [spaced(part) for part in re.split(r"(?<=;)|(?<=\{)|(?<=\})", body) if part.strip()]
    if not others:
        return found
    kept: list[str] = []
    skipping = 0
    for statement in found:
        # An unproven component's own loop or call counts its saturations.
        if "saturations" in statement or any(f"{name}_before" in statement for name in others):
            if kept and kept[-1].startswith("for (") and kept[-1].endswith("{"):
                kept.pop()
                skipping += 1
            continue
        if skipping and statement == "}":
            skipping -= 1
            continue
        kept.append(statement)
    return kept


def _shapes(certificate: Certificate) -> dict[str, list[Part]]:
    shapes: dict[str, list[Part]] = {}
    for part in certificate.parts:
        shapes.setdefault(part.shape, []).append(part)
    return shapes


def _carried(project: Project, certificate: Certificate) -> list[Part]:
    return [part for part in certificate.parts if f"{part.shape}_carry" in project.functions]


def _place(part: Part) -> str:
    return f"{part.shape.lower()}[{part.place}]"


def _change(project: Project, certificate: Certificate) -> list[str]:
    model, carried = certificate.model, _carried(project, certificate)
    pointer = f"{model}_State *const state = &{model}_model.state;"
    lines = [pointer] if pointer in project.functions["change"] else []
    lines.append(f"{model}_Coefficients *const now = &{model}_model.now;")
    single = certificate.arithmetic == "float"
    kind, kept = ("float", "increment") if single else ("int32_t", "drive")
    for part in carried:
        at, function = _place(part), f"{model}_{part.shape}"
        lines.append(f"const {kind} {part.name}_before = {function}_{kept}(&state->{at}, &now->{at});")
    lines.append(f"{model}_schedule(pwm, now);")
    for part in carried:
        at, function = _place(part), f"{model}_{part.shape}"
        if single:
            lines.append(f"const float {part.name}_q = {function}_carry(&state->{at}, &now->{at}, {part.name}_before);")
            lines.append(f"{function}_advance(&state->{at}, {part.name}_q);")
        else:
            lines.append(
                f"{function}_carry(&state->{at}, {part.name}_before, {function}_drive(&state->{at}, &now->{at}));"
            )
    return lines


def _commanded(project: Project) -> list[str]:
    model, flags = project.model, project.model.upper()
    return [
        f"const uint8_t kept = {model}_model.flags & (STARTED | {flags}_START_CLAMPED | {flags}_SATURATED);",
        "const uint8_t within = magnitude(pwm);",
        f"const uint8_t changed = within != magnitude({model}_model.command) || !(kept & STARTED);",
        f"{model}_model.command = pwm;",
        f"{model}_model.flags = (uint8_t)(kept | STARTED | pwm_flags(pwm, within));",
        "if (changed) {",
        "change(within);",
        "}",
        "return changed;",
    ]


def _resume(project: Project) -> list[str]:
    model = project.model
    return [
        "const uint8_t within = magnitude(pwm);",
        f"{model}_model.command = pwm;",
        f"{model}_model.flags = (uint8_t)(STARTED | pwm_flags(pwm, within));",
        f"{model}_schedule(within, &{model}_model.now);",
    ]


def _step(project: Project, certificate: Certificate) -> list[str]:
    model, functions = certificate.model, project.functions
    if certificate.arithmetic == "fixed":
        return [*_guard(functions["step"], model, ""), *_fixed_runs(certificate)]
    carried = _carried(project, certificate)
    lines = ["uint8_t done = 0;"] if "done = 0" in functions["step"] else []
    lines += _guard(functions["step"], model, "done = " if lines else "")
    for part in carried:
        at, function = f"{model}_model.state.{_place(part)}", f"{model}_{part.shape}"
        lines += [
            "for (uint8_t run = done;",
            f"run < {part.substeps};",
            "++run) {",
            f"const float q = {function}_increment(&{at}, &{model}_model.now.{_place(part)});",
            f"{function}_advance(&{at}, q);",
            "}",
        ]
    for shape, members in _shapes(certificate).items():
        if members[0].order == 1:
            lines += _loop(model, shape, len(members))
    return lines


def _guard(step: str, model: str, result: str) -> list[str]:
    """Whether anything was commanded: either of two ways to write it."""
    new, first = f"pwm != {model}_model.command", f"!({model}_model.flags & STARTED)"
    tests = [f"if ({new} || {first}) {{", f"if (__builtin_expect({first} || {new}, 0)) {{"]
    return [next((test for test in tests if test in step), tests[0]), f"{result}commanded(pwm);", "}"]


def _fixed_runs(certificate: Certificate) -> list[str]:
    lines = []
    for shape, members in _shapes(certificate).items():
        if len(members) > 1:
            lines += _loop(certificate.model, shape, len(members))
        else:
            at, model = f"{shape.lower()}[0]", certificate.model
            lines.append(f"{model}_{shape}_advance(&{model}_model.state.{at}, &{model}_model.now.{at});")
    return lines


def _loop(model: str, shape: str, count: int) -> list[str]:
    at = f"{shape.lower()}[i]"
    return [
        "for (uint8_t i = 0;",
        f"i < {count};",
        "++i) {",
        f"{model}_{shape}_advance(&{model}_model.state.{at}, &{model}_model.now.{at});",
        "}",
    ]
