"""The mapping file: how a logger's columns become a run file's, so that a second import guesses nothing."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping as Dict
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from gen.arrays import FloatArray
from gen.errors import InputError
from gen.importing.local import is_zone
from gen.importing.units import unit_of
from gen.runs.drive import FULL_COUNTS, Machine
from gen.version import __version__

DATED = ("timestamp", "date and time")
TIME_KINDS = (*DATED, "time of day", "mm:ss")


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True, strict=True)


class TextForm(_Part):
    """How a file is taken; empty fields are guessed, and typed files need none."""

    encoding: str = ""
    delimiter: str = ""
    decimal: Literal["", ".", ","] = ""
    sheet: str = ""


class TimeForm(_Part):
    """Where the time is: columns and a unit, or the rows' interval."""

    columns: list[str] = []
    unit: str = "s"
    order: Literal["ymd", "dmy", "mdy"] = "ymd"
    zone: str = ""
    interval_s: Annotated[float, Field(gt=0, allow_inf_nan=False)] | None = None

    @model_validator(mode="after")
    def _one_of_them(self) -> TimeForm:
        if bool(self.columns) == (self.interval_s is not None) or len(self.columns) > 2:
            raise ValueError("expected either columns (one, or date and time) or interval_s")
        unit = unit_of(self.unit)
        if self.unit not in TIME_KINDS and (unit is None or unit.quantity != "time"):
            raise ValueError(f'found the unit "{self.unit}", expected s, ms, us, min, h, d or {", ".join(TIME_KINDS)}')
        if self.zone and self.unit not in DATED:
            raise ValueError(f"found the zone {self.zone} of a {self.unit}, expected one of dates with times only")
        if self.zone and not is_zone(self.zone):
            raise ValueError(f'found the zone "{self.zone}", expected one such as Europe/Berlin')
        return self


class InputForm(_Part):
    """What becomes ``pwm``: a column and its full scale, or the same counts in every row; and what that drives."""

    column: str = ""
    unit: str = "counts"
    full_scale: Annotated[float, Field(gt=0, allow_inf_nan=False)] = 255.0
    rest: Annotated[float, Field(allow_inf_nan=False)] = 0.0
    sign: str = ""
    backwards: Annotated[float, Field(allow_inf_nan=False)] | None = None
    drives: Machine | Literal[""] = ""
    counts: Annotated[int, Field(ge=-255, le=255)] | None = None

    @model_validator(mode="after")
    def _one_of_them(self) -> InputForm:
        if bool(self.column) == (self.counts is not None):
            raise ValueError("expected either a column or counts")
        if self.rest >= self.full_scale:
            raise ValueError(f"found a rest of {self.rest:g}, expected less than the full scale of {self.full_scale:g}")
        return self

    def counts_of(self, values: FloatArray) -> FloatArray:
        """Counts that values of the column are, any shape; not rounded."""
        return (values - self.rest) / (self.full_scale - self.rest) * FULL_COUNTS

    @property
    def said(self) -> str:
        """The scale in words."""
        if self.rest:
            return f"{self.rest:g} to {self.full_scale:g} {self.unit} = 0 to {FULL_COUNTS}"
        return f"{self.full_scale:g} {self.unit} = {FULL_COUNTS}"


class Entry(_Part):
    """One column; `to` is empty for one that is left out."""

    source: str = Field(alias="from")
    to: str = ""
    unit: str = ""


class Mapping(_Part):
    """All that turns one logger's tables into run files."""

    version: Literal[1] = 1
    text: TextForm = TextForm()
    time: TimeForm
    input: InputForm
    runs: str = ""
    overflow: Literal["empty", "keep"] = "empty"
    duplicates: Literal["", "first", "last", "mean", "spread"] = ""
    sort: bool = False
    series: str = ""
    column: list[Entry] = []

    @property
    def used(self) -> set[str]:
        """Columns of the log that have a place of their own."""
        return {*self.time.columns, self.input.column, self.input.sign, self.runs} - {""}

    def entry(self, name: str) -> Entry | None:
        """What becomes of a column; None where nothing is said."""
        return next((entry for entry in self.column if entry.source == name), None)


def read_mapping(path: Path) -> Mapping:
    """Read a mapping file.

    Raises
    ------
    InputError
        With file and place.
    """
    try:
        tree = tomllib.loads(path.read_text(encoding="utf-8-sig"))
        return Mapping.model_validate(tree)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"is not TOML: {error}", file=str(path)) from None
    except UnicodeDecodeError as error:
        raise InputError(f"is not UTF-8: {error.reason} at byte {error.start}", file=str(path)) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", file=str(path)) from None
    except ValidationError as error:
        first = error.errors()[0]
        place = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in first["loc"]).lstrip(".")
        found = "" if first["type"] == "missing" else f", found {json.dumps(first['input'], default=str)[:60]}"
        raise InputError(f"{first['msg']}{found}", file=str(path), place=place or "top level") from None


def mapping_text(mapping: Mapping, files: Sequence[str], why: Dict[str, str]) -> str:
    """A mapping file's text, with what was guessed in its comments.

    Parameters
    ----------
    mapping
        What to write.
    files
        Names of the files that it was made of.
    why
        By the column of the log, or ``text``, ``time``, ``input``: a line.
    """
    import tomlkit

    document = tomlkit.document()
    document.add(tomlkit.comment(f"Written by gen {__version__} for {', '.join(files)}."[:200]))
    document.add(tomlkit.comment("Correct it where it is wrong: with --mapping it is read, and nothing is guessed."))
    document.add("version", tomlkit.item(mapping.version))
    document.add("overflow", _explained(mapping.overflow, '"keep": values that a sensor gives when it fails stay'))
    document.add("duplicates", _explained(mapping.duplicates, '"first", "last", "mean" or "spread": rows of one time'))
    document.add("sort", _explained(mapping.sort, "true: rows are put in the order of their times"))
    document.add(
        "series", _explained(mapping.series, "the column of names that each become a column, and that of values")
    )
    document.add("runs", _explained(mapping.runs, "the column that says which run a row belongs to"))
    for name, part in (("text", mapping.text), ("time", mapping.time), ("input", mapping.input)):
        table = tomlkit.table()
        if why.get(name):
            table.add(tomlkit.comment(_one_line(why[name])))
        for key, value in part.model_dump(exclude_none=True).items():
            if name != "time" or key != "interval_s" or value is not None:
                table.add(key, tomlkit.item(value))
        document.add(name, table)
    entries = tomlkit.aot()
    for entry in mapping.column:
        table = tomlkit.table()
        if why.get(entry.source):
            table.add(tomlkit.comment(_one_line(why[entry.source])))
        for key, value in entry.model_dump(by_alias=True).items():
            table.add(key, tomlkit.item(value))
        entries.append(table)
    if mapping.column:
        document.add("column", entries)
    return tomlkit.dumps(document)


def _explained(value: str | bool, comment: str) -> object:
    import tomlkit

    return tomlkit.item(value).comment(comment)


def _one_line(text: str) -> str:
    return "".join(c if c.isprintable() else " " for c in text)
