"""What any logger wrote, to run files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from gen.errors import InputError
from gen.interface.arguments import a_path, one_of, several, within

if TYPE_CHECKING:
    import pandas as pd

    from gen.importing import Plan, Written


@dataclass(frozen=True)
class Import:
    """What an import wrote, and what it took the log's columns for."""

    _plan: Plan
    _written: Written

    @property
    def runs(self) -> list[Path]:
        """The run files."""
        return list(self._written.files)

    @property
    def rows(self) -> list[int]:
        """How many each run file has."""
        return list(self._written.rows)

    @property
    def mapping(self) -> Path | None:
        """The mapping file, if it was written."""
        return self._written.mapping

    @property
    def warnings(self) -> list[str]:
        """What is suspicious, with the option that would correct it."""
        decided = [warning for entry in self._plan.decided for warning in entry.warnings]
        return decided + [warning for made in self._written.converted for warning in made.warnings]

    @property
    def notes(self) -> list[str]:
        """What is worth to know, such as that there is no ambient."""
        return [note for entry in self._plan.decided for note in entry.notes]

    def guesses(self) -> pd.DataFrame:
        """What was taken for what.

        Returns
        -------
        pandas.DataFrame
            Indexed by the log's ``column``: ``taken``, ``confidence`` (0..1) and ``why``.
        """
        import pandas as pd

        rows = [(g.subject, g.taken, g.confidence, g.why) for d in self._plan.decided for g in d.guesses]
        return pd.DataFrame(rows, columns=["column", "taken", "confidence", "why"]).set_index("column")

    def counted(self) -> pd.DataFrame:
        """What was found that is no sample, or left out.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``what``: ``file``, ``count`` and where ``first``.
        """
        import pandas as pd

        rows = [(c.what, m.table.label, c.count, c.first) for m in self._written.converted for c in m.counted]
        return pd.DataFrame(rows, columns=["what", "file", "count", "first"]).set_index("what")


def import_runs(
    files: Sequence[Path | str],
    out: Path | str,
    *,
    mapping: Path | str | None = None,
    time: str = "",
    input: str = "",
    full_scale: float | None = None,
    rest: float | None = None,
    drives: Literal["", "motor", "heater"] = "",
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    decimal: str = "",
    runs: str = "",
    duplicates: str = "",
    series: str = "",
    sort: bool = False,
    zone: str = "",
    sheet: str = "",
    split: bool = False,
    gap: float | None = None,
    overwrite: bool = False,
    seen: Callable[[Plan], None] = lambda _: None,
    progress: Callable[[str], None] = lambda _: None,
) -> Import:
    """Turn what a logger wrote into run files.

    Parameters
    ----------
    files
        CSV of any dialect, serial captures, JSON lines, Excel, Parquet, MATLAB.
    out
        The folder for the run files.
    mapping
        A mapping file (TOML): read if it exists, so that nothing is guessed, else written.
    time
        The time's column, two (date and time) with a comma between, or the rows' interval in s.
    input
        What drives the motor: a column, or whole counts that all rows have.
    full_scale
        The input's value that becomes 255 counts, in its own unit.
    rest
        The input's value that becomes 0 counts, in its own unit, where that is not 0: 4 of a signal of 4 to 20 mA.
    drives
        What the input drives: a ``motor``, which moves air, or a ``heater``, which does not; nothing: the run files do
        not say it.
    columns
        Name in the log -> name in the run file; empty to leave it out.
    units
        Name in the log or in the run file -> unit.
    decimal
        ``","`` or ``"."``.
    runs
        The column that says which run a row belongs to.
    duplicates
        Of rows with the same time: ``first``, ``last``, their ``mean``, or ``spread`` until the next time.
    series
        In a log with a row for each reading, the column of names, each of which becomes a column; behind a comma, the
        column of values.
    sort
        Whether rows are put in the order of their times, as of exports newest first.
    zone
        The time zone of local times (``Europe/Berlin``), across a beginning or an end of its summer time.
    sheet
        Of a workbook, the only sheet to read.
    split
        Whether gaps and a clock that begins anew part runs.
    gap
        From which interval on, s.
    overwrite
        Whether run files of the same names are replaced.
    seen
        Told what was decided before anything is refused or written.
    progress
        Told what is being done.

    Raises
    ------
    InputError
        With file and place: it cannot be read, something is doubtful (with what settles it), or cannot be written.

    Examples
    --------
    >>> import gen
    >>> found = gen.import_runs(["bench.csv"], "runs", units={"Temp": "degF"})  # doctest: +SKIP
    >>> found.guesses()  # doctest: +SKIP
    """
    one_of("decimal", decimal, ("", ",", "."))
    one_of("drives", drives, ("", "motor", "heater"))
    one_of("duplicates", duplicates, ("", "first", "last", "mean", "spread"))
    for name, number, least in (("full_scale", full_scale, 1e-9), ("rest", rest, -1e9), ("gap", gap, 1e-9)):
        if number is not None:
            within(name, number, least, 1e9)
    paths = [a_path("files", file) for file in several("files", files)]
    folder = a_path("out", out)
    if folder.exists() and not folder.is_dir():
        raise InputError("exists and is no folder; choose another --out", file=str(folder))
    file = None if mapping is None else a_path("mapping", mapping)
    for path in paths:
        if path.is_dir():
            raise InputError("this is a directory; expected a log", file=str(path))
        if not path.exists():
            raise InputError("there is no such file; expected a log", file=str(path))

    from gen.importing import Choices, Splitting, plan, write  # slow to import

    choices = Choices(
        time=time,
        drive=input,
        full_scale=full_scale,
        rest=rest,
        machine=drives,
        columns=columns or {},
        units=units or {},
        decimal=decimal,
        runs=runs,
        duplicates=duplicates,
        sort=sort,
        series=series,
        zone=zone,
        sheet=sheet,
    )
    planned = plan(paths, choices, file, progress)
    seen(planned)
    planned.check()
    written = write(
        planned, folder, splitting=Splitting(split, gap), mapping=file, overwrite=overwrite, progress=progress
    )
    return Import(planned, written)
