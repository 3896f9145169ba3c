"""Print the study's tables beside what its own numbers give, and its schedules beside identified ones.

    python -m examples.my1016.study [--tables-only]

Run it in the folder of the checkout. ``--tables-only`` leaves out the comparison, which identifies a model first.
"""

from __future__ import annotations

import argparse

import pandas as pd

from examples.my1016.study.compare import Comparison, compare
from examples.my1016.study.disagreements import disagreements
from examples.my1016.study.reproduce import EXACT_K, Entry, reproduce
from examples.my1016.study.tables import STEADY_S, TRANSIENT_S, Study, averaged_model, read_study, variable_model

TITLES = {
    "4.4": "poles over speed (rad/s)",
    "4.5": "averaged-pole model",
    "4.6": "averaged-pole model minus measured at 10800 s (K, printed in whole degrees)",
    "4.8": "averaged-pole model minus measured at 2160 s (K, printed in whole degrees)",
    "4.11": "variable-pole model minus measured at 10800 s (K)",
    "4.13": "variable-pole model minus measured at 2160 s (K)",
    "4.1": "measured at 10800 s, beside the end of Table 4.3's curves (degC)",
}


def reproduction(study: Study, entries: list[Entry], disagreeing: list[str]) -> str:
    """Write all tables: printed, computed, difference."""
    lines = [f"{study.source}.", "Computed from the transfer functions of Table 4.3 and the two coefficient files.", ""]
    for table, title in TITLES.items():
        lines += [
            f"Table {table}: {title}",
            f"  {'component':10}{'what':24}{'printed':>12}{'computed':>12}{'difference':>12}",
        ]
        lines += [_row(entry) for entry in entries if entry.table == table]
        lines.append("")
    for model, tables, within in (
        ("Variable-pole", ("4.11", "4.13"), f"{EXACT_K} K"),
        ("Averaged-pole", ("4.6", "4.8"), "what rounding to whole degrees explains"),
    ):
        errors = [entry for entry in entries if entry.table in tables]
        near = [abs(entry.difference) for entry in errors if entry.agrees]
        lines.append(
            f"{model} errors: {len(near)} of {len(errors)} within {within} (largest difference {max(near):.2f} K)."
        )
    lines += ["", "Where the study's figures disagree with each other:"]
    return "\n".join([*lines, *(f"  {i}. {text}" for i, text in enumerate(disagreeing, start=1))])


def _row(entry: Entry) -> str:
    if entry.table in ("4.4", "4.5"):
        figures = f"{entry.computed:12.4g}{entry.difference / abs(entry.printed):+12.1%}"
    else:
        figures = f"{entry.computed:12.2f}{entry.difference:+12.2f}"
    mark = "" if entry.agrees else "  <- does not agree"
    return f"  {entry.component:10}{entry.what:24}{entry.printed:12g}{figures}{mark}"


def comparison(found: Comparison) -> str:
    """Write the comparison of the study's schedules with the identified ones."""
    lines = [
        "The same data, two general models: model minus the curves of Table 4.3 (K)",
        "The curves are read at 1 s with the sensor's 0.25 degC and given to gen identify as five run files.",
    ]
    for title, theirs, ours in (
        (f"at {STEADY_S} s", _at(found.study, STEADY_S), _at(found.ours, STEADY_S)),
        (f"at {TRANSIENT_S} s", _at(found.study, TRANSIENT_S), _at(found.ours, TRANSIENT_S)),
        ("steady rise at a speed that was left out", found.study_left_out, found.ours_left_out),
    ):
        table = pd.concat({"study": theirs.T, "gen identify": ours.T}).rename(columns="{} %".format)
        table["worst"] = table.abs().max(axis=1)
        worst = table["worst"].groupby(level=0).max()
        lines += ["", title, table.to_string(float_format="{:+.2f}".format)]
        lines.append(f"worst of all: study {worst['study']:.2f} K, gen identify {worst['gen identify']:.2f} K")
    lines += ["", "What gen identify chose:", *(f"  {name}: {forms}" for name, forms in found.forms.items())]
    return "\n".join(lines)


def _at(errors: pd.DataFrame, time: int) -> pd.DataFrame:
    return pd.DataFrame(errors.xs(time, axis=1, level=1))


def main() -> None:
    """Compute and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tables-only", action="store_true", help="leave out the comparison with gen identify")
    options = parser.parse_args()
    study, averaged, variable = read_study(), averaged_model(), variable_model()
    entries = reproduce(study, averaged, variable)
    print(reproduction(study, entries, disagreements(study, entries, variable)))
    if not options.tables_only:
        print("", comparison(compare(study, variable)), sep="\n")


if __name__ == "__main__":
    main()
