"""What run files and mapping files say of where they come from."""

from __future__ import annotations

from gen.importing.converted import Converted
from gen.importing.guessing.decide import Decided
from gen.importing.mapping import Mapping, mapping_text
from gen.runs.drive import COMMENT, MACHINE_COMMENT, Drive

_OWN = ("imported_from", "mapping", COMMENT, MACHINE_COMMENT, "counted")


def comments_of(made: Converted, mapping: Mapping) -> dict[str, str]:
    """What a run file says of where it comes from."""
    table = made.table
    comments = {"imported_from": table.file.name + (f", sheet {table.part}" if table.part else "")}
    time = mapping.time
    shown = [
        f"time_s <- {', '.join(time.columns)} ({time.unit})" if time.columns else f"time_s every {time.interval_s:g} s"
    ]
    for entry in mapping.column:
        if entry.to and entry.to != entry.source:
            shown.append(f"{entry.to} <- {entry.source}" + (f" ({entry.unit})" if entry.unit else ""))
    comments["mapping"] = "; ".join(shown)
    drive = mapping.input
    if drive.column:
        comments[COMMENT] = Drive(drive.column, drive.unit, drive.full_scale, drive.sign, drive.rest).text()
    else:
        comments[COMMENT] = f"{drive.counts} in all rows"
    if drive.drives:
        comments[MACHINE_COMMENT] = drive.drives
    for number, found in enumerate(made.counted, start=1):
        comments[f"counted_{number}"] = str(found)
    for key, value in table.comments.items():
        if not key.startswith(_OWN):
            comments.setdefault(key, value)
    return {_printable(key): _printable(value) for key, value in comments.items()}


def _printable(text: str) -> str:
    return "".join(c if c.isprintable() else " " for c in text)


def commented_mapping(decided: Decided) -> str:
    """Give the mapping file, with the reason of each guess beside it."""
    why: dict[str, str] = {}
    mapping = decided.mapping
    sections = {
        "encoding": "text",
        "delimiter": "text",
        "decimal mark": "text",
        ", ".join(mapping.time.columns): "time",
    }
    sections |= {mapping.input.column: "input", "input": "input"}
    for guess in decided.guesses:
        key = sections.get(guess.subject, guess.subject)
        said = (
            f"{guess.subject}: {guess.why} ({guess.confidence:.2f})"
            if key == "text"
            else (f"{guess.why} ({guess.confidence:.2f})")
        )
        why[key] = f"{why[key]}; {said}" if key in why else said
    return mapping_text(mapping, [table.file.name for table in decided.evidence.tables], why)
