"""Whether what was found makes runs worse that took no part: then it is no refinement, whatever the fit runs say."""

from __future__ import annotations

from pathlib import Path

from gen.refinement.errors import Errors
from gen.refinement.run_errors import Score, total
from gen.refinement.verdict import NOTHING, Verdict

WORSE, WORSE_K = 1.05, 0.02
"""Test runs get worse by more than 5 %, and by more than any sensor tells, K."""
SPOILED = 1.5
"""Times as much by which a run that the file explains has to be missed with what was found, noise included."""
TOLD = " But with what was found the test runs are missed by more than before: it does not hold for them."
"""What a report says beside its verdict then."""
_LOWERED: dict[Verdict, Verdict] = {"explained": "partly explained", "nothing missing": "unexplained"}


def got_worse(before: Errors, after: Errors) -> bool:
    """Whether the test runs together are missed by clearly more than before."""
    return _worse(_all(before.test), _all(after.test))


def lowered(verdict: Verdict) -> Verdict:
    """Give the verdict where the test runs got worse: what does that explains nothing, and something is missing."""
    return _LOWERED.get(verdict, verdict)


def told_worse(before: Errors, after: Errors) -> list[str]:
    """A sentence where the test runs got worse together, or else one for those of them that did alone."""
    if got_worse(before, after):
        old, new = _all(before.test).rmse_K, _all(after.test).rmse_K
        return [
            f"with what was found the test runs are missed by {new:.3g} K, before by {old:.3g} K: it does not hold for "
            "runs that took no part; give --fit more runs, of the same motor and kind as those of --test"
        ]
    alone = {run: (total(before.test[run].values()), total(of.values())) for run, of in after.test.items()}
    return [
        f"{Path(run).name}: with what was found this test run is missed by {new.rmse_K:.3g} K, before by "
        f"{old.rmse_K:.3g} K; all test runs together are not worse"
        for run, (old, new) in alone.items()
        if _worse(old, new)
    ]


def spoiled(before: Errors, after: Errors, noise_K: float) -> list[str]:
    """A sentence where runs that the file explains are missed with what was found: it is not in all of them.

    Parameters
    ----------
    before, after
        Of the file, and with what was found.
    noise_K
        Of single readings.

    Returns
    -------
    list of str
        Empty where no such run was given to fit.
    """
    old, new = _all(before.fit), _all(after.fit)
    if _worse(old, new):
        return [
            f"with what was found the runs that it was found in are missed by {new.rmse_K:.3g} K, before by "
            f"{old.rmse_K:.3g} K: nothing of it is written"
        ]
    good, worst = [], 0.0
    others = []
    for run, scores in before.fit.items():
        was, now = total(scores.values()).rmse_K, total(after.fit[run].values()).rmse_K
        if was > NOTHING * noise_K:
            others.append(Path(run).name)
        elif now > SPOILED * max(was, noise_K):
            good.append(Path(run).name)
            worst = max(worst, now / was)
    if not good:
        return []
    return [
        f"{', '.join(good)}: explained by the file as it is, and missed by up to {worst:.2g} times as much with what "
        f"was found from {', '.join(others) or 'the others'}: that is not in all runs, so nothing of it is written. "
        "Something was otherwise in some of them that no column holds: log it, or refine the runs that are alike apart"
    ]


def _all(of: dict[str, dict[str, Score]]) -> Score:
    return total(score for run in of.values() for score in run.values())


def _worse(old: Score, new: Score) -> bool:
    return new.rmse_K > max(WORSE * old.rmse_K, old.rmse_K + WORSE_K)
