"""What each effect costs on the Mega: the library built with all of them, and without one at a time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from gen.coefficients import Coefficients
from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.effects import lower_effects
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.float32 import FloatComponent
from gen.lowering.program import Program
from gen.verification.profiles import campaign, with_channels
from gen.verification.runners import AvrRunner, Cost, write_library

_LANES, _LENGTH = 4, 60


@dataclass(frozen=True)
class EffectCost:
    """One effect's part of the whole.

    Attributes
    ----------
    name, component
        Which.
    cycles
        Mean of a step at constant PWM.
    flash_bytes, ram_bytes
        Of the model. What several effects share (a chain, a table) is in none of them.
    """

    name: str
    component: str
    cycles: int
    flash_bytes: int
    ram_bytes: int


def effect_costs(
    coefficients: Coefficients, program: Program, folder: Path, progress: Callable[[str], None] = lambda _: None
) -> list[EffectCost]:
    """Build and run the library without each effect.

    Parameters
    ----------
    coefficients, program
        What is emitted.
    folder
        Where to build.
    progress
        Told what is being done.
    """
    found: list[EffectCost] = []
    if program.effects is None:
        return found
    components = [c for c in program.components if isinstance(c, FixedComponent | FloatComponent)]
    whole = _cost(coefficients, program, folder / "all")
    for number, applied in enumerate(coefficients.effects):
        progress(f"{program.label}: cost of {applied.effect.name} of {applied.component}")
        fewer = replace(coefficients, effects=coefficients.effects[:number] + coefficients.effects[number + 1 :])
        without = replace(program, effects=lower_effects(fewer, program.arithmetic, components))
        rest = _cost(fewer, without, folder / f"without-{number}")
        found.append(
            EffectCost(
                applied.effect.name,
                applied.component,
                round(whole.cycles_constant_mean - rest.cycles_constant_mean),
                whole.flash_bytes - rest.flash_bytes,
                whole.ram_bytes - rest.ram_bytes,
            )
        )
    return found


def _cost(coefficients: Coefficients, program: Program, folder: Path) -> Cost:
    folder.mkdir()
    context = project_context(coefficients, program, coefficients.name)
    library = write_library(program, context, render.library(context), folder)
    profile = with_channels(campaign(program.model, _LANES, _LENGTH, seed=99), program.channels)
    board = AvrRunner(library, folder.parent / "cache")
    board.run(profile)
    return board.cost(profile)
