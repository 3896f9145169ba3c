"""Print what a verification found."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from gen.lowering.recursion.guarantee import rounded_up
from gen.verification.verify import CombinationResult


def print_results(results: Sequence[CombinationResult]) -> None:
    """Tables of equality, error and cost on standard output."""
    console = Console(width=110)
    equality = Table("combination", "target", "samples", "words", "differing", title="Equality with the reference")
    for result in results:
        for target in result.targets:
            equality.add_row(
                result.label,
                target.target,
                str(target.samples),
                str(target.words),
                str(target.differing),
            )
    console.print(equality)
    for result in results:
        for target in result.targets:
            if target.mismatch is not None and target.profile is not None:
                pwm = target.profile["pwm"]
                console.print(f"{result.label}, {target.target}: {target.mismatch}", markup=False)
                console.print(f"  start {target.profile['start_mK']} mK, PWM {pwm}", markup=False)
    error = Table("combination", "component", "measured K", "guaranteed K", title="Error against the exact solution")
    for result in results:
        for name, measured in result.error_K.items():
            bound = result.bound_K[name]
            error.add_row(
                result.label,
                name,
                f"{rounded_up(measured):.1e}",
                "none proven" if bound is None else f"{rounded_up(bound):.1e}",
            )
    console.print(error)
    for result in results:
        for sentence in result.exceeded:
            console.print(f"{result.label}, {sentence}", markup=False)
    cost = Table(
        "combination",
        "cycles, PWM held",
        "with a change",
        "flash B",
        "RAM B",
        "stack B",
        "helpers",
        title="Cost on the Mega",
    )
    for result in results:
        if result.cost is not None:
            cost.add_row(
                result.label,
                str(result.cost.cycles_constant),
                str(result.cost.cycles_change),
                str(result.cost.flash_bytes),
                str(result.cost.ram_bytes),
                str(result.cost.stack_bytes),
                ", ".join(result.helpers) or "none",
            )
    if cost.row_count:
        console.print(cost)
    parts = Table("combination", "effect", "component", "cycles", "flash B", "RAM B", title="Cost of each effect")
    for result in results:
        for part in result.effects:
            numbers = (part.cycles, part.flash_bytes, part.ram_bytes)
            parts.add_row(result.label, part.name, part.component, *map(str, numbers))
    if parts.row_count:
        console.print(parts)
