"""One more effect: each candidate is fitted together with all that the network may be off by.

A linear step says what each candidate promises; the best of each name are fitted; the best of these are judged on what
is left out, in turn. What predicts it best is added, if it does so by more than chance and by more than a little.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from gen.refinement.gains import LEAST_GAIN, LEVEL, TOO_LITTLE
from gen.refinement.network.effects import NetworkEffect, PathChange
from gen.refinement.network.fitting.data import Data
from gen.refinement.network.fitting.fit import Bench, Fitted
from gen.refinement.network.tracing.changed import has_grown
from gen.refinement.network.tracing.judged import Judged, doubts, judged, p_better

PLAIN, PLAIN_LEVEL, LEAST_DECREASE = 0.75, 0.2, 25.0
"""Left-out error over that without it, p-value, and decrease of the weighed squares, of what is plain."""
AS_GOOD = 1.1
"""Left-out error over the least up to which the weighed squares of all runs decide, and the price of the numbers."""
IN_DOUBT = 1.25
"""The same up to which it may be a fault, where the weighed squares of all runs differ by no more than `RELIEF`."""
LEAST_GAIN_BESIDE = 0.15
"""Share of the left-out error that a further effect has to take away: one that takes less mends the form of those that
were found, and is a wrong name."""
NEAREST = 1.5
"""Left-out error over that of the best of all, accepted or not, up to which an effect may be named."""
ENOUGH, ENOUGH_BESIDE, BENT = 1.1, 1.25, 25.0
"""Noise floors below which no effect is sought, and none beside one that was found; but one is where the file had to be
bent by more than this (weighed squares)."""
PRICE = 15.0
"""Decrease of the weighed squares that each number of an effect must bring for itself."""
NOT_BY_THE_CHANNEL = "predicts no better than with its channel held at its median"
RELIEF, AS_BEFORE, EVEN = 80.0, 1.02, 0.5
"""The first effect may also count because the file need not be bent: by this decrease beside what its numbers cost,
where the left-out error is no more than this factor above that without it, and the blocks do not speak against it."""
FITTED_OF_EACH, NEARLY = 2, 0.75
"""Candidates of one name that are fitted, and share of what the best promises from which one more is."""
LEFT_OUT = 7
"""Names that are judged on what was left out."""


@dataclass(frozen=True, eq=False)
class Considered:
    """A candidate that was judged.

    Attributes
    ----------
    effect
        What was tried beside those that were found before.
    judged
        Its errors.
    p_value
        That it predicts what was left out better than without it, by chance.
    reasons
        Why it is not accepted; empty if it may be.
    """

    effect: NetworkEffect
    judged: Judged
    p_value: float
    reasons: tuple[str, ...]

    @property
    def values(self) -> tuple[float, ...]:
        """The effect's numbers."""
        fitted = self.judged.fitted
        return fitted.shape.values(fitted.vector)[-1]


@dataclass(frozen=True, eq=False)
class Step:
    """One search for one more effect.

    Attributes
    ----------
    without
        The network before it.
    considered
        The best of each name, the best first.
    added
        What was accepted; None for nothing.
    lookalikes
        Others that predict what was left out as well, by name.
    """

    without: Judged
    considered: tuple[Considered, ...]
    added: Considered | None
    lookalikes: tuple[Considered, ...]


def leaves_some(bench: Bench, now: Judged) -> bool:
    """Whether so much is left that one more effect is worth a search."""
    if now.names:
        return now.floors > ENOUGH_BESIDE
    return now.floors > ENOUGH or bench.bent(now.fitted) > BENT


def one_more(
    bench: Bench,
    now: Judged,
    every: Sequence[NetworkEffect],
    progress: Callable[[str], None],
    least_gain: float = LEAST_GAIN_BESIDE,
) -> Step:
    """Search one more effect beside those that were found.

    Parameters
    ----------
    bench
        The runs.
    now
        What was found.
    every
        The candidates.
    progress
        Called with what is being done.
    least_gain
        Share of the left-out error that it has to take away, where something was found.
    """
    data, base = bench.data, now.fitted
    found = base.shape.effects
    taken = {(effect.name, effect.component) for effect in found}
    promised: dict[str, list[tuple[float, NetworkEffect]]] = {}
    untaken = [effect for effect in every if (effect.name, effect.component) not in taken]
    if not untaken:
        return Step(now, (), None, ())
    beside = f"beside {', '.join(now.names) or 'nothing'}"
    progress(f"{len(untaken)} candidates {beside}")
    shapes = [base.shape.with_effects(*found, effect) for effect in untaken]
    for effect, gain in zip(untaken, bench.promises(shapes, base), strict=True):
        promised.setdefault(effect.name, []).append((gain - PRICE * effect.freedom, effect))
    progress(f"{len(promised)} kinds {beside}")
    best = [to_fit(sorted(offers, key=lambda offer: -offer[0])) for offers in promised.values()]
    shapes = [base.shape.with_effects(*found, effect) for offers in best for _, effect in offers]
    each = iter(bench.fits(shapes, base))
    fits = [fitted for offers in best for fitted in to_judge([next(each) for _ in offers])]
    fits.sort(key=_priced)
    fits = fits[:LEFT_OUT]
    progress(f"{', '.join(fitted.shape.effects[-1].name for fitted in fits)}: left-out error")
    ended = [judged(data, *each) for each in bench.all_finished(fits)]
    bent = bench.bent(base)
    considered = [_considered(data, now, one, len(promised), bent, least_gain) for one in ended]
    considered = [_moved(bench, now, one) for one in considered]
    considered.sort(key=lambda one: one.judged.score_K)
    # What is much worse than something that cannot be the reason is not the reason either.
    accepted = [
        one for one in considered if not one.reasons and one.judged.score_K <= NEAREST * considered[0].judged.score_K
    ]
    if not accepted:
        return Step(now, tuple(considered), None, ())
    near = [one for one in accepted if one.judged.score_K <= AS_GOOD * accepted[0].judged.score_K]
    likeliest = min(near, key=lambda one: _priced(one.judged.fitted))
    added = likeliest
    if not isinstance(likeliest.effect, PathChange):
        # A way of heat that was lost is not learnt either: there it need not be a fault's heat to be on the safe side.
        added = next((one for one in accepted if may_be_a_fault(data, accepted[0], one)), likeliest)
    alike = [one for one in accepted if one is not added and p_better(data, one.judged, added.judged) > LEVEL]
    return Step(now, tuple(considered), added, tuple(alike))


