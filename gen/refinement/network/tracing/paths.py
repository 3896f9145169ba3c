"""Effects one after the other: the best first, unless a pair that begins otherwise is plainly better.

What is added for itself is what explains most alone. Of two effects at once that may be neither: an airflow and a path
together look like a sensor's gain. So where much is left, the search begins anew with what else could have come first;
and what came first is asked for anew beside what came after (a floating search: Pudil, Novovicova and Kittler, Floating
search methods in feature selection, Pattern Recognition Letters 15, 1994).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from gen.refinement.network.effects import NetworkEffect
from gen.refinement.network.fitting.fit import Bench
from gen.refinement.network.tracing.changed import looks_like_a_change
from gen.refinement.network.tracing.judged import Judged, is_explained, judged, p_better
from gen.refinement.network.tracing.search import (
    ENOUGH_BESIDE,
    LEAST_GAIN_BESIDE,
    PRICE,
    Considered,
    Step,
    leaves_some,
    one_more,
)
from gen.refinement.verdict import EXPLAINED

MOST_EFFECTS = 3
LEAST_GAIN_BESIDE_A_CHANGE = 0.25
"""Share of the left-out error that an effect has to take away beside what looks like another motor: less may be what
the form of the change leaves."""
PROMISING = 0.85
"""Priced cost that a linear step promises of a pair, over that of all that was found, below which it is tried."""


@dataclass(frozen=True, eq=False)
class Path:
    """Searches one after the other.

    Attributes
    ----------
    steps
        The last one may have added nothing.
    now
        With all that they added.
    """

    steps: tuple[Step, ...]
    now: Judged

    @property
    def added(self) -> list[Considered]:
        """What was accepted, in order."""
        return [step.added for step in self.steps if step.added is not None]


def followed(
    bench: Bench,
    steps: tuple[Step, ...],
    now: Judged,
    every: Sequence[NetworkEffect],
    progress: Callable[[str], None],
) -> Path:
    """Search further effects among candidates until nothing more is needed, or found.

    Parameters
    ----------
    bench
        The runs.
    steps, now
        What was searched before, and what it came to.
    every
        The candidates.
    progress
        Called with what is being done.
    """
    while len(steps) < MOST_EFFECTS:
        least_gain = LEAST_GAIN_BESIDE_A_CHANGE if _has_a_change(bench, now) else LEAST_GAIN_BESIDE
        step = one_more(bench, now, every if leaves_some(bench, now) else [], progress, least_gain)
        steps = (*steps, step)
        if step.added is None:
            break
        now = _with(bench, step.added)
        if _has_a_change(bench, now) and is_explained(bench.data, now):
            # What little is left beside a fault is the fault's, too.
            break
    return Path(steps, now)


def from_another_beginning(
    bench: Bench, path: Path, every: Sequence[NetworkEffect], progress: Callable[[str], None]
) -> Path:
    """Begin with something else where much is left; taken is a pair that predicts plainly better than all of the path.

    Parameters
    ----------
    bench
        The runs.
    path
        What was found.
    every
        The candidates.
    progress
        Called with what is being done.
    """
    # What is left beside a fault may be the fault's, too: only a change that does not explain the error is doubted, and
    # only for what does, since that is learnt.
    changed = _has_a_change(bench, path.now)
    if not path.added or path.now.floors <= (EXPLAINED if changed else ENOUGH_BESIDE):
        return path
    other = _most_promising(bench, path, every, progress)
    begun = None if other is None else _begun(bench, path, other, every, progress)
    if begun is not None and (is_explained(bench.data, begun.now) or not changed):
        return followed(bench, begun.steps, begun.now, every, progress)
    bench.weigh_as(path.now.fitted)
    return path


def _begun(
    bench: Bench, path: Path, first: Considered, every: Sequence[NetworkEffect], progress: Callable[[str], None]
) -> Path | None:
    """Give the best pair that begins with an effect; None if it is not plainly better than all that was found."""
    alone = _with(bench, first)
    if _has_a_change(bench, alone):
        return None
    second = one_more(bench, alone, every, progress)
    if second.added is None:
        return None
    pair = _with(bench, second.added)
    if pair.score_K >= (1.0 - LEAST_GAIN_BESIDE) * path.now.score_K or _has_a_change(bench, pair):
        return None
    return Path((_instead(path.steps[0], first), second), pair)


def _most_promising(
    bench: Bench, path: Path, every: Sequence[NetworkEffect], progress: Callable[[str], None]
) -> Considered | None:
    """Of what else may have come first, what promises most with the best second beside it, by linear steps.

    None if no pair promises plainly more than all that was found.
    """
    # An effect with paths of its own takes a short search. With another beside it, it is found from that one: but for a
    # part without a sensor, which alone may be bent so far to stand for both that it is refused.
    seconds = [effect for effect in every if effect.nodes or not effect.paths]
    first = path.steps[0]
    bench.weigh_as(first.without.fitted)
    found = bench.finished(bench.fit(path.now.fitted.shape, path.now.fitted))
    least = PROMISING * (found.fit.cost + PRICE * sum(effect.freedom for effect in found.shape.effects))
    best = None
    for one in first.considered:
        if one is first.added or one.reasons or looks_like_a_change(one.effect, one.values, bench.data):
            continue
        progress(f"what {one.effect.name} promises with a second one")
        fitted = one.judged.fitted
        beside = [effect for effect in seconds if effect.name != one.effect.name]
        gains = bench.promises([fitted.shape.with_effects(one.effect, it) for it in beside], fitted)
        promised = [gain - PRICE * it.freedom for gain, it in zip(gains, beside, strict=True)]
        cost = fitted.fit.cost + PRICE * one.effect.freedom - max(promised, default=0.0)
        if cost < least:
            least, best = cost, one
    return best


def exchanged(bench: Bench, path: Path, every: Sequence[NetworkEffect], progress: Callable[[str], None]) -> Path:
    """Search anew what stands beside what was found last: what was found before may have stood for both.

    Where that is something else, the search goes on from it, and that is taken if it predicts better; where it is not,
    what could as well be is what could beside all that was found.

    Parameters
    ----------
    bench
        The runs, weighed as in the last search.
    path
        What was found.
    every
        The candidates.
    progress
        Called with what is being done.
    """
    found = path.added
    if len(found) < 2 or looks_like_a_change(found[-1].effect, found[-1].values, bench.data):
        return path  # a change that comes last is what is left beside the others, whatever these are
    steps, explained = list(path.steps), is_explained(bench.data, path.now)
    for place, old in enumerate(found[:-1]):
        bench.weigh_as(path.now.fitted)
        others = tuple(one.effect for one in found if one is not old)
        fitted = bench.fit(path.now.fitted.shape.with_effects(*others), path.now.fitted)
        again = one_more(bench, judged(bench.data, fitted, bench.left_out(fitted)), every, progress)
        if again.added is None:
            continue
        if again.added.effect.name == old.effect.name:
            steps[place] = replace(steps[place], lookalikes=again.lookalikes)
            continue
        if explained and looks_like_a_change(again.added.effect, again.added.values, bench.data):
            continue
        other = _gone_on(bench, path.steps[: place + 1], again.added.effect, every, progress)
        if _predicts_better(bench, other, path):
            return other
    bench.weigh_as(path.now.fitted)
    return Path(tuple(steps), path.now)


def _predicts_better(bench: Bench, other: Path, path: Path) -> bool:
    """Whether it predicts better what was left out; with more effects, or as another motor, plainly."""
    changed = _has_a_change(bench, other.now)
    if changed and is_explained(bench.data, path.now):
        return False  # what effects explain is no other motor
    if _has_a_change(bench, path.now) and not (changed or is_explained(bench.data, other.now)):
        return False  # a change is given up for what explains the error: that is learnt
    plainly = changed or len(other.added) > len(path.added)
    return other.now.score_K < (1.0 - LEAST_GAIN_BESIDE if plainly else 1.0) * path.now.score_K


def _gone_on(
    bench: Bench,
    steps: tuple[Step, ...],
    effect: NetworkEffect,
    every: Sequence[NetworkEffect],
    progress: Callable[[str], None],
) -> Path:
    """Go on from an effect that the last search might have added."""
    *before, last = steps
    base = last.without.fitted
    bench.weigh_as(base)
    fitted = bench.finished(bench.fit(base.shape.with_effects(*base.shape.effects, effect), base))
    alone = judged(bench.data, fitted, bench.left_out(fitted))
    one = Considered(effect, alone, p_better(bench.data, last.without, alone), ())
    others = tuple(other for other in last.considered if other.effect.name != effect.name)
    step = _instead(replace(last, considered=(one, *others)), one)
    return followed(bench, (*before, step), _with(bench, one), every, progress)


def _instead(step: Step, one: Considered) -> Step:
    """Give the search as if it had added another effect, and say why it did not add its own."""
    why = f"with a second effect less is left where {one.effect.name} comes first"
    considered = tuple(
        replace(each, reasons=(*each.reasons, why)) if each is step.added else each for each in step.considered
    )
    return replace(step, considered=considered, added=one, lookalikes=())


def _with(bench: Bench, added: Considered) -> Judged:
    """What is explained no longer hides what is not: the runs count for more."""
    found = added.judged.fitted
    again = bench.tightened(found.shape, found.vector)
    return judged(bench.data, again, bench.left_out(again))


def _has_a_change(bench: Bench, now: Judged) -> bool:
    """Whether anything that was found looks like another motor."""
    fitted = now.fitted
    each = zip(fitted.shape.effects, fitted.shape.values(fitted.vector), strict=True)
    return any(looks_like_a_change(effect, values, bench.data) for effect, values in each)
