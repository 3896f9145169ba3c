"""Which kind is taken: a network that is good; else by what the other refuses or lacks, then by left-out error.

Within chance the network is taken, because its guarantee is the better founded. Its equations hold for every sequence
of PWM and room: heat is neither made nor lost and flows from warm to cold only, so nothing rings, and a room that moves
passes through the parts' masses. K/A(s) at each speed promises nothing between the speeds, nor for the moment at which
speed changes. And the error that a network's file declares is that on data that took no part in its fit, widened by
what the runs leave open; that of parts is what they miss in their own runs, widened by what lies between the speeds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gen.identification.choice.compared import KINDS, NETWORK, PARTS, Comparison, Kind

WORTH = 1.05
"""Parts have to be better by this factor, too: what is sure may still be next to nothing."""


@dataclass(frozen=True)
class Tried:
    """What came of one kind, fitted to all runs.

    Attributes
    ----------
    components
        The parts that its model has; none where it refused.
    refused
        Why there is no model; empty where there is one.
    """

    components: tuple[str, ...] = ()
    refused: str = ""


@dataclass(frozen=True)
class Decision:
    """What was taken, and why.

    Attributes
    ----------
    kind
        Which.
    why
        In one sentence.
    compared
        On what was left out; None where nothing had to be, or could be, compared.
    left_out
        What was: ``run`` or ``stretch``, or nothing.
    refused
        Why the other kind has no model; empty where it has.
    lacks
        Parts that the other kind leaves out.
    """

    kind: Kind
    why: str
    compared: Comparison | None = None
    left_out: str = ""
    refused: str = ""
    lacks: tuple[str, ...] = ()

    @property
    def note(self) -> str:
        """For the file's provenance."""
        return f"Chosen: {self.why}"

    def as_json(self) -> dict[str, Any]:
        """Everything as plain numbers and words."""
        made: dict[str, Any] = {
            "kind": self.kind,
            "why": self.why,
            "refused": self.refused,
            "lacks": list(self.lacks),
            "left_out": self.left_out,
        }
        if self.compared is not None:
            made["error_K"] = dict(self.compared.error_K)
            made["error_by_run_K"] = {kind: list(of) for kind, of in self.compared.by_run.items()}
            made["parts_over_network"] = self.compared.ratio
            made["parts_over_network_interval"] = list(self.compared.interval)
        return made


def good_enough(error_K: float) -> Decision:
    """Take a network that is good on what was left out, to so many kelvins, without anything to compare it with."""
    said = f"data that took no part in its fit are predicted to {error_K:.2g} K, which is good"
    return Decision(NETWORK, f"network, because {said}; parts were not tried")


def told_without_folds(tried: Mapping[Kind, Tried]) -> Decision | None:
    """Decide by what one refuses or lacks; None where that does not tell."""
    for kind, other in (KINDS, KINDS[::-1]):
        if tried[other].refused and not tried[kind].refused:
            refused = tried[other].refused
            return Decision(kind, f"{kind}, because {_NAMED[other]} refused: {refused}", refused=refused)
        missing = tuple(name for name in tried[kind].components if name not in tried[other].components)
        if missing and set(tried[other].components) < set(tried[kind].components):
            return Decision(kind, f"{kind}, because {_NAMED[other]} left out {', '.join(missing)}", lacks=missing)
    return None


def decided(compared: Comparison | None, left_out: str, untried: int) -> Decision:
    """Decide by what both err by on what was left out.

    Parameters
    ----------
    compared
        Both kinds; None where nothing could be left out.
    left_out
        What was: ``run`` or ``stretch``.
    untried
        How many more could have been left out, but could not have changed the choice.
    """
    if compared is None:
        return Decision(NETWORK, f"network, because no data could be left out to compare it with parts; {_FOUNDED}")
    better = compared.interval[1] < 1.0 and compared.ratio * WORTH < 1.0
    kind = PARTS if better else NETWORK
    return Decision(kind, f"{kind}, because {_said(compared, left_out, untried)}", compared, left_out)


_NAMED: Mapping[Kind, str] = {NETWORK: "the network", PARTS: "parts"}
_FOUNDED = "its guarantee is the better founded"


def _said(compared: Comparison, left_out: str, untried: int) -> str:
    count = compared.logs.size
    whole = count + untried
    several = {"run": "runs", "stretch": "stretches"}[left_out] if whole > 1 else left_out
    of = f"{count} of {whole}" if untried else str(count)
    errors = f"parts err by {compared.error_K[PARTS]:.2f} K, the network by {compared.error_K[NETWORK]:.2f} K"
    said = f"on {of} {several} left out {errors} ({compared.ratio:.2f} times"
    low, high = compared.interval
    said += f", 95 %: {low:.2f} to {high:.2f})" if count > 1 else ")"
    if low > 1.0:
        return said
    if untried:
        return f"{said}, which the others could not turn"
    if high < 1.0 and compared.ratio * WORTH < 1.0:
        return said
    return f"{said}: within chance, and {_FOUNDED}"
