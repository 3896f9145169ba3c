"""Arguments and options that several commands share."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click

from gen.errors import InputError

CommandType = TypeVar("CommandType", bound=Callable[..., Any])
COEFFICIENTS = click.argument("coefficients", metavar="COEFFS", type=click.Path(path_type=Path))


class Finite(click.FloatRange):
    """A number in a range: not infinite, and not NaN, which every comparison lets through."""

    def convert(
        self,
        value: Any,  # noqa: ANN401 - as click has it
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> float:
        """Refuse what is no finite number of the range."""
        number = float(super().convert(value, param, ctx))
        if not math.isfinite(number):
            self.fail(f"{value} is not a finite number.", param, ctx)
        return number


AMBIENT = click.option(
    "--ambient", type=Finite(-273.15, 1000.0), help="Ambient in degC for runs without an ambient_degC column."
)


def check_files(coefficients: Path, runs: Sequence[Path]) -> None:
    """Find what is wrong with a coefficient file's form and with the runs' heads before anything slow is imported.

    Raises
    ------
    InputError
        With the first fault, its file and its place.
    """
    from gen.coefficients import check_form
    from gen.runs import check_head

    check_form(coefficients)
    for path in runs:
        check_head(path)


def check_once(runs: Sequence[Path]) -> None:
    """Refuse a run that is given twice: it would count as evidence of its own.

    Raises
    ------
    InputError
        With the run's name.
    """
    seen: set[Path] = set()
    for path in runs:
        if path.resolve() in seen:
            raise InputError("is given twice; expected each run once", file=str(path))
        seen.add(path.resolve())


def combination(*, default_all: bool) -> Callable[[CommandType], CommandType]:
    """--arithmetic and --schedule, with `all` where several can be handled at once."""
    arithmetic = ["fixed", "float", "all"] if default_all else ["fixed", "float"]
    schedule = ["table", "onboard", "all"] if default_all else ["table", "onboard"]

    def decorate(command: CommandType) -> CommandType:
        command = click.option(
            "--schedule",
            type=click.Choice(schedule),
            default="all" if default_all else "table",
            show_default=True,
            help="Coefficients of every PWM in flash, or evaluated on the board when PWM changes.",
        )(command)
        return click.option(
            "--arithmetic",
            type=click.Choice(arithmetic),
            default="all" if default_all else "fixed",
            show_default=True,
            help="Fixed-point integers or float32.",
        )(command)

    return decorate
