"""Print what a verification found."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich.console import Console
from rich.table import Table

from gen.lowering.recursion.guarantee import rounded_up
from gen.verification.verify import CombinationResult


def print_results(results: Sequence[CombinationResult]) -> None:
    """Tables of equality, error and cost on standard output."""
    console = Console(width=110)
    console.print(_equality(results))
    for sentence in _mismatches(results):
        console.print(sentence, markup=False)
    console.print(_errors(results))
    for result in results:
        if result.refuted is not None:
            console.print(f"{result.label}, the guarantee does not follow from the C++: {result.refuted}", markup=False)
        for sentence in result.exceeded:
            console.print(f"{result.label}, {sentence}", markup=False)
    for table in (_costs(results), _effects(results)):
        if table.row_count:
            console.print(table)


def _equality(results: Sequence[CombinationResult]) -> Table:
    table = Table("combination", "target", "samples", "words", "differing", title="Equality with the reference")
    for result in results:
        for target in result.targets:
            table.add_row(result.label, target.target, *map(str, (target.samples, target.words, target.differing)))
    return table


def _mismatches(results: Sequence[CombinationResult]) -> Iterator[str]:
    """What differs first, and the short profile that shows it."""
    for result in results:
        for target in result.targets:
            if target.mismatch is not None and target.profile is not None:
                yield f"{result.label}, {target.target}: {target.mismatch}"
                yield f"  start {target.profile['start_mK']} mK, PWM {target.profile['pwm']}"


def _errors(results: Sequence[CombinationResult]) -> Table:
    heads = ("combination", "component", "measured K", "guaranteed K", "proven anew K")
    table = Table(*heads, title="Error against the exact solution")
    for result in results:
        for name, measured in result.error_K.items():
            bound = result.bound_K[name]
            guaranteed = "none proven" if bound is None else f"{rounded_up(bound):.1e}"
            proven = f"{rounded_up(result.proven_K[name]):.1e}" if name in result.proven_K else "-"
            table.add_row(
                result.label,
                name,
                f"{rounded_up(measured):.1e}",
                guaranteed,
                proven if result.refuted is None else "refuted",
            )
    return table


def _costs(results: Sequence[CombinationResult]) -> Table:
    heads = ("combination", "cycles, PWM held", "with a change", "flash B", "RAM B", "stack B", "helpers")
    table = Table(*heads, title="Cost on the board")
    for result in results:
        cost = result.cost
        if cost is not None:
            numbers = (cost.cycles_constant, cost.cycles_change, cost.flash_bytes, cost.ram_bytes, cost.stack_bytes)
            table.add_row(result.label, *map(str, numbers), ", ".join(result.helpers) or "none")
    return table


def _effects(results: Sequence[CombinationResult]) -> Table:
    table = Table("combination", "effect", "component", "cycles", "flash B", "RAM B", title="Cost of each effect")
    for result in results:
        for part in result.effects:
            numbers = (part.cycles, part.flash_bytes, part.ram_bytes)
            table.add_row(result.label, part.name, part.component, *map(str, numbers))
    return table
