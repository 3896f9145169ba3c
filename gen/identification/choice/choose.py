"""Fit a network; fit parts, too, where it is not good, and choose."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from gen.errors import CheckFailed, InputError
from gen.identification.choice.compared import KINDS, Errors, Kind, comparison
from gen.identification.choice.decision import Decision, Tried, decided, good_enough, told_without_folds
from gen.identification.choice.folds import Fold, folds_of
from gen.identification.choice.left_out import errors
from gen.identification.choice.models import NetworkModel, Options, PartsModel, Progress, network_of, parts_of
from gen.identification.logs.sources import Source

Fitted = PartsModel | NetworkModel
Fit = Callable[[Sequence[Source], Options, Progress], Fitted]


@dataclass(frozen=True, eq=False)
class Chosen:
    """The model that was taken, and why.

    Attributes
    ----------
    model
        With the reason in its file's provenance.
    decision
        Which kind, by how much.
    """

    model: Fitted
    decision: Decision


def choose(sources: Sequence[Source], options: Options, progress: Progress) -> Chosen:
    """Fit a network to all runs; unless it is good, fit parts, too, and both to each fold's; take one.

    Each kind is fitted `MOST_FOLDS` + 1 times at most; once, where one of them refuses or leaves a part out. Parts are
    not fitted at all where a network has every temperature of the runs and is good (see `grades`) on what was left out.

    Parameters
    ----------
    sources
        The runs.
    options
        What the user sets.
    progress
        Told what is being done.

    Raises
    ------
    InputError
        When a run or a setting has a fault, or nothing can be identified by either kind.
    CheckFailed
        When neither kind leads to a model that can be built, with hidden nodes or without.
    """
    fits: dict[Kind, Fit] = {"network": network_of, "parts": parts_of}
    models: dict[Kind, Fitted] = {}
    tried: dict[Kind, Tried] = {}
    refusals: list[InputError | CheckFailed] = []
    for kind in KINDS:
        try:
            model = models[kind] = fits[kind](sources, options, _told(progress, kind))
            if isinstance(model, NetworkModel) and model.good_to_K is not None:
                decision = good_enough(model.good_to_K)
                return Chosen(model.noted(decision.note), decision)
            tried[kind] = Tried(model.coefficients.model.component_names)
        except (InputError, CheckFailed) as error:
            tried[kind] = Tried(refused=_said(error))
            refusals.append(error)
    if not models:
        bare = _without_hidden_nodes(sources, options, refusals, progress)
        if bare is None:
            raise _neither(refusals)
        return bare
    decision = told_without_folds(tried) or _compared(sources, fits, options, progress)
    return Chosen(models[decision.kind].noted(decision.note), decision)


def _without_hidden_nodes(
    sources: Sequence[Source], options: Options, refusals: Sequence[InputError | CheckFailed], progress: Progress
) -> Chosen | None:
    """The network of what is sensed alone, where none with hidden nodes can be built; None where that refuses, too.

    It errs more, and says so. But it is a model, from which a user learns what the next run has to be.
    """
    of_network, of_parts = refusals
    if options.max_hidden == 0 or not isinstance(of_network, CheckFailed):
        return None
    try:
        model = network_of(sources, replace(options, max_hidden=0), _told(progress, "network without hidden nodes"))
    except (InputError, CheckFailed):
        return None
    why = f"network without hidden nodes, because parts refused: {_said(of_parts)}; and with them: {_said(of_network)}"
    decision = Decision("network", why, refused=_said(of_parts))
    return Chosen(model.noted(decision.note), decision)


def _compared(sources: Sequence[Source], fits: Mapping[Kind, Fit], options: Options, progress: Progress) -> Decision:
    """Decide by left-out error, with no more folds than that takes."""
    folds = folds_of(sources)
    found: dict[Kind, list[Errors | None]] = {kind: [] for kind in KINDS}
    compared, untried = None, 0
    for number, fold in enumerate(folds, start=1):
        for kind in KINDS:
            told = _told(progress, f"{kind}, left out {number} of {len(folds)}")
            found[kind].append(_left_out(fits[kind], fold, options, told))
        compared = comparison(found)
        untried = sum(len(further.judged) for further in folds[number:])
        if compared is not None and untried and not compared.may_show_parts(untried):
            break
    return decided(compared, "run" if len(sources) > 1 else "stretch", untried)


def _left_out(fit: Fit, fold: Fold, options: Options, progress: Progress) -> Errors | None:
    """What a kind errs by on what a fold leaves out; None where too little is left to fit."""
    try:
        return errors(fit(fold.fit, options, progress).coefficients, fold)
    except (InputError, CheckFailed):
        return None


def _told(progress: Progress, what: str) -> Progress:
    return lambda text: progress(f"{what}: {text}")


def _said(error: InputError | CheckFailed) -> str:
    """What is wrong, with the file's own name: where it stood is nothing for a coefficient file."""
    if isinstance(error, CheckFailed):
        return str(error)
    file = Path(error.file).name if error.file else None
    return ": ".join(part for part in (file, error.place, error.message) if part)


def _neither(refusals: Sequence[InputError | CheckFailed]) -> InputError | CheckFailed:
    """What both say where both say the same; else both, and of bad input its place."""
    first, second = refusals
    if str(first) == str(second):
        return first
    if isinstance(first, InputError) and isinstance(second, InputError):
        return second
    return CheckFailed(f"neither kind of model can be identified: network: {first}; parts: {second}")
