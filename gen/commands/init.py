"""`gen init`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from gen.commands.options import check_once
from gen.errors import InputError
from gen.files import shown_name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gen.coefficients import Coefficients
    from gen.coefficients.rules import RuleDraft
    from gen.coefficients.wiring import Wiring

_PATH = click.Path(path_type=Path)


@click.command(
    short_help="Start wiring and alarm rules that fit a model or logs.",
    epilog="Example:  gen init identified.json --out motor.json",
)
@click.argument("files", metavar="RUN...|COEFFS", nargs=-1, required=True, type=_PATH)
@click.option("--out", type=_PATH, required=True, help="The JSON file to write.")
def init(files: tuple[Path, ...], out: Path) -> None:
    """Write a commented start for wiring and alarm rules.

    From COEFFS alone: the same coefficient file with wiring and rules, ready for `gen build` and `gen emulate`. From
    runs: a rules file for `gen thresholds`, which fills in the rules' numbers; with COEFFS beside the runs for the
    parts of that model.

    Every pin and every rule says in its note why it is so; what no file can tell is marked TO BE SET.
    """
    from gen.coefficients import check_form, load
    from gen.files import check_outputs, write_text
    from gen.runs import check_head, check_run

    check_outputs((out,), files)
    check_once(files)
    models = [path for path in files if _is_json(path)]
    runs = [path for path in files if path not in models]
    if len(models) > 1:
        raise InputError("is a second coefficient file; expected one at most", file=str(models[1]))
    for path in models:
        check_form(path)
    for path in runs:
        check_head(path)
    coefficients = load(models[0]) if models else None
    for path in runs:
        if path.is_file():  # a pipe can be read only once
            check_run(path)
    if coefficients is not None and not runs:
        text, said = _completed(coefficients, models[0])
    else:
        text, said = _rules(coefficients, runs, [shown_name(path) for path in files])
    write_text(out, text)
    for line in said:
        click.echo(line)


def _is_json(path: Path) -> bool:
    """Whether a file holds an object of JSON: a run file cannot begin so."""
    if not path.is_file():
        return path.suffix.lower() == ".json"
    with path.open("rb") as stream:
        return stream.read(4096).removeprefix(b"\xef\xbb\xbf").lstrip()[:1] == b"{"


def _completed(coefficients: Coefficients, path: Path) -> tuple[str, list[str]]:
    """The coefficient file with what it lacks."""
    from gen.coefficients import parse
    from gen.coefficients.writer import with_start
    from gen.proposal.motor import of_model
    from gen.proposal.pins import wiring_for
    from gen.proposal.rules import complete_rules

    document = coefficients.document
    if document.wiring is not None and document.alarms:
        raise InputError("has wiring and alarm rules already; there is nothing to start", file=str(path), place="$")
    motor = of_model(coefficients)
    try:
        wiring = wiring_for(motor, shown_name(path)) if document.wiring is None else None
        rules = complete_rules(motor, coefficients) if not document.alarms else None
        text = with_start(path.read_text(encoding="utf-8-sig"), wiring, rules)
        made = parse(text.encode())
    except InputError as error:
        raise InputError(error.message, file=str(path), place=error.place) from error
    said = [f"warning: {warning}" for warning in made.warnings]
    if rules is not None and not any(rule.kind == "above_model" for rule in rules):
        said.append(
            "no rule compares with the model: the file declares no error (provenance.error); see gen thresholds"
        )
    return text, [*_told(wiring, rules), *said, "next: set what is marked TO BE SET, then gen build"]


def _rules(coefficients: Coefficients | None, runs: list[Path], names: list[str]) -> tuple[str, list[str]]:
    """A rules file for `gen thresholds`."""
    from gen.coefficients.rules import LEAST_HOURS
    from gen.coefficients.writer import rules_text
    from gen.proposal.motor import of_runs
    from gen.proposal.pins import wiring_for
    from gen.proposal.rules import enough_for_heat, open_rules

    motor = of_runs(runs, coefficients)
    try:
        wiring = wiring_for(motor, ", ".join(names))
    except InputError as error:
        raise InputError(error.message, file=error.file or str(runs[0]), place=error.place) from error
    rules = open_rules(motor)
    following = "next: set what is marked TO BE SET, then gen thresholds COEFFS HEALTHY_RUN... --rules with this file"
    left_out = [f"{column}: left out, as its name cannot be a column of the board's" for column in motor.left_out]
    said = [*_told(wiring, rules), *left_out]
    if not enough_for_heat(motor):
        said.append(
            f"no rule on missing heat, which hears a fault in minutes: its rate of false alarms wants "
            f"{LEAST_HOURS:g} h of the healthy motor, and these runs last {motor.hours:.1f} h"
        )
    return rules_text(wiring, rules), [*said, following]


def _told(wiring: Wiring | None, rules: Sequence[RuleDraft] | None) -> list[str]:
    told = []
    if wiring is None:
        told.append("wiring: kept as it is")
    else:
        chips = ", ".join(
            f"{chip.channel} ({f'pin {chip.analog_pin}' if chip.chip == 'NTC' else f'CS {chip.cs}'})"
            for chip in wiring.thermocouples
        )
        told.append(f"thermocouples: {chips}")
        told += [f"channel {channel.column}: analog pin {channel.analog_pin}" for channel in wiring.channels]
        told += [f"encoder: pin {wiring.encoder.pin}"] if wiring.encoder is not None else []
    if rules is None:
        told.append("alarm rules: kept as they are")
    else:
        told.append(f"alarm rules: {', '.join(rule.name for rule in rules)}")
    return told
