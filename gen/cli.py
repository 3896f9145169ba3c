"""The commands: parse, call, print; no logic."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import click

from gen import __version__
from gen.commands.refine import refine
from gen.errors import CheckFailed, InputError

if TYPE_CHECKING:
    from gen.lowering.program import Arithmetic, ScheduleKind
    from gen.reference.simulate import Start
    from gen.verify.verify import Target

# The matrices are small: threads of the linear algebra library would only wait for each other. Set before numpy loads.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

_CommandType = TypeVar("_CommandType", bound=Callable[..., Any])
_COEFFICIENTS = click.argument("coefficients", metavar="COEFFS", type=click.Path(path_type=Path))


def _options(*, default_all: bool) -> Callable[[_CommandType], _CommandType]:
    """--arithmetic and --schedule, with `all` where several can be handled at once."""
    arithmetic = ["fixed", "float", "all"] if default_all else ["fixed", "float"]
    schedule = ["table", "onboard", "all"] if default_all else ["table", "onboard"]

    def decorate(command: _CommandType) -> _CommandType:
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


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="gen")
def cli() -> None:
    """Turn identified motor-temperature coefficients into proven firmware for the Arduino Mega 2560."""


@cli.command(epilog="Example:  gen build examples/my1016/coeffs.json --out firmware_out")
@_COEFFICIENTS
@click.option("--out", type=click.Path(path_type=Path), default=Path("firmware_out"), show_default=True)
@click.option(
    "--verification",
    type=click.Path(path_type=Path),
    help="What `gen verify --json` wrote: its verdict goes into the report. Default: the one in --out.",
)
@_options(default_all=False)
def build(
    coefficients: Path, out: Path, verification: Path | None, arithmetic: Arithmetic, schedule: ScheduleKind
) -> None:
    """Write the complete PlatformIO project for a coefficient file."""
    from gen.coefficients import load
    from gen.files import replace_folder
    from gen.firmware.project import kept_verification, project_files, read_verification
    from gen.lowering.lower import lower

    loaded = load(coefficients)
    for warning in loaded.warnings:
        click.echo(f"warning: {coefficients}: {warning}", err=True)
    record = read_verification(verification, loaded) if verification else kept_verification(out, loaded)
    program = lower(loaded, arithmetic, schedule)
    replace_folder(out, project_files(loaded, program, coefficients.name, record))
    from gen.firmware.context import bound_text

    click.echo(f"{out}: {loaded.name}, arithmetic {arithmetic}, schedule {schedule}")
    for component in program.components:
        click.echo(f"  {component.name}: never more than {bound_text(component)} from the exact solution")


@cli.command(epilog="Example:  gen verify examples/my1016/coeffs.json --target all --json verification.json")
@_COEFFICIENTS
@_options(default_all=True)
@click.option("--target", type=click.Choice(["host", "avr", "all"]), default="all", show_default=True)
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="Write what was found as JSON.")
@click.option(
    "--scale", type=click.FloatRange(0.001, 10.0), default=1.0, help="Share of the full campaign.", hidden=True
)
def verify(
    coefficients: Path,
    arithmetic: Arithmetic | Literal["all"],
    schedule: ScheduleKind | Literal["all"],
    target: Target,
    json_file: Path | None,
    scale: float,
) -> None:
    """Prove the generated C++ equal to the reference, bit for bit, and measure error and cost."""
    from gen.coefficients import load
    from gen.files import write_text
    from gen.verify.report import print_results
    from gen.verify.verify import summary
    from gen.verify.verify import verify as run

    loaded = load(coefficients)
    arithmetics: tuple[Arithmetic, ...] = ("fixed", "float") if arithmetic == "all" else (arithmetic,)
    schedules: tuple[ScheduleKind, ...] = ("table", "onboard") if schedule == "all" else (schedule,)
    with _progress() as progress:
        results = run(loaded, arithmetics, schedules, target, progress=progress, scale=scale)
    found = summary(loaded, results)
    if json_file is not None:
        write_text(json_file, json.dumps(found, indent=1) + "\n")
    print_results(results)
    if found["verdict"] != "equal":
        raise CheckFailed(f"{found['differing']} of {found['words']} words differ")
    click.echo(f"equal: {found['samples']} samples, {found['words']} words, none differs")


@cli.command(epilog="Example:  gen simulate examples/my1016/coeffs.json run.csv --arithmetic fixed --out model.csv")
@_COEFFICIENTS
@click.argument("run", type=click.Path(path_type=Path))
@click.option("--arithmetic", type=click.Choice(["exact", "fixed", "float"]), default="exact", show_default=True)
@click.option("--start", type=click.Choice(["auto", "ambient", "measured"]), default="auto", show_default=True)
@click.option("--out", type=click.Path(path_type=Path), help="The CSV to write.  [default: RUN with .model.csv]")
def simulate(
    coefficients: Path, run: Path, arithmetic: Arithmetic | Literal["exact"], start: Start, out: Path | None
) -> None:
    """Run the reference simulator on a run file and write the model's temperatures at the run's own times."""
    from gen.coefficients import load
    from gen.reference.simulate import simulate_run
    from gen.runs import read_run
    from gen.runs.writer import write_columns

    loaded = load(coefficients)
    measured = read_run(run, loaded.model.component_names, ambient=loaded.model.ambient_channel or "ambient_degC")
    columns = simulate_run(loaded, measured, arithmetic, start, str(run))
    target = out or run.with_suffix(".model.csv")
    write_columns(target, columns, {"model": loaded.name, "arithmetic": arithmetic})
    click.echo(f"{target}: {len(measured.time_s)} rows")


cli.add_command(refine)


@contextmanager
def _progress() -> Iterator[Callable[[str], None]]:
    """A line that says what is being done, on a terminal only."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda _: None
        return
    with console.status("") as status:
        yield lambda text: status.update(text)


def main() -> None:
    """Run the command line; turn failures into one message and an exit status."""
    try:
        cli.main(standalone_mode=False)
    except click.exceptions.Abort:
        click.echo("interrupted", err=True)
        sys.exit(130)
    except click.ClickException as error:
        error.show()
        sys.exit(2)
    except click.exceptions.Exit as error:
        sys.exit(error.exit_code)
    except InputError as error:
        click.echo(f"error: {error}", err=True)
        sys.exit(2)
    except CheckFailed as error:
        click.echo(f"failed: {error}", err=True)
        sys.exit(1)
