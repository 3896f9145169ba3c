"""Bytes to text, whatever wrote them."""

from __future__ import annotations

import codecs
import re

from gen.errors import InputError
from gen.importing.reading.torn import without_blocks

_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_SAMPLE = 1 << 16
_DEGREES = re.compile(r"[°º]\s?[CFK]|℃|℉|µs|[A-Za-zÄÖÜäöü]*[ÄÖÜäöüß][a-zäöüß]+")
_SINGLE_BYTE = ("cp1252", "cp437", "mac_roman")
_RUNS = re.compile("[\u3000-\u30ff\u4e00-\u9fff\uff01-\uff5e\u2103\u00b0\u00b1\u03a9\u25a0-\u25ff\u2010-\u203b]+")
"""Kana, Chinese characters, and what stands beside them: wide letters, marks, degrees."""
_CELSIUS = re.compile("\u2103|\u00b0[CFK]")
_JAPANESE = 0.95
_ZEROS = 0.01
"""Share of a text's characters up to which zeros are noise."""
_FIRST, _HEAD = 5, 60
"""Lines that a header may be among: without a preamble, and with one."""
_DAMAGED = 0.05
"""Of the lines: a serial line's bit errors hit fewer, another encoding's letters stand in the header or in all rows."""


def decode(data: bytes, given: str = "") -> tuple[str, str, str]:
    """Decode a file.

    Parameters
    ----------
    data
        All of it.
    given
        The encoding, where it is known.

    Returns
    -------
    text, encoding, why
        Why is empty where it was given.

    Raises
    ------
    InputError
        Without a file name: where it is no text, or not in the encoding given.
    """
    if given:
        try:
            return data.decode(given), given, ""
        except LookupError:
            raise InputError(f'found the encoding "{given}", expected one that Python knows') from None
        except UnicodeDecodeError as error:
            line = data.count(b"\n", 0, error.start) + 1
            if given.replace("-", "") in ("utf8", "utf8sig"):
                return data.decode(given, "replace"), given, ""
            raise InputError(f"byte 0x{data[error.start]:02x} is not {given}", place=f"line {line}") from None
    text, encoding, why = _guessed(data)
    _check_text(without_blocks(text)[0])
    return text, encoding, why


def _guessed(data: bytes) -> tuple[str, str, str]:
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            return data.decode(encoding, "replace"), encoding, "a byte-order mark"
    wide = _without_mark(data[:_SAMPLE])
    if wide:
        return data.decode(wide, "replace"), wide, "every other byte is 0"
    try:
        return data.decode("utf-8"), "utf-8", "all of it is UTF-8"
    except UnicodeDecodeError:
        pass
    replaced = data.decode("utf-8", "replace")
    lines = replaced.split("\n")
    damaged = [number for number, line in enumerate(lines) if "\ufffd" in line]
    noise = damaged[0] > _HEAD or (damaged[0] > _FIRST and not _has_words(data.split(b"\n")[damaged[0]]))
    if noise and len(damaged) <= max(1, _DAMAGED * len(lines)):
        return replaced, "utf-8", f"{len(damaged)} line(s) hold other bytes, as noise on a serial line does"
    return _single_byte(data)


def _has_words(line: bytes) -> bool:
    """Whether a line holds degrees or an accented word in some encoding: a header's, or a row's of units."""
    return bool(_japanese(line)) or any(_DEGREES.search(line.decode(name, "replace")) for name in _SINGLE_BYTE)


def _without_mark(sample: bytes) -> str:
    """UTF-16 without its mark: ASCII with a zero in every other byte."""
    half = len(sample) // 2
    if half < 2:
        return ""
    if sample[1::2].count(0) > 0.9 * half and sample[0::2].count(0) < 0.1 * half:
        return "utf-16-le"
    if sample[0::2].count(0) > 0.9 * half and sample[1::2].count(0) < 0.1 * half:
        return "utf-16-be"
    return ""


def _japanese(sample: bytes) -> str:
    """A word in Shift-JIS; empty where the bytes are no such text.

    Its bytes are some text in any encoding of single bytes. In Western ones letters beyond ASCII stand alone, so that
    they would make lone characters here, and rare ones.
    """
    try:
        text = sample.decode("cp932")
    except UnicodeDecodeError as error:
        if error.start < len(sample) - 1:  # but for a character that the sample cuts
            return ""
        text = sample[: error.start].decode("cp932")
    beyond = [c for c in text if ord(c) > 127]
    runs = _RUNS.findall(text)
    if not beyond or sum(map(len, runs)) < _JAPANESE * len(beyond):
        return ""
    return max(runs, key=len) if _CELSIUS.search(text) or 2 * len(runs) <= sum(map(len, runs)) else ""


def _single_byte(data: bytes) -> tuple[str, str, str]:
    sample = data[:_SAMPLE]
    word = _japanese(sample)
    if word:
        return data.decode("cp932", "replace"), "cp932", f'with it a word is "{word}"'
    for encoding in _SINGLE_BYTE:
        found = _DEGREES.search(sample.decode(encoding, "replace"))
        if found:
            return data.decode(encoding, "replace"), encoding, f'with it a word is "{found[0]}"'
    from charset_normalizer import from_bytes

    best = from_bytes(sample).best()
    encoding = best.encoding if best is not None and best.chaos < 0.1 else "cp1252"
    return data.decode(encoding, "replace"), encoding, "it is no UTF-8; by charset-normalizer"


def _check_text(text: str) -> None:
    sample = text[:_SAMPLE]
    strange = sum(1 for c in sample if (ord(c) < 32 and c not in "\t\r\n\f\x1b") or c == "\ufffd")
    # A board that is reset sends a few zeros.
    if sample.count("\0") > _ZEROS * len(sample) or strange > 0.1 * len(sample):
        raise InputError(
            "is neither text nor a format that is known by its first bytes; expected CSV, JSON lines, a serial "
            "capture, Excel (.xlsx), Parquet or MATLAB (.mat)"
        )
