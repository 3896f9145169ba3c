"""From measured runs to a model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, overload

from gen.coefficients.sample_time import milliseconds
from gen.errors import InputError
from gen.interface.arguments import one_of, several, whole, within
from gen.interface.files import RunLike, run_files
from gen.interface.model import Model
from gen.interface.reported import Progress, Reported, silent
from gen.interface.threads import one_thread

if TYPE_CHECKING:
    import pandas as pd

    from gen.identification.choice.decision import Decision
    from gen.identification.choice.models import NetworkModel, PartsModel
    from gen.identification.logs.data import Data
    from gen.identification.network.identify import NetworkFound
    from gen.identification.network.telling.summary import Summary
    from gen.identification.parts.identify import Identified


@dataclass(frozen=True, eq=False)
class Identification(Reported):
    """What was identified.

    Parameters
    ----------
    model
        The model, as :func:`gen.load` would give it.
    data, found
        The runs, and what each part was found to be.
    choice
        Why it is this kind of model; None where the kind was asked for.
    """

    model: Model
    data: Data
    found: Mapping[str, Identified]
    choice: Decision | None = None

    def details(self) -> dict[str, Any]:
        """All that was found as plain numbers and words, as ``gen identify --json`` writes it."""
        from gen.identification.parts.summary import summary, without_nan

        details: dict[str, Any] = without_nan(summary(self.data, self.found) | _choice(self.choice))
        return details

    @property
    def verdict(self) -> str:
        """Whether the model is good to be built, in one line."""
        from gen.identification.parts.summary import verdict

        return verdict(self.found)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What to look at, one sentence each."""
        return tuple(self.details()["warnings"])

    def summary(self) -> pd.DataFrame:
        """A row for each part and identified |PWM|.

        Columns: ``order``, ``steady_rise_K`` with its 95 % interval (``_low``, ``_high``), ``left_out_rms_K`` (the
        model's error there when that speed is left out) and the time constants in s, the slowest first.
        """
        import pandas as pd

        rows = []
        for name, part in self.details()["components"].items():
            turning = [pwm for pwm in part["speeds"] if int(pwm)]
            left = dict(zip(turning, part["schedules"]["leave_one_speed_out_K"] or (), strict=False))
            for pwm, entry in part["speeds"].items():
                rise = entry.get("steady_rise_K", {"value": None, "interval": (None, None)})
                labels = [key for key in entry if key.startswith("tau")]
                rows.append(
                    {
                        "component": name,
                        "pwm": int(pwm),
                        "order": part["order"],
                        "steady_rise_K": rise["value"],
                        "steady_rise_K_low": rise["interval"][0],
                        "steady_rise_K_high": rise["interval"][1],
                        "left_out_rms_K": left.get(pwm),
                        **{f"{label}_s": entry[label]["value"] for label in labels},
                    }
                )
        return pd.DataFrame(rows).set_index(["component", "pwm"])

    def text(self) -> str:
        """What the command prints."""
        from gen.identification.parts.summary import text

        return _with_choice(text(self.data, self.found), self.choice)

    def html(self) -> str:
        """The report as one HTML page."""
        from gen.identification.parts.page import report_html

        return report_html(self.data, self.found, self.model.coefficients, self.choice)


