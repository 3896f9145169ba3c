"""Networks on the board: words compared, error guaranteed, proven anew and measured, cycles, flash and RAM.

    python -m benchmarks.networks [COEFFS ...] [--scale 1.0] [--json FILE]

Without COEFFS: the simulated motor's network as `gen identify` finds it, the example with a fan and copper loss
that grows with temperature, and one of ten nodes. Each is what `gen verify --target all` finds, in both arithmetics.
Flash is of the whole model with its tables; cycles are of a sample, the most of all, on the emulated ATmega2560.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from rich.box import MARKDOWN
from rich.console import Console
from rich.table import Table

import gen
from gen.coefficients import Coefficients, load
from gen.lowering.recursion.guarantee import rounded_up
from gen.verification.verify import CombinationResult, verify

ROOT = Path(__file__).parent.parent
EXAMPLES = tuple(
    ROOT / "examples" / name
    for name in (
        "my1016_rig/network.json",
        "network/coeffs.json",
        "ten_nodes/coeffs.json",
        "natural_cooling/coeffs.json",
    )
)
HEAD = (
    "network", "nodes", "paths", "arithmetic", "words", "differ", "guaranteed (K)", "proven anew (K)", "measured (K)",
    "cycles", "flash", "RAM",
)  # fmt: skip


def row(coefficients: Coefficients, result: CombinationResult) -> list[str]:
    """One line of the table."""
    network, cost = coefficients.model.network, result.cost
    assert network is not None
    assert cost is not None
    bounds = [bound for bound in result.bound_K.values() if bound is not None]
    return [
        coefficients.name,
        f"{len(network.nodes)} ({len(network.hidden)} hidden)",
        str(len(network.paths)),
        result.arithmetic,
        f"{sum(target.words for target in result.targets):,}",
        str(sum(target.differing for target in result.targets)),
        f"{rounded_up(max(bounds)):.1e}",
        f"{rounded_up(max(result.proven_K.values())):.1e}" if result.proven_K else result.refuted or "not checked",
        f"{rounded_up(max(result.error_K.values())):.1e}",
        f"{max(cost.cycles_constant, cost.cycles_change):,}",
        f"{cost.flash_bytes:,}",
        f"{cost.ram_bytes:,}",
    ]


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("coeffs", type=Path, nargs="*", default=list(EXAMPLES))
    parser.add_argument("--scale", type=float, default=1.0, help="share of gen verify's campaign")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args(arguments)
    console = Console(width=200)
    table = Table(*HEAD, box=MARKDOWN)
    found = []
    for path in options.coeffs:
        coefficients = load(path)
        for result in verify(coefficients, ("fixed", "float"), ("table",), "all", scale=options.scale):
            table.add_row(*row(coefficients, result))
            found.append({"network": coefficients.name, **asdict(result)})
    console.print(f"gen {gen.__version__}", table)
    if options.json:
        options.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
