"""From identified motor-temperature coefficients to proven firmware for the Arduino Mega 2560.

The Python interface: :func:`load`, :func:`read_run`, :func:`identify`, :func:`refine`, :func:`plan`,
:func:`simulate`, :func:`build`, :func:`verify` and :func:`check`, as the commands of the same names, and
:func:`import_runs`, as the command `import`, which is a reserved word here. Importing the package is quick:
what a function needs is imported when it is called.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from gen.errors import CheckFailed, InputError
from gen.version import __version__

if TYPE_CHECKING:
    from gen.interface import (
        Build,
        Check,
        Identification,
        Import,
        Model,
        NetworkIdentification,
        Plan,
        Refinement,
        Verification,
        build,
        check,
        identify,
        import_runs,
        load,
        plan,
        read_run,
        refine,
        simulate,
        verify,
    )

__all__ = [
    "Build",
    "Check",
    "CheckFailed",
    "Identification",
    "Import",
    "InputError",
    "Model",
    "NetworkIdentification",
    "Plan",
    "Refinement",
    "Verification",
    "__version__",
    "build",
    "check",
    "identify",
    "import_runs",
    "load",
    "plan",
    "read_run",
    "refine",
    "simulate",
    "verify",
]


def __getattr__(name: str) -> object:
    """Import the interface when it is first used."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from gen import interface

    return getattr(interface, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
