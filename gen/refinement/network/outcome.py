"""What is written into the file, what it errs by then, and what is said of that: all of it, less, or nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from gen.coefficients import Coefficients, parse
from gen.refinement.errors import Errors
from gen.refinement.network.ambient import MovingAmbient
from gen.refinement.network.entries import ambient_entry, effect_entry, start_entry
from gen.refinement.network.kept import Kept, could_be_a_change
from gen.refinement.network.tracing.trace import Traced
from gen.refinement.network.tracing.warm_start import WarmStart
from gen.refinement.network.verdict import network_verdict
from gen.refinement.network.written import Written, written
from gen.refinement.verdict import Verdict
from gen.refinement.worse import got_worse, lowered, spoiled

NOT_IN_ALL = (
    "what was found for all runs together is not written, since they differ: with --accept-change it is, as their mean"
)
NOT_WITHOUT_THE_CHANGE = (
    "what was found beside the change is right beside it alone: without it, it would miss the runs by more than the "
    "file does, so it is not written either"
)


@dataclass(frozen=True, eq=False)
class Outcome:
    """What becomes of all that was found.

    Attributes
    ----------
    made
        The file.
    after
        Its errors.
    effects
        As the JSON summary has them.
    verdict
        Of them.
    warnings
        Sentences.
    offers_anew
        Whether nothing is named, and the file's own numbers are not written either.
    """

    made: Written
    after: Errors
    effects: list[dict[str, Any]]
    verdict: Verdict
    warnings: tuple[str, ...]
    offers_anew: bool


@dataclass(frozen=True, eq=False)
class Found:
    """All that was found, of a file that misses the runs by what is given.

    Attributes
    ----------
    coefficients, raw
        The file, and its text.
    before
        Its errors.
    traced
        Effects.
    room
        That the measured ambient is to be read from now on, or None.
    accept_change
        Whether what looks like another motor is written, too.
    """

    coefficients: Coefficients
    raw: str
    before: Errors
    traced: Traced
    room: MovingAmbient | None
    accept_change: bool

    def outcome(self, kept: Kept, start: WarmStart, errors_of: Callable[[Coefficients], Errors]) -> Outcome:
        """Write what is kept, unless it would miss the runs by more than the file does.

        Parameters
        ----------
        kept
            What of it is named, and what is to be written.
        start
            Where hidden nodes begin.
        errors_of
            Gives a file's errors in all runs.
        """
        made = written(
            self.coefficients, self.raw, self.traced, kept.effects, self.room, start, accept_change=self.accept_change
        )
        said = [*kept.warnings, *([made.refused] if made.refused else []), *_not_kept(self.traced)]
        anew = not made.refitted and not any(kept.named)
        if made.text == self.raw:
            after, new = self.before, list[str]()
        else:
            refined = parse(made.text.encode())
            after = errors_of(refined)
            new = [f"of what is written: {one}" for one in refined.warnings if one not in self.coefficients.warnings]
        torn = self._torn(kept, after)
        if not torn:
            said += [] if made.text == self.raw else start.warnings
            said += could_be_a_change(self.traced.steps, kept) if made.refitted else []
            return self._with(made, after, kept, start, [*said, *new], anew)
        if not kept.parts_runs and self.room is None and any(kept.changes):
            told = [*said, NOT_WITHOUT_THE_CHANGE]
            return self._with(Written(self.raw), self.before, replace(kept, effects=()), start.as_the_file, told, anew)
        return Outcome(Written(self.raw), self.before, [], "unexplained", (*said, *torn), anew)

    def _torn(self, kept: Kept, after: Errors) -> list[str]:
        """Why nothing may be written: runs are missed by more than before, or do not share what was found for all."""
        if self.accept_change:
            return []
        return spoiled(self.before, after, self.traced.null.noise_K) + ([NOT_IN_ALL] if kept.parts_runs else [])

    def _with(self, made: Written, after: Errors, kept: Kept, start: WarmStart, said: list[str], anew: bool) -> Outcome:
        effects = self._entries(kept, start)
        holds = kept.holds and not made.refused
        verdict = network_verdict(self.traced, start, anything=bool(effects or start.factors), holds=holds)
        verdict = lowered(verdict) if got_worse(self.before, after) else verdict
        return Outcome(made, after, effects, verdict, tuple(said), anew)

    def _entries(self, kept: Kept, start: WarmStart) -> list[dict[str, Any]]:
        """What was found as the summary has it, of that which is named."""
        traced, later = self.traced, self.traced.data.later
        made = [] if self.room is None else [ambient_entry(self.room, later)]
        for step, change, told in zip(traced.steps, kept.changes, kept.named, strict=False):
            assert step.added is not None  # the last search alone may have added nothing
            if told:
                is_written = step.added.effect in kept.effects
                made.append(effect_entry(step, step.added, traced, change, written=is_written))
        return made + ([start_entry(start)] if start.named else [])


def _not_kept(traced: Traced) -> list[str]:
    """Say what was found, and is no longer there."""
    said = [
        f"{one.effect.component}: {one.effect.name} was found first, and is not needed beside what was found after it"
        for one in traced.dropped
    ]
    return said + [
        f"{one.effect.component}: {one.effect.name} was found, and not kept: fitted with all else a number of it ends "
        "at its physical limit"
        for one in traced.unsound
    ]