@dataclass(frozen=True, eq=False)
class NetworkIdentification(Reported):
    """One network for the whole motor.

    Parameters
    ----------
    model
        The model, as :func:`gen.load` would give it.
    result
        The runs, the network and how it was judged.
    choice
        Why it is this kind of model; None where the kind was asked for.
    """

    model: Model
    result: NetworkFound
    choice: Decision | None = None

    @property
    def _said(self) -> Summary:
        from gen.identification.network.telling.summary import Summary

        return Summary(self.result)

    def details(self) -> dict[str, Any]:
        """All that was found as plain numbers and words, as ``gen identify --json`` writes it."""
        from gen.identification.network.telling.as_json import as_json
        from gen.identification.parts.summary import without_nan

        details: dict[str, Any] = without_nan(as_json(self._said) | _choice(self.choice))
        return details

    @property
    def verdict(self) -> str:
        """Whether the model is good to be built, in one line."""
        return self._said.verdict

    @property
    def warnings(self) -> tuple[str, ...]:
        """What to look at, one sentence each."""
        return tuple(self._said.warnings())

    def summary(self) -> pd.DataFrame:
        """A row for each part and |PWM| that was held.

        Columns: ``steady_rise_K`` with its 95 % interval (``_low``, ``_high``), and ``left_out_rms_K``, the root mean
        square error of the part on data that took no part in the fit.
        """
        import pandas as pd

        rows = []
        for name, part in self.details()["components"].items():
            for pwm, entry in part["speeds"].items():
                low, high = entry["steady_rise_K"]["interval"]
                rows.append(
                    {
                        "component": name,
                        "pwm": int(pwm),
                        "steady_rise_K": entry["steady_rise_K"]["value"],
                        "steady_rise_K_low": low,
                        "steady_rise_K_high": high,
                        "left_out_rms_K": part["left_out_rms_K"],
                    }
                )
        return pd.DataFrame(rows).set_index(["component", "pwm"])

    def curves(self) -> dict[str, pd.DataFrame]:
        """Measured and modelled readings of each run, means over bins.

        Returns
        -------
        dict of pandas.DataFrame
            By run, indexed by ``time_s`` (middle of the bin, s): ``<part>_degC`` and ``<part>_model_degC``; NaN where
            nothing was read.
        """
        import pandas as pd

        from gen.identification.network.identify import curves

        return {
            name: pd.DataFrame(columns, index=pd.Index(time, name="time_s"))
            for name, (time, columns) in curves(self.result).items()
        }

    def text(self) -> str:
        """What the command prints."""
        from gen.identification.network.telling.text import text

        return _with_choice(text(self._said), self.choice)

    def html(self) -> str:
        """The report as one HTML page."""
        from gen.identification.network.telling.page import network_report

        return network_report(self.result, self.model.coefficients, self.choice)


def _choice(choice: Decision | None) -> dict[str, Any]:
    return {} if choice is None else {"choice": choice.as_json()}


def _with_choice(text: str, choice: Decision | None) -> str:
    return text if choice is None else f"chosen: {choice.why}\n{text}"


@overload
def identify(
    runs: Sequence[RunLike],
    *,
    model: Literal["auto"] = "auto",
    name: str = "motor",
    ambient: float | None = None,
    sample_time: float = 0.25,
    full_scale: int = 255,
    rpm: float = 2650.0,
    max_order: int = 4,
    max_hidden: int = 3,
    heat: Sequence[str] = (),
    drives: Literal["", "motor", "heater"] = "",
    progress: Progress = silent,
) -> Identification | NetworkIdentification: ...


@overload
def identify(
    runs: Sequence[RunLike],
    *,
    model: Literal["parts"],
    name: str = "motor",
    ambient: float | None = None,
    sample_time: float = 0.25,
    full_scale: int = 255,
    rpm: float = 2650.0,
    max_order: int = 4,
    max_hidden: int = 3,
    heat: Sequence[str] = (),
    drives: Literal["", "motor", "heater"] = "",
    progress: Progress = silent,
) -> Identification: ...


@overload
def identify(
    runs: Sequence[RunLike],
    *,
    model: Literal["network"],
    name: str = "motor",
    ambient: float | None = None,
    sample_time: float = 0.25,
    full_scale: int = 255,
    rpm: float = 2650.0,
    max_order: int = 4,
    max_hidden: int = 3,
    heat: Sequence[str] = (),
    drives: Literal["", "motor", "heater"] = "",
    progress: Progress = silent,
) -> NetworkIdentification: ...


