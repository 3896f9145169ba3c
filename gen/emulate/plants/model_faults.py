"""Faults of a motor that is a coefficient file: changes of its heats and of its paths from a time on."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from decimal import Decimal, localcontext
from typing import Literal

from gen.arrays import FloatArray
from gen.errors import InputError
from gen.model.dynamics import ThermalModel
from gen.model.network import Network
from gen.model.network_parts import AMBIENT, Curve, Heat, Path
from gen.model.schedules import EXACT, Polynomial, Schedule

Unit = Literal["%", "W", "K"]

_NUMBER = r"\d+(?:\.\d*)?|\.\d+"
_FORM = re.compile(rf"(?:heat:(\w+)|path:(\w+)-(\w+))=([-+]?(?:{_NUMBER}))(%|W|K)(?:@({_NUMBER}))?", re.ASCII)
_EXAMPLES = "heat:NODE=+20%@600, heat:NODE=+3W or path:NODE-ambient=-50%@600"


@dataclass(frozen=True)
class ModelFault:
    """One change that stays.

    Parameters
    ----------
    of
        The part that is heated otherwise, or both ends of the path that conducts otherwise.
    size, unit
        By how many % of itself a heat or a conductance changes; or, of a heat alone and while PWM acts, by how many W
        (networks), or by how many K the settled rise (transfer functions).
    start_s
        When, s.
    """

    of: tuple[str, ...]
    size: float
    unit: Unit
    start_s: float = 0.0

    @property
    def name(self) -> str:
        """As an option has it, without the time."""
        kind = "heat" if len(self.of) == 1 else "path"
        return f"{kind}:{'-'.join(self.of)}={self.size:+g}{self.unit}"


def parse_faults(text: str, start_s: float, severity: float) -> tuple[ModelFault, ...]:
    """Read ``heat:brush=+20%@600,path:casing-ambient=-50%``.

    Parameters
    ----------
    text
        Any number of faults with a comma between them.
    start_s
        When those begin that do not say it themselves, s.
    severity
        0..1, multiplies every size.

    Raises
    ------
    InputError
        When one is of another form.
    """
    faults = []
    for item in text.split(","):
        found = _FORM.fullmatch(item.strip())
        if found is None:
            raise InputError(
                f'found "{item}", expected {_EXAMPLES}: the plant is a coefficient file (--plant)', place="--fault"
            )
        part, first, second, size, unit, at = found.groups()
        of = (part,) if part is not None else (first, second)
        if len(of) == 2 and unit != "%":
            raise InputError(f'found "{item}", expected a path\'s change in %', place="--fault")
        if unit == "%" and float(size) < -100.0:
            raise InputError(f'found "{item}", expected at least -100%', place="--fault")
        known: Unit = "%" if unit == "%" else "W" if unit == "W" else "K"
        faults.append(ModelFault(of, float(size) * severity, known, start_s if at is None else float(at)))
    return tuple(faults)


def check_faults(model: ThermalModel, faults: Sequence[ModelFault]) -> None:
    """Find out whether a model has what faults change.

    Raises
    ------
    InputError
        With the first part, path or unit that it has not.
    """
    network = model.network
    parts = model.component_names if network is None else tuple(node.name for node in network.nodes)
    for fault in faults:
        strangers = set(fault.of) - {*parts, *((AMBIENT,) if len(fault.of) == 2 else ())}
        if strangers:
            raise _wrong(fault, f'{model.name} has no part "{min(strangers)}"; it has {", ".join(parts)}')
        if network is None:
            if len(fault.of) == 2:
                raise _wrong(fault, f"{model.name} has transfer functions, and so no paths; expected heat:PART")
            if fault.unit == "W":
                raise _wrong(fault, f"{model.name} has transfer functions, which know no W; expected % or K")
        elif fault.unit == "K":
            raise _wrong(fault, f"{model.name} is a network; expected % or W")
        elif len(fault.of) == 2 and not any(_joins(path, fault.of) for path in network.paths):
            paths = ", ".join(f"{path.first}-{path.second or AMBIENT}" for path in network.paths)
            raise _wrong(fault, f"{model.name} has no such path; it has {paths}")
        elif fault.unit == "%" and len(fault.of) == 1 and all(heat.node != fault.of[0] for heat in network.heats):
            raise _wrong(fault, f'no heat of {model.name} acts at "{fault.of[0]}", of which it could be a share; say W')


def faulty(network: Network, faults: Sequence[ModelFault]) -> Network:
    """A network with its heats and paths as faults make them, which :func:`check_faults` has passed."""
    for fault in faults:
        times = 1.0 + fault.size / 100.0
        if len(fault.of) == 2:
            paths = [
                replace(path, curve=_scaled(path.curve, times)) if _joins(path, fault.of) else path
                for path in network.paths
            ]
            network = replace(network, paths=tuple(paths))
        elif fault.unit == "W":
            more = Heat(fault.of[0], Curve(Polynomial((fault.size,)), at_rest=0.0))
            network = replace(network, heats=(*network.heats, more))
        else:
            heats = [
                replace(heat, curve=_scaled(heat.curve, times)) if heat.node == fault.of[0] else heat
                for heat in network.heats
            ]
            network = replace(network, heats=tuple(heats))
    return network


def settled_K(model: ThermalModel, faults: Sequence[ModelFault], pwm: int) -> dict[str, float]:
    """By how much faults change the rise at which parts by transfer functions settle, K, at a PWM of either sign."""
    found = dict.fromkeys(model.component_names, 0.0)
    for fault in faults:
        (part,) = fault.of
        if fault.unit == "%":
            found[part] += fault.size / 100.0 * float(model.component(part).steady_rise([abs(pwm)])[0])
        elif pwm:
            found[part] += fault.size
    return found


@dataclass(frozen=True)
class _Scaled(Schedule):
    schedule: Schedule
    times: float

    def __call__(self, pwm: FloatArray) -> FloatArray:
        return self.times * self.schedule(pwm)

    def exact(self, pwm: int) -> Decimal:
        with localcontext(EXACT):
            return Decimal(self.times) * self.schedule.exact(pwm)


def _scaled(curve: Curve, times: float) -> Curve:
    return Curve(_Scaled(curve.turning, times), None if curve.at_rest is None else times * curve.at_rest)


def _joins(path: Path, ends: tuple[str, ...]) -> bool:
    return {path.first, path.second or AMBIENT} == set(ends)


def _wrong(fault: ModelFault, message: str) -> InputError:
    return InputError(f'found "{fault.name}", but {message}', place="--fault")
