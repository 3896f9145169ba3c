"""From a model and its runs to the run that would tell most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gen.errors import InputError
from gen.interface.arguments import several, whole, within
from gen.interface.files import RunLike, run_files
from gen.interface.model import Model
from gen.interface.reported import Progress, silent
from gen.interface.threads import one_thread

if TYPE_CHECKING:
    import pandas as pd

    from gen.planning.planned_run import Plan as Found


@dataclass(frozen=True, eq=False)
class Plan:
    """A planned run and what it is expected to decide.

    Parameters
    ----------
    found
        All that was found.
    """

    found: Found

    @property
    def hypotheses(self) -> tuple[str, ...]:
        """What the runs have left open; the name that refinement gives comes first."""
        return tuple(one.label for one in self.found.hypotheses)

    @property
    def nothing_to_decide(self) -> bool:
        """Whether one hypothesis is left, and what it predicts is known to within the sensors' noise."""
        return self.found.decided

    @property
    def warnings(self) -> tuple[str, ...]:
        """What to look at, one sentence each."""
        return self.found.warnings

    @property
    def profile(self) -> pd.DataFrame:
        """The planned run: ``pwm`` (counts) by ``time_s`` (s), each held until the next row."""
        import pandas as pd

        time, pwm = self.found.rows()
        return pd.DataFrame({"pwm": pwm}, index=pd.Index(time, name="time_s"))

    def separations(self) -> pd.DataFrame:
        """A row for each pair of hypotheses: how far apart they are in the planned run and in the best plain one.

        ``planned_K`` and ``plain_K`` are what is left of the difference of both predictions when all free numbers of
        one are fitted to the other, root mean square over sensors and time; ``_floors`` the same in noise floors.
        """
        import pandas as pd

        columns = ["first", "second", "planned_K", "planned_floors", "plain_K", "plain_floors"]
        return pd.DataFrame(self.details()["pairs"], columns=columns)

    def details(self) -> dict[str, Any]:
        """The JSON summary, as ``gen plan --json`` writes it."""
        return self.found.summary()

    def save(self, path: Path | str) -> None:
        """Write the profile, which says in a comment what it is expected to decide.

        Raises
        ------
        InputError
            If it cannot be written.
        """
        from gen.runs import write_columns

        time, pwm = self.found.rows()
        write_columns(path, {"time_s": time, "pwm": pwm}, self.found.comments())


@one_thread
def plan(
    model: Model,
    runs: Sequence[RunLike],
    *,
    hours: float,
    max_pwm: int | None = None,
    limit_degC: float | None = None,
    margin_K: float = 3.0,
    ambient_degC: float | None = None,
    reverse: bool | None = None,
    seed: int = 0,
    progress: Progress = silent,
) -> Plan:
    """Plan the run that would tell most of what runs have left open.

    Parameters
    ----------
    model
        A model that holds a network.
    runs
        The runs that there are: files or frames.
    hours
        Length of the planned run, 0.5 to 48.
    max_pwm
        Greatest |PWM|, counts; by itself the file's.
    limit_degC
        Greatest temperature of any part; by itself that of the file's domain. Limits of over-temperature alarms hold
        beside it.
    margin_K
        How far every prediction stays below.
    ambient_degC
        Of the room; by itself as in the runs.
    reverse
        Whether it may turn backwards; by itself where a run did, and a hypothesis or the file depends on it.
    seed
        Of the search.
    progress
        Called with what is being done.

    Raises
    ------
    InputError
        If a run is none, the model holds no network, or no run keeps to the limits.

    Examples
    --------
    >>> motor = gen.load("motor.json")  # doctest: +SKIP
    >>> planned = gen.plan(motor, ["mon.csv"], hours=3)  # doctest: +SKIP
    >>> planned.hypotheses, planned.separations()  # doctest: +SKIP
    >>> planned.save("next.csv")  # doctest: +SKIP
    """
    several("runs", runs)
    within("hours", hours, 0.5, 48.0)
    within("margin_K", margin_K, 0.0, 1000.0)
    if max_pwm is not None:
        whole("max_pwm", max_pwm, 1, 255)
    if model.coefficients.model.network is None:
        file = None if model.path is None else str(model.path)
        raise InputError("holds transfer functions; gen plan needs a network", file=file, place="$.components")
    from gen.planning.limits import Wishes
    from gen.planning.plan import plan_run

    wishes = Wishes(float(hours), max_pwm, limit_degC, margin_K, ambient_degC, reverse, seed)
    with run_files(runs) as paths:
        return Plan(plan_run(model.coefficients, paths, wishes, progress))
