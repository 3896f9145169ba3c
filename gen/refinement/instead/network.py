"""One network for the motor, from the runs that a file's parts do not explain, held against these parts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gen.coefficients import Coefficients, in_place_of_parts, parse
from gen.errors import CheckFailed, InputError
from gen.identification.choice.compared import NETWORK, PARTS, Comparison, Errors, Kind, comparison
from gen.identification.choice.folds import Fold, folds_of
from gen.identification.choice.left_out import errors
from gen.identification.choice.models import NetworkModel, Options, network_of
from gen.identification.logs.sources import Source
from gen.identification.network.telling.summary import Summary
from gen.identification.settings import Settings
from gen.refinement.condense import read_measured
from gen.refinement.instead.settling import Elsewhere, elsewhere

Progress = Callable[[str], None]

FEWEST_RUNS = 2
WORTH = 1.15
"""A network errs less by this factor, as any effect has to: on each run that is left out less, and so in the mean."""


@dataclass(frozen=True, eq=False)
class Instead:
    """A network that explains runs better than a file's parts do.

    Attributes
    ----------
    text, coefficients
        The file with the network in the place of its transfer functions, no effect traced in it.
    compared
        Both on runs that took no part in the network's fit; the parts' effects had all of them.
    elsewhere
        Parts that it has settle elsewhere than the file.
    warnings
        What identification says of the network.
    """

    text: str
    coefficients: Coefficients
    compared: Comparison
    elsewhere: tuple[Elsewhere, ...]
    warnings: tuple[str, ...]

    @property
    def sentence(self) -> str:
        """What was found, in one sentence."""
        err = self.compared.error_K
        return (
            "a network explains this, parts alone do not: identified from the runs of --fit it errs by "
            f"{err[NETWORK]:.2g} K on those that are left out, parts with all that was found for them by "
            f"{err[PARTS]:.2g} K"
        )

    @property
    def other_motor(self) -> str:
        """What tells that it is not the file's motor, or nothing."""
        if not self.elsewhere:
            return ""
        return (
            f"in the network {'; '.join(one.sentence for one in self.elsewhere)}: the motor has changed since the file "
            "was made, or the file was wrong there; run one of these speeds again as then"
        )

    def summary(self) -> dict[str, Any]:
        """As the JSON summary has it."""
        return {
            "error_K": dict(self.compared.error_K),
            "settles_elsewhere": [
                {"component": one.part, "pwm": one.pwm, "network_K": one.network_K, "file_K": one.file_K}
                for one in self.elsewhere
            ],
        }


def network_instead(
    baseline: Coefficients, raw: str, refined: Coefficients, paths: Sequence[Path], progress: Progress
) -> Instead | None:
    """Identify a network from the fit runs and hold it against the parts.

    Parameters
    ----------
    baseline, raw
        The file with transfer functions, and its text.
    refined
        The same with the effects that were found beside them, from all of the runs.
    paths
        The fit runs that were admitted.
    progress
        Called with what is being done.

    Returns
    -------
    Instead or None
        None for a single run, where no network of the same parts can be identified or built, or where it does not
        predict each run that is left out of its fit better than `refined`, which knows them all.
    """
    if len(paths) < FEWEST_RUNS:
        return None
    sources = [Source(str(path), read_measured(baseline, path)) for path in paths]
    options = _options(baseline)
    try:
        model = network_of(sources, options, _told(progress, "as one network"))
        if set(model.coefficients.model.component_names) != set(baseline.model.component_names):
            return None
        text, coefficients = _in_the_file(raw, model)
    except (InputError, CheckFailed):
        return None
    compared = _compared(raw, refined, sources, options, progress)
    if compared is None:
        return None
    return Instead(text, coefficients, compared, *_said(baseline, model))


def _in_the_file(raw: str, model: NetworkModel) -> tuple[str, Coefficients]:
    """The file with the network: it counts from the file's ambient, whatever the runs measured."""
    text = in_place_of_parts(raw, model.text)
    return text, parse(text.encode())


def _said(baseline: Coefficients, model: NetworkModel) -> tuple[tuple[Elsewhere, ...], tuple[str, ...]]:
    summary = Summary(model.result)
    return tuple(elsewhere(baseline, summary)), tuple(summary.warnings())


def _options(baseline: Coefficients) -> Options:
    document = baseline.document
    settings = Settings(
        document.name, document.sample_time_s, document.input.full_scale, document.input.nominal_speed_rpm
    )
    return Options(settings, document.ambient.fixed_degC)


def _compared(
    raw: str, refined: Coefficients, sources: Sequence[Source], options: Options, progress: Progress
) -> Comparison | None:
    """Both on what is left out of the network's fits; None where the network is not better on each of it."""
    folds = folds_of(sources)
    found: dict[Kind, list[Errors | None]] = {NETWORK: [], PARTS: []}
    compared = None
    for number, fold in enumerate(folds, start=1):
        found[NETWORK].append(_left_out(raw, fold, options, _told(progress, f"as one network, left out {number}")))
        found[PARTS].append(errors(refined, fold))
        compared = comparison(found)
        if found[NETWORK][-1] is None or compared is None or min(compared.logs) <= 0.0:
            return None
    return compared if compared is not None and compared.ratio >= WORTH else None


def _told(progress: Progress, what: str) -> Progress:
    return lambda said: progress(f"{what}: {said}")


def _left_out(raw: str, fold: Fold, options: Options, progress: Progress) -> Errors | None:
    """What a network that was fitted to the fold's other runs errs by; None where too little is left to fit."""
    try:
        return errors(_in_the_file(raw, network_of(fold.fit, options, progress))[1], fold)
    except (InputError, CheckFailed):
        return None
