"""`gen verify`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from gen.commands.options import COEFFICIENTS, Finite, combination
from gen.progress import progress_line
from gen.toolchain import HOST_COMPILERS, PACKAGES, host_compilers

if TYPE_CHECKING:
    from gen.coefficients.wiring import BoardName
    from gen.lowering.kinds import Arithmetic, ScheduleKind
    from gen.verification.verify import Target


@click.command(
    short_help="Prove the generated C++ equal to the reference.",
    epilog="Example:  gen verify examples/my1016/coeffs.json --target all --json verification.json",
)
@COEFFICIENTS
@combination(default_all=True)
@click.option("--target", type=click.Choice(["host", "avr", "all"]), default="all", show_default=True)
@click.option(
    "--board",
    type=click.Choice(["mega", "uno"]),
    help="Which is emulated, with the library alone.  [default: the file's own, $.wiring.board]",
)
@click.option(
    "--compilers",
    metavar="NAME,...",
    callback=lambda _context, _option, text: _names(text),
    help=f"Of this computer, {' or '.join(HOST_COMPILERS)}; each must be there.  [default: those that are there]",
)
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="Write what was found as JSON.")
@click.option("--scale", type=Finite(0.001, 10.0), default=1.0, help="Share of the full campaign.", hidden=True)
def verify(
    coefficients: Path,
    arithmetic: Arithmetic | Literal["all"],
    schedule: ScheduleKind | Literal["all"],
    target: Target,
    board: BoardName | None,
    compilers: tuple[str, ...],
    json_file: Path | None,
    scale: float,
) -> None:
    """Prove the generated C++ equal to the reference, bit for bit, and measure error and cost.

    On this computer (--target host) with g++ and clang++, or with the one that is there; on an emulated Mega
    (--target avr) with avr-g++, or on an emulated Uno, if there is room for the library.
    """
    from gen.files import check_outputs
    from gen.interface import load
    from gen.interface import verify as run

    check_outputs((json_file,), (coefficients,))
    used = _compilers(target, compilers)
    model = load(coefficients)  # before what is slow to import: a fault in the file is told at once
    with progress_line() as progress:
        found = run(
            model,
            arithmetic=arithmetic,
            schedule=schedule,
            target=target,
            compilers=used,
            board=board,
            scale=scale,
            progress=progress,
        )
    if json_file is not None:
        found.save(json_file)

    from gen.verification.report import print_results

    print_results(found.results)
    found.check()
    record = found.details()
    click.echo(f"equal: {record['samples']} samples, {record['words']} words, none differs")


def _names(text: str | None) -> tuple[str, ...]:
    names = tuple(name.strip() for name in text.split(",")) if text is not None else ()
    for name in names:
        if name not in HOST_COMPILERS:
            raise click.BadParameter(f'found "{name}", expected {" or ".join(HOST_COMPILERS)}')
    return names


def _compilers(target: Target, asked: tuple[str, ...]) -> list[str]:
    """Those to run; says which is missing, unless the user chose."""
    if target == "avr":
        if asked:
            raise click.UsageError("--compilers is of no use with --target avr: the firmware's is avr-g++")
        return []
    found = host_compilers(asked)
    for name in () if asked else HOST_COMPILERS:
        if name not in found:
            click.echo(
                f"warning: {name} is missing (Debian package {PACKAGES[name]}): verified with {', '.join(found)} only",
                err=True,
            )
    return found
