"""From the error of a network to effects: which of them, one after the other, and which of these are needed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from gen.refinement.gains import LEVEL
from gen.refinement.network.effects import NetworkEffect, candidates
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import Data
from gen.refinement.network.fitting.fit import Bench
from gen.refinement.network.tracing.judged import Judged, doubts, doubts_of, is_explained, judged, p_better
from gen.refinement.network.tracing.paths import exchanged, followed, from_another_beginning
from gen.refinement.network.tracing.search import PRICE, RELIEF, Considered, Step

NEEDED = 0.1
"""Share of the left-out error that an effect has to take away beside all others, to stay among them. Less than it takes
to be added: that is a choice among many, and near the noise there is little left to take. So what all runs speak for
plainly stays, too."""


@dataclass(frozen=True, eq=False)
class Traced:
    """All that was found.

    Attributes
    ----------
    data
        The runs.
    file
        The file as it is, judged on all later runs.
    null
        Without any effect, all that the file leaves open fitted; the file where that predicts worse than it does.
    steps
        One for each search that found what is needed; the last one may have added nothing.
    final
        With all that was found.
    dropped
        What was found first, and is not needed beside what came after.
    unsound
        What was found, and has come to a physical limit since.
    """

    data: Data
    file: Judged
    null: Judged
    steps: tuple[Step, ...]
    final: Judged
    dropped: tuple[Considered, ...]
    unsound: tuple[Considered, ...] = ()

    @property
    def added(self) -> list[Considered]:
        """What was accepted, in order."""
        return [step.added for step in self.steps if step.added is not None]

    @property
    def values(self) -> dict[NetworkEffect, tuple[float, ...]]:
        """The numbers of each, as all of them together were fitted."""
        fitted = self.final.fitted
        return dict(zip(fitted.shape.effects, fitted.shape.values(fitted.vector), strict=True))


def trace(data: Data, shape: Anchored, progress: Callable[[str], None]) -> Traced:
    """Find effects one after the other."""
    bench = Bench(data)
    progress("the network without any effect")
    base = bench.first(shape)
    file = judged(data, base, bench.as_it_is(shape))
    # Few runs may lead away from a file that is right: an effect would then be praised for leading back to it.
    null = min(judged(data, base, bench.left_out(base)), file, key=lambda one: one.score_K)
    # What the file holds as it is needs no effect, however much its numbers would like to be others.
    every = () if is_explained(data, file) else candidates(shape.motor(), data.offered)
    path = followed(bench, (), null, every, progress)
    path = from_another_beginning(bench, path, every, progress)
    path = exchanged(bench, path, every, progress)
    kept, now = sound(bench, list(path.steps), path.now, progress)
    fewer, with_fewer = needed(bench, kept, now, progress)
    left = kept
    if not doubts(with_fewer.fitted):
        # What stands for another one only by a number at its limit does not stand for it.
        left, now = fewer, with_fewer
    return Traced(data, file, null, tuple(left), now, _added(kept, left), _added(path.steps, kept))


def _added(before: Sequence[Step], after: Sequence[Step]) -> tuple[Considered, ...]:
    """What was added by steps that are no longer there."""
    return tuple(step.added for step in before if step.added is not None and step not in after)


def needed(
    bench: Bench, steps: list[Step], final: Judged, progress: Callable[[str], None]
) -> tuple[list[Step], Judged]:
    """Drop what was found before another one explained it: the first name of a pair may stand for both.

    Parameters
    ----------
    bench
        The runs, weighed as in the last search.
    steps
        The searches, the last of which may have added nothing.
    final
        With all that they added.
    progress
        Called with what is being done.

    Returns
    -------
    steps, final
        Those that stay, and what they come to.
    """
    for step in steps[:-1]:
        effects = final.fitted.shape.effects
        if step.added is None or len(effects) < 2 or step.added.effect is effects[-1]:
            continue
        without = _without(bench, final, step.added.effect, progress)
        takes_little = final.score_K > (1.0 - NEEDED) * without.score_K
        if takes_little and not _spoken_for(bench, final, without, step.added.effect):
            steps, final = [one for one in steps if one is not step], without
    return steps, final


def _spoken_for(bench: Bench, final: Judged, without: Judged, effect: NetworkEffect) -> bool:
    """Whether all runs speak for an effect that little of what is left out needs.

    A hidden part has numbers enough to follow most of what a lag of one number does, beside a file bent for it.
    """
    relief = without.fitted.fit.cost - final.fitted.fit.cost
    return relief > RELIEF + PRICE * effect.freedom and p_better(bench.data, without, final) <= LEVEL


def sound(bench: Bench, steps: list[Step], final: Judged, progress: Callable[[str], None]) -> tuple[list[Step], Judged]:
    """Drop what has come to a physical limit since it was added, by what was found after it or by the last fit.

    Parameters
    ----------
    bench, steps, final, progress
        As `needed` has them.

    Returns
    -------
    steps, final
        Those that stay, and what they come to.
    """
    while True:
        shape, vector = final.fitted.shape, final.fitted.vector
        each = zip(shape.effects, shape.values(vector), strict=True)
        doubtful = next((effect for effect, values in each if doubts_of(effect, values)), None)
        if doubtful is None:
            return steps, final
        final = _without(bench, final, doubtful, progress)
        steps = [one for one in steps if one.added is None or one.added.effect is not doubtful]


def _without(bench: Bench, final: Judged, effect: NetworkEffect, progress: Callable[[str], None]) -> Judged:
    """What is left without one of the effects."""
    progress(f"without {effect.name}")
    shape = final.fitted.shape
    others = tuple(other for other in shape.effects if other is not effect)
    fitted = bench.fit(shape.with_effects(*others), final.fitted)
    return judged(bench.data, fitted, bench.left_out(fitted))
