"""From further runs to what a model lacks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gen.errors import InputError
from gen.interface.arguments import several
from gen.interface.files import RunLike, run_files
from gen.interface.model import Model
from gen.interface.reported import Progress, Reported, silent
from gen.interface.threads import one_thread

if TYPE_CHECKING:
    import pandas as pd

    from gen.refinement.network.refine import NetworkRefinement as NetworkFound
    from gen.refinement.parts.refine import Refinement as Found


@dataclass(frozen=True, eq=False)
class Refinement(Reported):
    """What a refinement found.

    Parameters
    ----------
    model
        The refined model.
    baseline
        The model that it began with.
    found
        All that was found.
    """

    model: Model
    baseline: Model
    found: Found | NetworkFound

    @property
    def verdict(self) -> str:
        """``explained``, ``partly explained``, ``nothing missing`` or ``unexplained``."""
        return self.found.verdict

    @property
    def warnings(self) -> tuple[str, ...]:
        """What to look at, one sentence each."""
        return tuple(self.found.warnings)

    def details(self) -> dict[str, Any]:
        """The JSON summary, as ``gen refine --json`` writes it."""
        return self.found.summary()

    def effects(self) -> pd.DataFrame:
        """A row for each effect that was added: ``component``, ``effect``, ``parameters`` and its look-alikes."""
        import pandas as pd

        rows = [
            {
                "component": effect["component"],
                "effect": effect["name"],
                "parameters": effect["parameters"],
                "lookalikes": [other["name"] for other in effect["evidence"]["lookalikes"]],
            }
            for effect in self.found.effects
        ]
        return pd.DataFrame(rows, columns=["component", "effect", "parameters", "lookalikes"])

    def errors(self) -> pd.DataFrame:
        """RMSE in K before and after, by kind (``fit``, ``test``), run and part."""
        import pandas as pd

        rows = []
        for kind in ("fit", "test"):
            before, after = getattr(self.found.before, kind), getattr(self.found.after, kind)
            for run, parts in before.items():
                for name, score in parts.items():
                    rows.append(
                        {
                            "kind": kind,
                            "run": Path(run).stem,
                            "component": name,
                            "before_rmse_K": score.summary()["rmse_K"],
                            "after_rmse_K": after[run][name].summary()["rmse_K"],
                        }
                    )
        return pd.DataFrame(rows).set_index(["kind", "run", "component"])

    def html(self) -> str:
        """The report as one HTML page."""
        from gen.refinement.network.refine import NetworkRefinement

        if isinstance(self.found, NetworkRefinement):
            from gen.refinement.instead.refine import RefinedAsNetwork
            from gen.refinement.network.page import network_refinement_page

            began = self.baseline.coefficients
            if isinstance(self.found, RefinedAsNetwork):
                began = self.found.instead.coefficients
            return network_refinement_page(self.found, began, self.model.coefficients)
        from gen.refinement.parts.page import page

        return page(self.found, self.baseline.coefficients)


@one_thread
def refine(
    model: Model,
    *,
    fit: Sequence[RunLike],
    test: Sequence[RunLike],
    accept_change: bool = False,
    progress: Progress = silent,
) -> Refinement:
    """Trace what a model misses in measured runs to physical effects, and add them to the model.

    Parameters
    ----------
    model
        The baseline.
    fit
        Runs to learn from: files or frames.
    test
        Runs that take no part; opened once, at the end.
    accept_change
        Write into the model, too, what looks as if the motor had changed since.
    progress
        Called with what is being done.

    Raises
    ------
    InputError
        If a run is none or is given twice, or no run can be fitted.

    Examples
    --------
    >>> motor = gen.load("coeffs.json")  # doctest: +SKIP
    >>> found = gen.refine(motor, fit=["mon.csv", "tue.csv"], test=["wed.csv"])  # doctest: +SKIP
    >>> found.verdict, found.errors()  # doctest: +SKIP
    >>> found.model.save("refined.json")  # doctest: +SKIP
    """
    from gen.coefficients import parse

    network = model.coefficients.model.network is not None
    several("fit", fit)
    several("test", test)
    if {id(run) for run in fit} & {id(run) for run in test if not isinstance(run, (str, Path))}:
        raise InputError("a run is given as fit and as test; test runs must take no part")
    found: Found | NetworkFound
    with run_files([*fit, *test]) as paths:
        learnt, judged = paths[: len(fit)], paths[len(fit) :]
        if network:
            from gen.refinement.network.refine import refine_network

            found = refine_network(
                model.coefficients, model.text, learnt, judged, progress, accept_change=accept_change
            )
        else:
            from gen.refinement.instead.refine import refine_parts

            found = refine_parts(model.coefficients, model.text, learnt, judged, progress, accept_change=accept_change)
    refined = Model(parse(found.text.encode()), found.text) if found.text != model.text else model
    return Refinement(refined, model, found)