def to_fit(offers: Sequence[tuple[float, NetworkEffect]]) -> list[tuple[float, NetworkEffect]]:
    """Those of one name that promise most, the best first: two, and one more that promises nearly as much as the best.

    Where two are forms at one place, that is the best elsewhere, however much it promises: a linear step says less of
    what grows faster than it, as a resonance does at the node where it is.
    """
    first, others = list(offers[:FITTED_OF_EACH]), offers[FITTED_OF_EACH:]
    places = {effect.component for _, effect in first}
    if len(places) < len(first):
        return first + [offer for offer in others if offer[1].component not in places][:1]
    return first + [offer for offer in others if offer[0] > NEARLY * first[0][0]][:1]


def to_judge(fits: Sequence[Fitted]) -> list[Fitted]:
    """Give the best fit of one name, and where its numbers are doubtful the best that nothing speaks against."""
    first, *others = sorted(fits, key=_priced)
    return [first, *[fitted for fitted in others if not doubts(fitted)][:1]] if doubts(first) else [first]


def may_be_a_fault(data: Data, best: Considered, one: Considered) -> bool:
    """Whether one has a fault's pattern and predicts about as well as the best: a fault must not be learnt."""
    if not has_grown(one.effect, one.values, data):
        return False
    near = one.judged.score_K <= IN_DOUBT * best.judged.score_K
    near = near and _priced(one.judged.fitted) <= _priced(best.judged.fitted) + RELIEF
    return one is best or (near and p_better(data, one.judged, best.judged) > LEVEL)


def _priced(fitted: Fitted) -> float:
    """The cost of a fit, and of the last effect's numbers."""
    return fitted.fit.cost + PRICE * fitted.shape.effects[-1].freedom


def _considered(data: Data, without: Judged, one: Judged, tried: int, bent: float, least_gain: float) -> Considered:
    p = p_better(data, without, one)
    reasons = doubts(one.fitted)
    relief = without.fitted.fit.cost - one.fitted.fit.cost
    asked = RELIEF + PRICE * one.fitted.shape.effects[-1].freedom
    if without.names:
        if one.score_K > (1.0 - least_gain) * without.score_K:
            reasons.append(f"lowers the error on left-out runs by less than {least_gain:.0%} beside what was found")
    elif (
        bent > BENT
        and not one.fitted.shape.effects[-1].bends_the_file
        and relief > asked
        and one.score_K < AS_BEFORE * without.score_K
        and p < EVEN
    ):
        return Considered(one.fitted.shape.effects[-1], one, p, tuple(reasons))
    elif one.score_K > (1.0 - LEAST_GAIN) * without.score_K:
        reasons.append(TOO_LITTLE)
    if p > LEVEL / tried and not _plain(without, one, p):
        reasons.append("not more than chance")
    return Considered(one.fitted.shape.effects[-1], one, p, tuple(reasons))


def _moved(bench: Bench, now: Judged, one: Considered) -> Considered:
    """Doubt what a channel does that hardly moves: held at its median, it is only a change of the whole motor."""
    held = one.effect.unmoved()
    if one.reasons or held is None:
        return one
    base = now.fitted
    fitted = bench.fit(base.shape.with_effects(*base.shape.effects, held), base)
    still = judged(bench.data, fitted, bench.left_out(fitted))
    p = p_better(bench.data, still, one.judged)
    more_than_a_little = one.judged.score_K < (1.0 - LEAST_GAIN) * still.score_K
    if (p <= LEVEL and more_than_a_little) or _plain(still, one.judged, p):
        return one
    return replace(one, reasons=(NOT_BY_THE_CHANNEL,))


def _plain(without: Judged, one: Judged, p_value: float) -> bool:
    """Whether it explains too much of the error to need a test by blocks.

    What acts for minutes in hours (a stop, a gust) shows in few blocks, however plainly.
    """
    gain = without.fitted.fit.cost - one.fitted.fit.cost
    return one.score_K < PLAIN * without.score_K and p_value < PLAIN_LEVEL and gain > LEAST_DECREASE
