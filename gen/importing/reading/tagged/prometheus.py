"""What Prometheus scrapes, and what its API answers, to tagged records: samples of metrics, told apart by labels."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence

from gen.importing.clock import is_time
from gen.importing.reading.lines import Lines
from gen.importing.reading.tagged.tagged_records import Record, differing_tags

_LABEL = r'[A-Za-z_]\w*="(?:[^"\\]|\\.)*"'
_SAMPLE = re.compile(
    rf"(?P<metric>[A-Za-z_:][\w:]*)(?P<labels>\{{(?:{_LABEL},?\s*)*\}})?\s+"
    r"(?P<sample>[+-]?\d*\.?\d+(?:[eE][+-]?\d+)?|NaN|[+-]?Inf)(?:\s+(?P<when>\d+(?:\.\d+)?))?\s*(?:#.*)?"
)
_QUERY = re.compile(rf"(?P<metric>[A-Za-z_:][\w:]*)?(?P<labels>\{{(?:{_LABEL},?\s*)+\}})")
_PAIR = re.compile(r'([A-Za-z_]\w*)="((?:[^"\\]|\\.)*)"')
_SAYS_SO = re.compile(r"(?:HELP|TYPE|UNIT) [A-Za-z_:][\w:]*(?: |$)")
_EPOCH = re.compile(r"\d{10}(?:\.\d+)?|\d{13}")
_MILLIS = 1e11
"""From which number on a time since 1970 is in ms: as the text form has it, OpenMetrics has s."""
_LEAST = 0.8
_FIRST = 400
"""Lines that are looked at."""
UNTIMED = "put the time of each scrape before it: (date +%s; curl -s URL) >> log"
"""How to record with times."""


def is_scraped(lines: Lines) -> bool:
    """Whether lines are samples of metrics: by labels, or by the comments that tell a metric's type.

    Parameters
    ----------
    lines
        Of a text.
    """
    first = lines.texts[:_FIRST]
    found = [_SAMPLE.fullmatch(line.strip()) for line in first]
    matched = [match for match in found if match]
    if not matched or len(matched) < _LEAST * sum(1 for text in first if not _is_time(text)):
        return False
    return any(match["labels"] for match in matched) or any(map(_SAYS_SO.match, lines.comments))


def scraped(lines: Lines) -> tuple[list[Record], list[int], list[int]]:
    """Records of samples; a line that is nothing but a time is that of the samples behind it.

    Returns
    -------
    records, places, bad
        And the numbers of lines that are none.
    """
    records, places, bad = [], [], []
    before = ""
    for text, number in zip(lines.texts, lines.numbers, strict=True):
        match = _SAMPLE.fullmatch(text.strip())
        if match is None:
            before = text.strip() if _is_time(text) else before
            bad += [] if _is_time(text) else [number]
            continue
        at = float(match["when"]) / (1e3 if float(match["when"]) > _MILLIS else 1.0) if match["when"] else before
        records.append(_record(match["metric"], dict(_PAIR.findall(match["labels"] or "")), match["sample"], at))
        places.append(number)
    return _named(records), places, bad


def answered(tree: object) -> list[Record] | None:
    """Records of an answer of the API, in the order of their times; None of what is none.

    Parameters
    ----------
    tree
        A JSON text: ``{"data": {"resultType": "matrix", "result": [..]}}``.
    """
    data = tree.get("data") if isinstance(tree, dict) else None
    result = data.get("result") if isinstance(data, dict) and data.get("resultType") in ("matrix", "vector") else None
    if not isinstance(result, list):
        return None
    records: list[tuple[float, Record]] = []
    for series in result:
        labels = series.get("metric") if isinstance(series, dict) else None
        samples = (series.get("values") or [series.get("value")]) if isinstance(series, dict) else None
        if not isinstance(labels, dict) or not isinstance(samples, list):
            return None
        tags = {key: str(value) for key, value in labels.items() if key != "__name__"}
        for sample in samples:
            if not isinstance(sample, list) or len(sample) != 2 or not isinstance(sample[0], (int, float)):
                return None
            name = str(labels.get("__name__", "value"))
            records.append((float(sample[0]), _record(name, tags, str(sample[1]), sample[0])))
    records.sort(key=lambda entry: entry[0])  # series by series
    return _named([record for _, record in records])


def without_labels(names: Sequence[str]) -> list[str]:
    """Names of columns with what their labels tell apart before them, as panels export queries.

    Parameters
    ----------
    names
        ``motor_temperature{sensor="winding"}`` among others.
    """
    found = {name: match for name in names if (match := _QUERY.fullmatch(name))}
    tags = {name: dict(_PAIR.findall(match["labels"])) for name, match in found.items()}
    records = [_record(match["metric"] or "value", tags[name], "", "") for name, match in found.items()]
    told = differing_tags(list(tags.values()))
    made = {
        name: ".".join([*(tags[name][key] for key in told if key in tags[name]), *_of(record, "fields")])
        for name, record in zip(found, _named(records), strict=True)
    }
    return [made.get(name, name) for name in names]


def _is_time(text: str) -> bool:
    return bool(_EPOCH.fullmatch(text.strip())) or is_time(text)


def _record(name: str, tags: Mapping[str, str], value: str, at: object) -> dict[str, object]:
    return {"fields": {name: value}, "tags": tags} | ({"time": at} if at != "" else {})


def _named(records: Sequence[Record]) -> list[Record]:
    """Metrics without the first word of their names, which says whose they are, where labels say of what they are.

    ``motor_temperature_celsius{sensor="winding"}`` becomes ``temperature_celsius`` of ``winding``.
    """
    told = differing_tags([tags for record in records if isinstance(tags := record["tags"], dict)])

    def short(record: Record) -> tuple[str, str, str]:
        name, tags = next(iter(_of(record, "fields"))), _of(record, "tags")
        said = ".".join(str(tags[key]) for key in told if key in tags)
        tail = name.partition("_")[2]
        return name, said, tail if said and tail else name

    shorts = [short(record) for record in records]
    whose = Counter((said, tail) for name, said, tail in set(shorts))
    return [
        {**record, "fields": {tail if whose[said, tail] == 1 else name: next(iter(_of(record, "fields").values()))}}
        for record, (name, said, tail) in zip(records, shorts, strict=True)
    ]


def _of(record: Record, key: str) -> Mapping[str, object]:
    found = record[key]
    assert isinstance(found, dict)
    return found
