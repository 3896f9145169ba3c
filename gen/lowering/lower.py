"""Lower a whole coefficient file: every component, for one arithmetic and one kind of schedule."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby

from gen.coefficients import Coefficients
from gen.errors import CheckFailed
from gen.lowering import fixed
from gen.lowering.dynamics import LoweringError
from gen.lowering.program import Arithmetic, FixedComponent, ScheduleKind
from gen.model import ThermalModel


@dataclass(frozen=True)
class Shape:
    """Components that the same code advances: they differ in their coefficients only.

    Attributes
    ----------
    identifier
        A capital letter.
    members
        Indices into the program's components.
    """

    identifier: str
    members: tuple[int, ...]

    @property
    def place(self) -> str:
        """Name of the array in the board's state."""
        return self.identifier.lower()


@dataclass(frozen=True)
class Program:
    """What the board holds, all of it.

    Attributes
    ----------
    arithmetic, schedule
        Which of the four combinations.
    model
        What was lowered.
    components
        In the order of the coefficient file.
    shapes
        In the order of the board's state.
    """

    arithmetic: Arithmetic
    schedule: ScheduleKind
    model: ThermalModel
    components: tuple[FixedComponent, ...]
    shapes: tuple[Shape, ...]

    @property
    def saturates(self) -> bool:
        """Whether any component has no proof and saturates."""
        return any(component.saturates for component in self.components)


def lower(coefficients: Coefficients, arithmetic: Arithmetic, schedule: ScheduleKind) -> Program:
    """Lower every component.

    Raises
    ------
    CheckFailed
        If a component cannot be lowered, or its proven error exceeds the file's limit; the message names it.
    """
    model = coefficients.model
    limit = coefficients.accuracy.fixed_limit_K
    components = []
    for component in model.components:
        try:
            lowered = fixed.lower_component(model, component, limit)
        except LoweringError as error:
            raise CheckFailed(str(error)) from error
        if lowered.proof is not None and lowered.proof.bound_K > limit:
            raise CheckFailed(
                f"component {component.name}: the guaranteed error bound of {lowered.proof.bound_K:.2g} K exceeds "
                f"$.accuracy.fixed_limit_K = {limit:.2g} K"
            )
        components.append(lowered)
    return Program(arithmetic, schedule, model, tuple(components), _shapes(components))


def _shapes(components: list[FixedComponent]) -> tuple[Shape, ...]:
    keys = [(c.order, c.substeps, c.layout, c.start_range_mK, c.saturates) for c in components]
    first = {key: index for index, key in reversed(list(enumerate(keys)))}
    order = sorted(range(len(components)), key=lambda index: (first[keys[index]], index))
    groups = [tuple(members) for _, members in groupby(order, key=lambda index: first[keys[index]])]
    return tuple(Shape(chr(ord("A") + number), members) for number, members in enumerate(groups))
