"""Whether readings tell what was planted from what was named: the planted names fitted as if they were known.

    python -m benchmarks.network_refinement.told_apart --case 25008:hidden_node+sensor_gain:6 --models FOLDER

refines as :mod:`benchmarks.network_refinement` does; then fits effects of the planted names and no others, each at its
best place, in the order that leaves least, and judges both by the same left-out error. What predicts no better although
its names were given beforehand is nothing that another choice among the same hypotheses could have found by that error.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations
from math import isnan
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from benchmarks.network_refinement.judge import identified
from benchmarks.plants.planted.draw import NotVisible
from benchmarks.plants.planted.trial import Trial, write_trial
from gen.errors import CheckFailed, InputError
from gen.interface.reported import silent
from gen.model.network_parts import AMBIENT
from gen.refinement.gains import LEVEL
from gen.refinement.network.effects import NetworkEffect, candidates
from gen.refinement.network.fitting.fit import Bench, Fitted
from gen.refinement.network.prepared import prepared
from gen.refinement.network.tracing.judged import Judged, judged, p_better
from gen.refinement.network.tracing.trace import trace

PLACES = 3
"""Candidates of a name that are fitted, those that promise most."""


@dataclass(frozen=True)
class ToldApart:
    """What was named beside what was planted.

    Attributes
    ----------
    trial
        Which.
    named
        Names of what was found.
    named_floors, planted_floors
        Error on what was left out, in noise floors; that of the planted names NaN where a name is no term of a network.
    p_value
        That the planted names predict better than what was found, by chance.
    """

    trial: str
    named: tuple[str, ...]
    named_floors: float
    planted_floors: float
    p_value: float

    @property
    def told(self) -> bool:
        """Whether the planted names predict better, by more than chance."""
        return self.planted_floors < self.named_floors and self.p_value < LEVEL


def told_apart(trial: Trial, models: Path) -> ToldApart:
    """Refine, and fit what was planted.

    Parameters
    ----------
    trial
        With something planted.
    models
        Identified networks, kept from trial to trial.

    Raises
    ------
    NotVisible
        If no bench shows what is planted.
    InputError, CheckFailed
        If the motor cannot be identified, or its runs are none to refine with.
    """
    with tempfile.TemporaryDirectory(prefix="refinement-") as name:
        written = write_trial(trial, Path(name))
        model = identified(written.setting, models)
        _, data, shape, _ = prepared(model.coefficients, written.fit, silent)
        found = trace(data, shape, silent).final
        bench = Bench(data)
        base = bench.first(shape)
        planted = known(bench, base, candidates(shape.motor(), data.offered), trial.names)
    nan = float("nan")
    if planted is None:
        return ToldApart(str(trial), found.names, found.floors, nan, nan)
    return ToldApart(str(trial), found.names, found.floors, planted.floors, p_better(data, found, planted))


def known(bench: Bench, base: Fitted, every: Sequence[NetworkEffect], names: Sequence[str]) -> Judged | None:
    """Fit effects of given names, in the order that leaves least.

    Parameters
    ----------
    bench
        The runs.
    base
        Without any effect.
    every
        The candidates.
    names
        Each is taken once.

    Returns
    -------
    Judged or None
        None where a name has no candidate: the network has no such term, or the runs do not show it.
    """
    # Sensors are planted wrong on the motor: that of the room is a hypothesis, and nothing that was planted.
    on_motor = [effect for effect in every if effect.component != AMBIENT]
    by_name = {name: [effect for effect in on_motor if effect.name == name] for name in names}
    if not all(by_name.values()):
        return None
    fits = []
    for order in permutations(names):
        bench.weigh_as(base)
        now = base
        for name in order:
            now = _with(bench, now, by_name[name])
        fits.append(now)
    best = min(fits, key=lambda one: one.fit.cost)
    again = bench.tightened(best.shape, best.vector)
    return judged(bench.data, again, bench.left_out(again))


def _with(bench: Bench, base: Fitted, effects: Sequence[NetworkEffect]) -> Fitted:
    """The best of some effects beside those that are there."""
    shapes = [base.shape.with_effects(*base.shape.effects, effect) for effect in effects]
    promised = bench.promises(shapes, base)
    first = sorted(range(len(shapes)), key=lambda k: -promised[k])[:PLACES]
    return bench.finished(min(bench.fits([shapes[k] for k in first], base), key=lambda one: one.fit.cost))


def line(one: ToldApart) -> str:
    """One line on a trial."""
    found = f"{one.trial}: named {', '.join(one.named) or 'nothing'}, {one.named_floors:.2f} floors left out"
    if isnan(one.planted_floors):
        return f"{found}; what was planted is no term of this network"
    said = "told apart" if one.told else "not told apart"
    return f"{found}; planted, known: {one.planted_floors:.2f}, p {one.p_value:.3f}: {said}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Read the command line, and print a line for each trial."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.network_refinement.told_apart",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--case", type=Trial.parse, nargs="+", required=True, help="SEED:EFFECT+EFFECT:FIT ...")
    parser.add_argument("--models", type=Path, help="keep identified networks here, and take those that are there")
    options = parser.parse_args(arguments)
    if not all(trial.names for trial in options.case):
        parser.error("--case: nothing is planted")
    with tempfile.TemporaryDirectory(prefix="models-") as name:
        for trial in options.case:
            try:
                said = line(told_apart(trial, options.models or Path(name)))
            except (NotVisible, InputError, CheckFailed) as error:
                said = f"{trial}: {error}"
            print(said, flush=True)


if __name__ == "__main__":
    main()
