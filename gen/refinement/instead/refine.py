"""`gen refine` on a file with transfer functions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from gen.coefficients import Coefficients, parse
from gen.refinement.instead.network import Instead, network_instead
from gen.refinement.network.refine import NetworkRefinement, refine_network
from gen.refinement.parts.refine import Refinement, refine
from gen.refinement.verdict import Verdict
from gen.refinement.worse import got_worse, lowered, told_worse

ENOUGH: tuple[Verdict, ...] = ("explained", "nothing missing")
_OF_THE_MOTOR: dict[Verdict, Verdict] = {"nothing missing": "explained", "unexplained": "partly explained"}
"""What the verdict on the network alone is for the file's motor: what was missing was the network."""


@dataclass(frozen=True, eq=False)
class RefinedAsNetwork(NetworkRefinement):
    """All that a refinement found, where one network took the place of a file's transfer functions.

    `before` is of the file, all else of the network.

    Attributes
    ----------
    instead
        The network before anything was traced in it, and how it compares with the parts.
    """

    instead: Instead = field(kw_only=True)

    @property
    def lead(self) -> str:
        """What took the parts' place, and why."""
        return self.instead.sentence

    def summary(self) -> dict[str, Any]:
        """The JSON summary."""
        return super().summary() | {"instead_of_parts": self.instead.summary()}


def refine_parts(
    baseline: Coefficients,
    raw: str,
    fit_paths: Sequence[Path],
    test_paths: Sequence[Path],
    progress: Callable[[str], None],
    *,
    accept_change: bool = False,
) -> Refinement | NetworkRefinement:
    """Trace the error part by part; where that does not explain it, see whether one network for the motor does.

    Parameters
    ----------
    baseline, raw
        The coefficient file, and its text.
    fit_paths, test_paths
        Run files; none may be in both.
    progress
        Called with what is being done.
    accept_change
        Write a network, too, that settles elsewhere than the file.

    Raises
    ------
    InputError
        For files that are no runs, before anything is fitted; or for no admitted run to fit.
    """
    by_parts = refine(baseline, raw, fit_paths, test_paths, progress)
    if by_parts.verdict in ENOUGH:
        return by_parts
    refined = parse(by_parts.text.encode()) if by_parts.effects else baseline
    kept = [Path(run.name) for run in by_parts.runs]
    instead = network_instead(baseline, raw, refined, kept, progress)
    if instead is None:
        return by_parts
    if instead.elsewhere and not accept_change:
        said = f"{instead.sentence}. It is not written without --accept-change, since it would learn a fault, too: "
        return replace(by_parts, warnings=[*by_parts.warnings, said + instead.other_motor])
    found = refine_network(instead.coefficients, instead.text, kept, test_paths, progress, accept_change=accept_change)
    return _of_the_motor(by_parts, instead, found)


def _of_the_motor(by_parts: Refinement, instead: Instead, found: NetworkRefinement) -> RefinedAsNetwork:
    """What was found in the network, told beside the file with transfer functions that it takes the place of."""
    verdict = _OF_THE_MOTOR.get(found.verdict, found.verdict)
    worse = got_worse(by_parts.before, found.after)
    made = {one.name: getattr(found, one.name) for one in fields(found)}
    made |= {
        "before": by_parts.before,
        "verdict": lowered(verdict) if worse else verdict,
        "warnings": [
            *([instead.other_motor] if instead.elsewhere else []),
            *instead.warnings,
            *found.warnings,
            *(told_worse(by_parts.before, found.after) if worse else []),
        ],
    }
    return RefinedAsNetwork(**made, instead=instead)
