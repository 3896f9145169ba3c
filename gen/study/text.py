"""What `gen study` prints."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.study.compare import Comparison
from gen.study.disagreements import disagreements
from gen.study.reproduce import EXACT_K, Entry, reproduce
from gen.study.tables import STEADY_S, TRANSIENT_S, FloatArray, Study

_TITLES = {
    "4.4": "Table 4.4: poles over speed (rad/s)",
    "4.5": "Table 4.5: averaged-pole model",
    "4.6": "Table 4.6: averaged-pole model minus measured at 10800 s (K, printed in whole degrees)",
    "4.8": "Table 4.8: averaged-pole model minus measured at 2160 s (K, printed in whole degrees)",
    "4.11": "Table 4.11: variable-pole model minus measured at 10800 s (K)",
    "4.13": "Table 4.13: variable-pole model minus measured at 2160 s (K)",
    "4.1": "Table 4.1: measured at 10800 s, beside the end of Table 4.3's curves (degC)",
}


def reproduction(study: Study) -> str:
    """Write all tables: printed, computed, difference."""
    entries = reproduce(study)
    lines = [
        f"{study.source}.",
        "Computed from the transfer functions of Table 4.3 and the schedules of Table 4.10.",
        "",
    ]
    for table, title in _TITLES.items():
        lines += [
            title,
            *table_lines(("component", "what", "printed", "computed", "difference"), _rows(entries, table)),
        ]
        lines.append("")
    errors = [e for e in entries if e.table in ("4.11", "4.13")]
    within = [e for e in errors if e.agrees]
    lines.append(
        f"Variable-pole errors: {len(within)} of {len(errors)} within {EXACT_K} K "
        f"(largest difference among them {max(abs(e.difference) for e in within):.2f} K)."
    )
    rounded = [e for e in entries if e.table in ("4.6", "4.8")]
    near = [e for e in rounded if e.agrees]
    lines.append(
        f"Averaged-pole errors: {len(near)} of {len(rounded)} within {max(abs(e.difference) for e in near):.1f} K "
        "(printed in whole degrees)."
    )
    lines += ["", "Where the study's figures disagree with each other:"]
    lines += [f"  {i}. {text}" for i, text in enumerate(disagreements(study, entries), start=1)]
    return "\n".join(lines)


def _rows(entries: list[Entry], table: str) -> Iterator[tuple[str, ...]]:
    for entry in entries:
        if entry.table == table:
            kelvin = table in ("4.1", "4.6", "4.8", "4.11", "4.13")
            shown = f"{entry.computed:.2f}" if kelvin else f"{entry.computed:.4g}"
            gap = f"{entry.difference:+.2f}" if kelvin else f"{entry.difference / abs(entry.printed):+.1%}"
            mark = "" if entry.agrees else f"  <- {entry.note}"
            yield entry.component, entry.what, f"{entry.printed:g}", shown, gap + mark


def table_lines(heads: Sequence[str], rows: Iterator[tuple[str, ...]] | list[tuple[str, ...]]) -> list[str]:
    """Set a table in columns: words to the left, numbers to the right, the last column free."""
    body = list(rows)
    widths = [max(len(row[i]) for row in [tuple(heads), *body]) for i in range(len(heads))]
    widths[-1] = max(len(heads[-1]), *(len(row[-1].split("  ")[0]) for row in body))

    def line(row: Sequence[str]) -> str:
        cells = []
        for i, (cell, width) in enumerate(zip(row, widths, strict=True)):
            cells.append(cell.ljust(width) if i < 2 else cell.rjust(width) if "  " not in cell else _free(cell, width))
        return ("  " + "  ".join(cells)).rstrip()

    return [line(heads), *(line(row) for row in body)]


def _free(cell: str, width: int) -> str:
    number, _, rest = cell.partition("  ")
    return f"{number.rjust(width)}  {rest}"


def comparison(study: Study, found: Comparison) -> str:
    """Write the comparison of the study's schedules with those that `gen identify` chooses."""
    lines = [
        "The same data, two general models: model minus the curves of Table 4.3 (K)",
        "The curves are read at 1 s with the sensor's 0.25 degC and given to gen identify as five run files.",
    ]
    heads = ("component", "schedules", *(f"{speed} %" for speed in study.speeds), "worst")
    for title, ours, theirs in (
        (f"at {STEADY_S} s", _at(found.ours, STEADY_S), _at(found.study, STEADY_S)),
        (f"at {TRANSIENT_S} s", _at(found.ours, TRANSIENT_S), _at(found.study, TRANSIENT_S)),
        ("steady rise at a speed that was left out", found.ours_left_out, found.study_left_out),
    ):
        rows = []
        for name in study.components:
            for whose, errors in (("study", theirs[name]), ("gen identify", ours[name])):
                cells = (f"{e:+.2f}" for e in errors)
                rows.append((name, whose, *cells, f"{np.max(np.abs(errors)):.2f}"))
        lines += ["", title, *table_lines(heads, rows)]
        worst = [max(float(np.max(np.abs(e))) for e in errors.values()) for errors in (theirs, ours)]
        lines.append(f"  worst of all: study {worst[0]:.2f} K, gen identify {worst[1]:.2f} K")
    lines += ["", "What gen identify chose:"]
    lines += [f"  {name}: {forms}" for name, forms in found.forms.items()]
    return "\n".join(lines)


def _at(errors: dict[str, dict[int, FloatArray]], time: int) -> dict[str, FloatArray]:
    return {name: by_time[time] for name, by_time in errors.items()}