@one_thread
def identify(
    runs: Sequence[RunLike],
    *,
    model: Literal["auto", "parts", "network"] = "auto",
    name: str = "motor",
    ambient: float | None = None,
    sample_time: float = 0.25,
    full_scale: int = 255,
    rpm: float = 2650.0,
    max_order: int = 4,
    max_hidden: int = 3,
    heat: Sequence[str] = (),
    drives: Literal["", "motor", "heater"] = "",
    progress: Progress = silent,
) -> Identification | NetworkIdentification:
    """Identify a speed-scheduled model from measured runs.

    Parameters
    ----------
    runs
        Run files or frames.
    model
        ``parts``: a transfer function for each part. ``network``: one network of heat capacities for all of them.
        ``auto``: the network where it is good on what was left out; else both are fitted, up to four times each, and
        the error on what was left out says which is taken.
    name
        The model's name.
    ambient
        In degC, for runs without a measured one.
    sample_time
        The board's, s.
    full_scale
        The PWM count that is 100 %.
    rpm
        Speed at full scale.
    max_order
        Highest order of a part to try, 1..4.
    max_hidden
        Most hidden nodes of a network to try, 0..3.
    heat
        Measured columns that heat the motor beside its PWM, such as ``current_A`` (by its square) or ``heater2_W``;
        a network takes them, parts do not, so that ``auto`` takes the network.
    drives
        What the input drives: a ``motor``, which moves air, or a ``heater``, which does not, and whose heat goes with
        the input (of a current or a voltage: with its square). Nothing: what the runs say, else a motor. Networks only.
    progress
        Called with what is being done.

    Raises
    ------
    InputError
        If a run is none, or nothing can be identified from the runs: for ``auto`` by neither kind.
    CheckFailed
        If what was found is no model that can be built: for ``auto`` of neither kind.

    Examples
    --------
    >>> found = gen.identify(["cold_40.csv", "cold_70.csv", "cold_100.csv"])  # doctest: +SKIP
    >>> found.choice.why  # doctest: +SKIP
    >>> found.summary()  # doctest: +SKIP
    >>> found.model.save("coeffs.json")  # doctest: +SKIP
    """
    from gen.coefficients.names import name_fault
    from gen.identification.choice.choose import choose
    from gen.identification.choice.models import Options, network_of, parts_of
    from gen.identification.logs.sources import read_sources
    from gen.identification.settings import Settings
    from gen.runs.drive import MACHINES

    several("runs", runs)
    one_of("model", model, ("auto", "parts", "network"))
    one_of("drives", drives, ("", *MACHINES))
    if ambient is not None:
        within("ambient", ambient, -273.15, 1000.0)
    within("sample_time", sample_time, 0.001, 3600.0)
    milliseconds(sample_time, "sample_time")
    whole("full_scale", full_scale, 1, 255)
    within("rpm", rpm, 1e-3, 1e9)
    whole("max_order", max_order, 1, 4)
    whole("max_hidden", max_hidden, 0, 3)
    fault = name_fault(name)
    if fault:
        raise InputError(fault, place="name")
    heat = (heat,) if isinstance(heat, str) else tuple(heat)
    if heat and model == "parts":
        raise InputError("found columns that heat the motor; parts take none, expected a network", place="heat")
    if drives and model == "parts":
        raise InputError("found what the input drives; parts know nothing of that, expected a network", place="drives")
    options = Options(Settings(name, sample_time, full_scale, rpm), ambient, max_order, max_hidden, heat, drives)
    with run_files(runs) as paths:
        progress("reading")
        sources = read_sources(paths)
        if model == "parts":
            return _found(parts_of(sources, options, progress))
        if model == "network" or heat:
            return _found(network_of(sources, options, progress))
        chosen = choose(sources, options, progress)
    return _found(chosen.model, chosen.decision)


def _found(fitted: PartsModel | NetworkModel, choice: Decision | None = None) -> Identification | NetworkIdentification:
    from gen.identification.choice.models import PartsModel

    model = Model(fitted.coefficients, fitted.text)
    if isinstance(fitted, PartsModel):
        return Identification(model, fitted.data, fitted.found, choice)
    return NetworkIdentification(model, fitted.result, choice)
