"""What was found, line by line and as tables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from statistics import median

#: A build may take so long, in seconds of processor time.
LONGEST_BUILD_S = 10.0


@dataclass(frozen=True)
class Attacked:
    """One component in one form.

    Attributes
    ----------
    file, component, order, form
        Which.
    bound_K, found_K
        Proven, and found in exact arithmetic; the bound is None where nothing is proven.
    allowed
        Whether the file asks for a component without a proof.
    start_mK, samples
        The worst run's start and its length.
    """

    file: str
    component: str
    order: int
    form: str
    bound_K: float | None
    found_K: float
    allowed: bool
    start_mK: int
    samples: int

    @property
    def ratio(self) -> float | None:
        """Found over bound."""
        return None if self.bound_K is None else self.found_K / self.bound_K

    @property
    def broken(self) -> bool:
        """Whether a bound does not hold, or is missing unasked."""
        return not self.allowed if self.ratio is None else not self.ratio <= 1.0

    def line(self) -> str:
        """For people."""
        where = f"{self.file} {self.component} (order {self.order}) {self.form}"
        ran = f"start {self.start_mK} mK, {self.samples} samples"
        if self.ratio is None:
            return f"{where}: no bound, found {self.found_K:.2e} K  [{ran}]{'' if self.allowed else '  NO PROOF'}"
        share = f"{self.found_K:.2e} K of {self.bound_K:.2e} K = {self.ratio:.3f}"
        return f"{where}: {share}  [{ran}]{'  BROKEN' if self.broken else ''}"


@dataclass(frozen=True)
class Refused:
    """A file that was refused in one form; ``wrong`` says what is wrong with how, if anything."""

    file: str
    form: str
    message: str
    wrong: str = ""


@dataclass(frozen=True)
class Timed:
    """How long a build took, in seconds of processor time; ``crash`` is the traceback that ended it, if one did."""

    file: str
    form: str
    seconds: float
    crash: str = ""


@dataclass
class Report:
    """Everything that came of a campaign."""

    attacked: list[Attacked]
    refused: list[Refused]
    timed: list[Timed]

    @classmethod
    def empty(cls) -> Report:
        """Before anything was attacked."""
        return cls([], [], [])

    def faults(self) -> list[str]:
        """A line for each thing that must not be."""
        found = [entry.line() for entry in self.attacked if entry.broken]
        found += [f"{r.file} {r.form}: refused, but {r.wrong}: {r.message}" for r in self.refused if r.wrong]
        found += [f"{t.file} {t.form}: {t.crash.strip().splitlines()[-1]}" for t in self.timed if t.crash]
        found += [f"{t.file} {t.form}: {t.seconds:.1f} s to build" for t in self.timed if t.seconds > LONGEST_BUILD_S]
        return found

    def summary(self) -> str:
        """Counts, and found/bound by order and arithmetic, as a table in Markdown."""
        slowest = max((t.seconds for t in self.timed), default=0.0)
        files = {t.file for t in self.timed}
        lines = [
            f"{len(files)} files, {len(self.timed)} builds, {len(self.refused)} of them refused, "
            f"{len(self.attacked)} components attacked; the longest build took {slowest:.1f} s.",
            "",
            "| order | arithmetic | components | largest found/bound | median |",
            "|---|---|---|---|---|",
        ]
        for order, arithmetic, ratios in self._groups():
            lines.append(f"| {order} | {arithmetic} | {len(ratios)} | {max(ratios):.3f} | {median(ratios):.3f} |")
        return "\n".join(lines)

    def table(self) -> str:
        """Found/bound of each component (rows) in each form (columns), as a table in Markdown."""
        forms = sorted({entry.form for entry in self.attacked})
        lines = [f"| file | component | order | {' | '.join(forms)} |", "|---|---|---|" + "---|" * len(forms)]
        for key, entries in _grouped(self.attacked):
            cells = [_cell(entries, form) for form in forms]
            lines.append(f"| {' | '.join(key)} | {' | '.join(cells)} |")
        return "\n".join(lines)

    def _groups(self) -> Iterable[tuple[int, str, list[float]]]:
        for order in sorted({entry.order for entry in self.attacked}):
            for arithmetic in ("fixed", "float"):
                ratios = [
                    entry.ratio
                    for entry in self.attacked
                    if entry.order == order and entry.form.startswith(arithmetic) and entry.ratio is not None
                ]
                if ratios:
                    yield order, arithmetic, ratios


def _grouped(attacked: Sequence[Attacked]) -> list[tuple[tuple[str, str, str], list[Attacked]]]:
    groups: dict[tuple[str, str, str], list[Attacked]] = {}
    for entry in attacked:
        groups.setdefault((entry.file, entry.component, str(entry.order)), []).append(entry)
    return list(groups.items())


def _cell(entries: Sequence[Attacked], form: str) -> str:
    for entry in entries:
        if entry.form == form:
            return "no proof" if entry.ratio is None else f"{entry.ratio:.3f}"
    return "refused"
