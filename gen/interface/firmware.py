"""From a model to its firmware, and the proof that both are the same."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from gen.errors import CheckFailed
from gen.interface.arguments import a_path, one_of, within
from gen.interface.model import Model
from gen.interface.threads import one_thread

if TYPE_CHECKING:
    import pandas as pd

    from gen.coefficients.wiring import BoardName
    from gen.lowering.kinds import Arithmetic, ScheduleKind
    from gen.lowering.program import Program
    from gen.verification.verify import CombinationResult, Target


@dataclass(frozen=True, eq=False)
class Build:
    """An emitted project.

    Parameters
    ----------
    folder
        Where it was written.
    program
        What the board holds.
    warnings
        What is allowed and yet worth a look, one sentence each.
    """

    folder: Path
    program: Program
    warnings: tuple[str, ...]

    def guarantees(self) -> pd.DataFrame:
        """A row for each part: ``bound_K``, proven for every PWM sequence (NaN where none is), and ``with_effects``.

        Where effects act, the bound is the baseline's and `gen.verify` measures the error of the whole.
        """
        import pandas as pd

        effects = self.program.effects
        changed = {part.name for part in effects.components} if effects is not None else set()
        rows = [
            {
                "component": part.name,
                "bound_K": part.proof.bound_K if part.proof is not None else float("nan"),
                "with_effects": part.name in changed,
            }
            for part in self.program.parts
        ]
        return pd.DataFrame(rows).set_index("component")


@one_thread
def build(
    model: Model,
    out: Path | str = "firmware_out",
    *,
    arithmetic: Arithmetic = "fixed",
    schedule: ScheduleKind = "table",
    verification: Path | str | None = None,
    force: bool = False,
    warn: Callable[[str], None] = lambda _: None,
) -> Build:
    """Write the complete PlatformIO project of a model.

    Parameters
    ----------
    model
        What to build.
    out
        The folder; replaced only if every file in it is its own and as it wrote it.
    arithmetic, schedule
        Fixed point or float32; coefficients in a table or evaluated on the board.
    verification
        What ``Verification.save`` wrote: its verdict goes into the report. Default: the one in the folder.
    force
        Replace the folder even if files in it were edited.
    warn
        Called with each warning before the work begins.

    Raises
    ------
    InputError
        If the folder holds what is not the project's own, or cannot be written; if the model is a network and the
        schedule `onboard`.
    CheckFailed
        If a part cannot be lowered or its proven error exceeds the file's limit.

    Examples
    --------
    >>> import gen, tempfile
    >>> motor = gen.load("examples/my1016/coeffs.json")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     built = gen.build(motor, f"{folder}/firmware")
    >>> bool((built.guarantees()["bound_K"] < 1e-5).all())
    True
    """
    from gen.files import replace_folder, shown_name
    from gen.firmware.effects_report import unwired
    from gen.firmware.project import kept_verification, project_files, read_verification
    from gen.lowering.lower import lower

    one_of("arithmetic", arithmetic, ("fixed", "float"))
    one_of("schedule", schedule, ("table", "onboard"))
    if schedule == "onboard":
        model.transfer_functions_only("gen build --schedule onboard")
    folder, loaded = a_path("out", out), model.coefficients
    name = shown_name(model.path or Path(f"{model.name}.json"))
    warnings = (*loaded.warnings, *unwired(loaded))
    record = read_verification(Path(verification), loaded) if verification else kept_verification(folder, loaded)
    for warning in warnings:
        warn(warning)
    program = lower(loaded, arithmetic, schedule)
    replace_folder(folder, project_files(loaded, program, name, record), force=force)
    return Build(folder, program, warnings)


@dataclass(frozen=True, eq=False)
class Verification:
    """What a verification found.

    Parameters
    ----------
    model
        What was verified.
    results
        A result for each combination of arithmetic and schedule.
    """

    model: Model
    results: Sequence[CombinationResult]

    def details(self) -> dict[str, Any]:
        """The JSON summary, as ``gen verify --json`` writes it."""
        from gen.verification.verify import summary

        return summary(self.model.coefficients, list(self.results))

    def summary(self) -> pd.DataFrame:
        """A row for each combination and target: ``samples``, ``words`` and how many of them are ``differing``."""
        import pandas as pd

        rows = [
            {
                "combination": result.label,
                "target": target.target,
                "samples": target.samples,
                "words": target.words,
                "differing": target.differing,
            }
            for result in self.results
            for target in result.targets
        ]
        return pd.DataFrame(rows).set_index(["combination", "target"])

    def errors(self) -> pd.DataFrame:
        """Largest error in K against the exact solution, by combination and part: measured, guaranteed, proven anew.

        ``proven_K`` is what follows from the C++ (`gen.check`); NaN where nothing is guaranteed or that is refuted.
        """
        import pandas as pd

        rows = [
            {
                "combination": result.label,
                "component": name,
                "measured_K": measured,
                "guaranteed_K": result.bound_K[name] if result.bound_K[name] is not None else float("nan"),
                "proven_K": result.proven_K.get(name, float("nan")),
            }
            for result in self.results
            for name, measured in result.error_K.items()
        ]
        return pd.DataFrame(rows).set_index(["combination", "component"])

    def check(self) -> None:
        """Fail unless all is equal and within its limits.

        Raises
        ------
        CheckFailed
            With the first thing that is not.
        """
        found = self.details()
        if found["differing"]:
            raise CheckFailed(f"{found['differing']} of {found['words']} words differ")
        for result in self.results:
            if result.refuted is not None:
                raise CheckFailed(f"{result.label}, {result.refuted}")
            for sentence in result.exceeded:
                raise CheckFailed(f"{result.label}, {sentence}")

    def save(self, path: Path | str) -> None:
        """Write the JSON summary, which ``gen build --verification`` takes.

        Raises
        ------
        InputError
            If it cannot be written.
        """
        import json

        from gen.files import write_text

        write_text(Path(path), json.dumps(self.details(), indent=1) + "\n")


@one_thread
def verify(
    model: Model,
    *,
    arithmetic: Arithmetic | Literal["all"] = "all",
    schedule: ScheduleKind | Literal["all"] = "all",
    target: Target = "all",
    compilers: Sequence[str] | None = None,
    board: BoardName | None = None,
    scale: float = 1.0,
    progress: Callable[[str], None] = lambda _: None,
) -> Verification:
    """Prove the generated C++ equal to the reference, bit for bit, and measure error and cost.

    Parameters
    ----------
    model
        What to verify.
    arithmetic, schedule
        One of each, or ``all``; a network has tables alone.
    target
        ``host`` (this computer's compilers), ``avr`` (an emulated Mega) or ``all``.
    compilers
        Of this computer: ``g++``, ``clang++``. Default: those that are there.
    board
        Which is emulated, with the library alone: ``mega`` or ``uno``; None: the one that the file is for.
    scale
        Share of the full campaign of samples.
    progress
        Called with what is being done.

    Raises
    ------
    InputError
        If a tool is missing; if the model is a network and the schedule `onboard`.
    CheckFailed
        If the model cannot be lowered. A difference is no exception: see :meth:`Verification.check`.

    Examples
    --------
    >>> import gen
    >>> motor = gen.load("examples/my1016/coeffs.json")
    >>> options = {"arithmetic": "fixed", "schedule": "table", "target": "host", "scale": 0.005}
    >>> gen.verify(motor, **options).details()["verdict"]
    'equal'
    """
    from gen.toolchain import host_compilers
    from gen.verification.runners import HOST_BUILDS
    from gen.verification.verify import verify as run

    one_of("arithmetic", arithmetic, ("fixed", "float", "all"))
    one_of("schedule", schedule, ("table", "onboard", "all"))
    one_of("target", target, ("host", "avr", "all"))
    if board is not None:
        one_of("board", board, ("mega", "uno"))
    within("scale", scale, 0.001, 10.0)
    is_network = model.coefficients.model.network is not None
    if schedule == "onboard":
        model.transfer_functions_only("gen verify --schedule onboard")
    used = host_compilers(tuple(compilers or ())) if target != "avr" else []
    results = run(
        model.coefficients,
        ("fixed", "float") if arithmetic == "all" else (arithmetic,),
        (schedule,) if schedule != "all" else ("table",) if is_network else ("table", "onboard"),
        target,
        progress=progress,
        scale=scale,
        host_builds=[name for name, (compiler, _) in HOST_BUILDS.items() if compiler in used],
        board=board,
    )
    return Verification(model, results)
