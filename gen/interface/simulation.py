"""The reference simulator on a run."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

from gen.interface.arguments import one_of
from gen.interface.files import RunLike, run_files
from gen.interface.model import Model
from gen.interface.threads import one_thread

if TYPE_CHECKING:
    import pandas as pd

    from gen.reference.simulate import Start


def simulate(
    model: Model,
    run: RunLike,
    arithmetic: Literal["exact", "fixed", "float"] = "exact",
    *,
    start: Start = "auto",
    warn: Callable[[str], None] = lambda _: None,
) -> pd.DataFrame:
    """Run a model along a run's PWM, ambient and channels.

    Parameters
    ----------
    model
        From :func:`gen.load`, for example.
    run
        A run file or a frame.
    arithmetic
        ``exact`` solves the differential equation; ``fixed`` and ``float`` compute the board's own words.
    start
        ``measured`` starts each part from its first measured temperature, ``ambient`` from ambient, ``auto`` from the
        measured one where there is one. A network's hidden nodes start where they would rest between these.
    warn
        Called with what the run says and the model does not heed: another ambient than the fixed one it counts from.

    Returns
    -------
    pandas.DataFrame
        Indexed by the run's ``time_s`` (s): ``<component>_degC`` for each part, and the raw state words of ``fixed``
        and ``float``.

    Raises
    ------
    InputError
        If the run is none, or lacks what the model needs.
    CheckFailed
        If the model cannot be lowered to the board's arithmetic.

    Examples
    --------
    >>> import gen, pandas as pd
    >>> motor = gen.load("examples/my1016/coeffs.json")
    >>> run = pd.DataFrame({"pwm": [153, 153, 0]}, index=pd.Index([0.0, 3600.0, 7200.0], name="time_s"))
    >>> gen.simulate(motor, run)["casing_degC"].round(2).tolist()
    [30.0, 59.32, 63.67]
    """
    one_of("arithmetic", arithmetic, ("exact", "fixed", "float"))
    one_of("start", start, ("auto", "ambient", "measured"))

    from gen.replay import overruled_ambient, read_for

    loaded = model.coefficients
    with run_files([run]) as (path,):
        measured = read_for(loaded, path)
        if (overruled := overruled_ambient(loaded, measured, str(path))) is not None:
            warn(overruled)
        from gen.reference.simulate import simulate_run  # slow to import: what is wrong with the file was told before

        columns = one_thread(simulate_run)(loaded, measured, arithmetic, start, str(path))

    import pandas as pd

    return pd.DataFrame(columns).set_index("time_s")
