"""From identified motor-temperature coefficients to proven firmware for the Arduino Mega 2560.

The Python interface: :func:`load`, :func:`read_run`, :func:`identify`, :func:`refine`, :func:`plan`,
:func:`simulate`, :func:`build`, :func:`verify` and :func:`check`, as the commands of the same names, and
:func:`import_runs`, as the command `import`, which is a reserved word here. Importing the package is quick:
what a function needs is imported when it is called.
"""

from __future__ import annotations

from gen.errors import CheckFailed, InputError

TYPE_CHECKING = False
"""As type checkers know it: `typing` itself would have to be imported before the command can take an interrupt."""
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
    from gen.version import __version__

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
    """Import the interface when it is first used; the version, too, for which the package's metadata is looked up."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if name == "__version__":
        from gen.version import __version__

        return __version__
    from gen import interface

    return getattr(interface, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
