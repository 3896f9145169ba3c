"""`gen thresholds`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from gen.commands.options import COEFFICIENTS, check_files, check_once
from gen.errors import InputError

_PATH = click.Path(path_type=Path)
_TAKEN_OVER = ("name", "description", "wiring")


@click.command(
    short_help="Derive alarm thresholds from runs of the healthy motor.",
    epilog="Example:  gen thresholds identified.json --rules rules.json healthy_*.csv --out coeffs.json",
)
@COEFFICIENTS
@click.argument("runs", metavar="RUN...", nargs=-1, required=True, type=_PATH)
@click.option("--rules", type=_PATH, required=True, help="JSON: alarms without thresholds, and optionally the wiring.")
@click.option("--out", type=_PATH, required=True, help="The coefficient file to write.")
def thresholds(coefficients: Path, runs: tuple[Path, ...], rules: Path, out: Path) -> None:
    """Derive alarm thresholds from runs of the healthy motor that took no part in the identification.

    The runs should show all that is normal: cold and warm starts, every speed, changing speed, an ambient that
    moves, the usual load.
    The error bands in the written file are the healthy motor's; thresholds that the rules leave out lie a margin
    beyond.
    """
    from gen.coefficients import load, parse
    from gen.files import check_outputs, write_text
    from gen.runs import check_run, read_run

    check_outputs((out,), (*runs, rules))
    check_once(runs)
    check_files(coefficients, runs)
    loaded = load(coefficients)
    wanted = _rules(rules, loaded.model.component_names)
    for path in runs:
        if path.is_file():  # a pipe can be read only once
            check_run(path)

    # Slow to import: what is wrong with a file was told before.
    from gen.thresholds.derive import complete, error_bands
    from gen.thresholds.healthy import compare

    healthy = []
    for path in runs:
        run = read_run(path, loaded.model.component_names, ambient=loaded.model.ambient_channel or "ambient_degC")
        healthy.append(compare(loaded, run, str(path)))
    tree: dict[str, Any] = _json(coefficients)
    tree |= {key: wanted[key] for key in _TAKEN_OVER if key in wanted}
    tree.setdefault("provenance", {"source": "gen thresholds"})["error"] = error_bands(loaded.document, healthy)
    tree["alarms"] = []
    try:
        for number, rule in enumerate(wanted["alarms"]):
            try:
                tree["alarms"].append(complete(rule, loaded.document, healthy))
            except InputError as error:
                raise InputError(error.message, place=f"$.alarms[{number}]") from error
        text = json.dumps(tree, indent=1, ensure_ascii=False) + "\n"
        made = parse(text.encode())
    except InputError as error:
        raise InputError(error.message, file=error.file or str(rules), place=error.place) from error
    write_text(out, text)
    provenance = loaded.document.provenance
    learnt = {Path(name).name for name in provenance.data} if provenance is not None else set()
    for path in runs:
        if path.name in learnt:
            click.echo(
                f"warning: {path}: a run of this name taught the model ($.provenance.data); on it the model is better "
                "than on others, and thresholds come out too narrow",
                err=True,
            )
    for rule in made.document.alarms:
        click.echo(f"{rule.name}: {rule.note or 'as written'}")
    for warning in made.warnings:
        click.echo(f"warning: {warning}", err=True)
    click.echo(f"{out}: {len(made.document.alarms)} rules from {len(healthy)} healthy runs")


def _json(path: Path) -> Any:  # noqa: ANN401
    from gen.coefficients.jsontext import parse

    try:
        return parse(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8"
        raise InputError(f"cannot be read: {reason}", file=str(path)) from error
    except InputError as error:
        raise InputError(error.message, file=str(path), place=error.place) from error


def _rules(path: Path, components: Sequence[str]) -> dict[str, Any]:
    """Read a rules file, as far as thresholds are derived from it; the finished rules are checked with the whole."""
    from gen.coefficients.base import listed

    tree = _json(path)
    if not isinstance(tree, dict) or not isinstance(tree.get("alarms"), list):
        raise InputError('expected an object with "alarms", a list of rules', file=str(path), place="$")
    for key in tree:
        if key not in ("alarms", *_TAKEN_OVER):
            expected = listed(["alarms", *_TAKEN_OVER])
            raise InputError(f'unknown key "{key}"; expected {expected}', file=str(path), place="$")
    if not all(isinstance(rule, dict) for rule in tree["alarms"]):
        raise InputError("expected a list of objects", file=str(path), place="$.alarms")
    for number, rule in enumerate(tree["alarms"]):
        for key in ("component", "relative_to"):
            if (key == "component" or rule.get(key) is not None) and rule.get(key) not in components:
                raise InputError(
                    f"expected the name of a component: {listed(list(components))}",
                    file=str(path),
                    place=f"$.alarms[{number}].{key}",
                )
    return tree
