"""The rivals: what each is made of, and what it lacks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from benchmarks.rivals.code import casadi_step, emlearn_net, tables
from gen.model import ThermalModel

SOURCES = Path(__file__).parent / "sources"


@dataclass(frozen=True)
class Made:
    """What has to be compiled beside a rival's own file.

    Attributes
    ----------
    sources
        Generated C.
    includes
        Folders of headers beyond the rival's.
    defines
        Macros.
    """

    sources: tuple[Path, ...] = ()
    includes: tuple[Path, ...] = ()
    defines: tuple[str, ...] = ()


Making = Callable[[ThermalModel, Path], Made]


def _nothing(model: ThermalModel, folder: Path) -> Made:
    return Made()


def _header(write: Callable[[ThermalModel, Path], None]) -> Making:
    def make(model: ThermalModel, folder: Path) -> Made:
        write(model, folder)
        return Made(includes=(folder,))

    return make


def _casadi(model: ThermalModel, folder: Path) -> Made:
    defines = casadi_step.write(model, folder)
    return Made((folder / "casadi_step.c",), defines=tuple(defines))


def _emlearn(model: ThermalModel, folder: Path) -> Made:
    return Made(includes=(folder, emlearn_net.write(model, folder)))


@dataclass(frozen=True)
class Rival:
    """One way to do it.

    Attributes
    ----------
    letter, title
        What the table calls it.
    source
        Its file in ``sources/``.
    lacks
        What a user would have to add or to know, short.
    make
        Writes what of it is generated into a folder, for the MY1016's model.
    word, unit_K
        Type of its output, and what 1 of it is in K.
    clean
        Whether all of it is written by hand here, so that it must compile without a warning.
    """

    letter: str
    title: str
    source: str
    lacks: str
    make: Making = field(default=_nothing)
    word: Literal["float", "int32_t"] = "float"
    unit_K: float = 1.0
    clean: bool = True


RIVALS = (
    Rival("a", "sketch: exp(), Euler", "euler.cpp", "a bound; any check"),
    Rival("b", "the same, coefficients cached", "euler_cached.cpp", "a bound; any check"),
    Rival(
        "c", "difference equation, float32", "direct_float.cpp",
        "order 3: poles too near 1 for float32", _header(tables.direct_form),
    ),
    Rival(
        "d", "difference equation, Q31", "direct_q31.cpp", "order 3: its gain rounds to 0",
        _header(tables.direct_q31), "int32_t", tables.Q31_RISE_K / 2.0**31,
    ),
    Rival("e", "CasADi's C, Runge-Kutta 4", "casadi.cpp", "the schedule as a table; a bound", _casadi, clean=False),
    Rival("f", "fixed-step solver, Runge-Kutta 4", "solver.cpp", "a bound; any check"),
    Rival(
        "g", "python-control and a matrix loop", "state_space.cpp",
        "1 - z: Ad rounds to float32", _header(tables.state_space),
    ),
    Rival("h", "neural network, emlearn", "neural.cpp", "the equation: it knows what it was shown", _emlearn,
          clean=False),
)  # fmt: skip
