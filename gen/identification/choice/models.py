"""Either kind of model from runs in memory: the fit, the coefficient file's text, and what is read back of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from gen.coefficients import Coefficients
from gen.errors import CheckFailed
from gen.identification.logs.data import Data, components_of, make_data
from gen.identification.logs.sources import Source
from gen.identification.network.data import make_network_data
from gen.identification.network.identify import NetworkFound, identify_network, simplified
from gen.identification.network.telling.document import network_text
from gen.identification.network.telling.summary import Summary
from gen.identification.parts.coefficient_file import coefficient_text, usable
from gen.identification.parts.identify import Identified, identify
from gen.identification.settings import Settings
from gen.lowering.network.lower import lower_network

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Options:
    """What the user sets.

    Attributes
    ----------
    settings
        Of the board and the motor.
    ambient
        In degC, for runs without a measured one, or None.
    max_order, max_hidden
        Highest order of a part, most hidden nodes of a network.
    heat
        Of a network: columns that heat it beside its PWM.
    machine
        Of a network: what the input drives, nothing for what the runs say.
    """

    settings: Settings
    ambient: float | None = None
    max_order: int = 4
    max_hidden: int = 3
    heat: tuple[str, ...] = ()
    machine: str = ""


@dataclass(frozen=True, eq=False)
class PartsModel:
    """A transfer function for each part.

    Attributes
    ----------
    data, found
        The runs, and what each part was found to be.
    settings
        Of the board and the motor.
    text, coefficients
        The coefficient file, and what is read back of it.
    """

    data: Data
    found: Mapping[str, Identified]
    settings: Settings
    text: str
    coefficients: Coefficients

    def noted(self, note: str) -> PartsModel:
        """Give the same with a sentence more in the file's provenance."""
        text, coefficients = coefficient_text(self.data, self.found, self.settings, note)
        return replace(self, text=text, coefficients=coefficients)


@dataclass(frozen=True, eq=False)
class NetworkModel:
    """One network for all parts.

    Attributes
    ----------
    result
        The runs, the network and how it was judged.
    settings
        Of the board and the motor.
    text, coefficients
        The coefficient file, and what is read back of it.
    """

    result: NetworkFound
    settings: Settings
    text: str
    coefficients: Coefficients

    @property
    def good_to_K(self) -> float | None:
        """See `Summary`; None, too, where it leaves out a temperature that is in the runs."""
        data = self.result.data
        complete = set(data.names) == set(components_of(data.sources))
        return Summary(self.result).good_to_K if complete else None

    def noted(self, note: str) -> NetworkModel:
        """Give the same with a sentence more in the file's provenance."""
        text, coefficients = network_text(self.result, self.settings, note)
        return replace(self, text=text, coefficients=coefficients)


def parts_of(sources: Sequence[Source], options: Options, progress: Progress) -> PartsModel:
    """Identify part by part.

    Raises
    ------
    InputError
        When nothing can be identified from the runs.
    CheckFailed
        When what was found is no model that can be built.
    """
    settings = options.settings
    data = make_data(sources, options.ambient)
    found = identify(data, progress, options.max_order, settings.sample_time_s)
    data, found = usable(data, found, settings)
    text, coefficients = coefficient_text(data, found, settings)
    return PartsModel(data, found, settings, text, coefficients)


def network_of(sources: Sequence[Source], options: Options, progress: Progress) -> NetworkModel:
    """Identify one network; raises as :func:`parts_of` does.

    What goes with temperature and no board can be shown to follow is left out: a model is there to be built.
    """
    settings = options.settings
    data = make_network_data(
        sources, options.ambient, settings.full_scale, options.heat, options.machine, settings.sample_time_s
    )
    result = identify_network(data, progress, options.max_hidden)
    while result.simpler and (refused := _refused(result, settings)):
        progress("last fit, with less that goes with temperature")
        result = simplified(result, f"as no board could be built: {refused}")
    text, coefficients = network_text(result, settings)
    return NetworkModel(result, settings, text, coefficients)


def _refused(result: NetworkFound, settings: Settings) -> str:
    """Why a network cannot be built; nothing where it can."""
    try:
        lower_network(network_text(result, settings)[1], "fixed")
    except CheckFailed as error:
        return str(error)
    return ""
