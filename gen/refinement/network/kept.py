"""Which of the effects that were found are named, and which are written."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gen.refinement.network.effects import NetworkEffect, PathChange
from gen.refinement.network.effects.walls import Walls
from gen.refinement.network.over_time.missing_heat import MissingHeat, missing_heat
from gen.refinement.network.tracing.changed import has_grown, looks_like_a_change
from gen.refinement.network.tracing.search import Step
from gen.refinement.network.tracing.trace import Traced

WALLS_ALONE = (
    "ambient: walls that lag behind the air were found, but a fixed ambient predicts as well as these and the measured "
    "air together, so nothing is written"
)
NOT_ACCEPTED = "It is not written into the model without --accept-change"
ACCEPTED = "It is written into the model, as --accept-change asks"
NOT_HELD = "No file holds it"
STANDS_FOR_IT = 0.7
"""Left-out error over that without any effect, above which what was found may as well stand for what comes and goes."""


@dataclass(frozen=True, eq=False)
class Kept:
    """What becomes of the effects that were found.

    Attributes
    ----------
    changes
        Of each in turn why it may be another motor, and whether that is written; empty for an effect.
    named
        Of each in turn whether it is named.
    effects
        Those to write.
    missing
        The heat over time that would explain what is left, where much is.
    alone
        Walls were found whose air the file holds for fixed, so that nothing is written.
    """

    changes: tuple[str, ...]
    named: tuple[bool, ...]
    effects: tuple[NetworkEffect, ...]
    missing: MissingHeat | None
    alone: bool

    @property
    def parts_runs(self) -> bool:
        """Whether what is written would be the mean of runs that do not share it."""
        return self.missing is not None and self.missing.parts_runs and bool(self.effects)

    @property
    def holds(self) -> bool:
        """Whether a file may hold all that was found."""
        return not self.alone and not any(self.changes)

    @property
    def warnings(self) -> list[str]:
        """Why effects are not written, and what is missing beside them, a sentence each."""
        beside = [] if self.missing is None or self.missing.parts_runs else [effect.name for effect in self.effects]
        made = [WALLS_ALONE] if self.alone else []
        made += [] if self.missing is None else self.missing.warnings(beside)
        return made + [change for change, told in zip(self.changes, self.named, strict=True) if change and told]


def kept(traced: Traced, names: Sequence[str], *, fixed_ambient: bool, accept_change: bool) -> Kept:
    """Sort what was found.

    Parameters
    ----------
    traced
        It.
    names
        Of the later runs.
    fixed_ambient
        Whether the file is to hold the ambient for fixed.
    accept_change
        Write what looks like another motor, too.
    """
    values = traced.values
    found = [looks_like_a_change(one.effect, values[one.effect], traced.data) for one in traced.added]
    held = ACCEPTED if accept_change else NOT_ACCEPTED
    changes = tuple(
        f"{change}. {held if one.effect.of_the_motor else NOT_HELD}" if change else ""
        for one, change in zip(traced.added, found, strict=True)
    )
    grown = [bool(has_grown(one.effect, values[one.effect], traced.data)) for one in traced.added]
    missing = missing_heat(traced, grown, names)
    # What comes and goes is no change of the motor: what stood for it on average, or took little beside it, is told as
    # what it is, and not named.
    loads = missing is not None and missing.comes_and_goes and not accept_change
    means = [_may_be_a_mean(step) for step in traced.steps if step.added is not None]
    little = traced.final.score_K > STANDS_FOR_IT * traced.null.score_K
    named = tuple(not (loads and (change or mean or little)) for change, mean in zip(changes, means, strict=True))
    each = zip(traced.added, changes, named, strict=True)
    written = tuple(
        found.effect
        for found, change, told in each
        if (accept_change and found.effect.of_the_motor) or (told and not change)
    )
    # Walls about an ambient that the file holds for fixed would be no walls.
    alone = fixed_ambient and any(isinstance(effect, Walls) for effect in written)
    return Kept(changes, named, () if alone else written, missing, alone)


def _may_be_a_mean(step: Step) -> bool:
    """Whether what was added cannot be told from other heat at each speed: the mean of what comes and goes is that."""
    assert step.added is not None
    return any(one.effect.bends_the_file for one in (step.added, *step.lookalikes))


def could_be_a_change(steps: Sequence[Step], found: Kept) -> list[str]:
    """Say of what is written that a motor which has changed would look the same.

    Parameters
    ----------
    steps
        The searches; the last one may have added nothing.
    found
        What became of what they added.
    """
    return [
        f"{step.added.effect.component}: {step.added.effect.name} is written, and these runs could as well be of a "
        f"motor that has changed ({PathChange.name}: blown at, covered, dirty, mounted otherwise): if it is so, leave "
        "the file as it was"
        for step, change in zip(steps, found.changes, strict=False)
        if step.added is not None
        and not change
        and step.added.effect in found.effects
        and any(isinstance(other.effect, PathChange) for other in step.lookalikes)
    ]
