"""What PWM is commanded when: ``0:153,3600:0``, or a CSV with the columns ``time_s`` and ``pwm``."""

from __future__ import annotations

import re
from pathlib import Path

from gen.errors import InputError
from gen.runs import EXPECTS, read_run

_FULL = 255
_PAIR = re.compile(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*:\s*(-?\d+)\s*", re.ASCII)

Profile = tuple[tuple[float, int], ...]
"""(time in s, PWM -255..255), times strictly increasing; each PWM acts until the next time."""


def parse_profile(text: str) -> Profile:
    """Read a profile from an option's text, or from the file that it names.

    Raises
    ------
    InputError
        When it is neither.
    """
    if re.fullmatch(r"[-\d.:,\s]+", text):
        return _parse_pairs(text)
    path = Path(text)
    if not path.is_file():
        raise InputError(
            f'found "{text}", expected pairs such as 0:153,3600:0 (time in s : PWM) or a CSV file with time_s and pwm',
            place="--profile",
        )
    run = read_run(path)
    return tuple(zip(run.time_s.tolist(), run.pwm.tolist(), strict=True))


def carried_comments(text: str | None) -> list[str]:
    """Give the comment lines of a profile's file that belong into a run that follows it: what it is to decide.

    Parameters
    ----------
    text
        What :func:`parse_profile` has read, or None for no profile.
    """
    if text is None or re.fullmatch(r"[-\d.:,\s]+", text):
        return []
    said = read_run(Path(text)).comments.get(EXPECTS)
    return [] if said is None else [f"# {EXPECTS}: {said}"]


def _parse_pairs(text: str) -> Profile:
    steps: list[tuple[float, int]] = []
    for pair in text.split(","):
        match = _PAIR.fullmatch(pair)
        if match is None:
            raise InputError(f'found "{pair}", expected time in s : PWM, such as 3600:153', place="--profile")
        time_s, pwm = float(match[1]), int(match[2])
        if abs(pwm) > _FULL:
            raise InputError(f"found PWM {pwm}, expected -{_FULL}..{_FULL}", place="--profile")
        if steps and time_s <= steps[-1][0]:
            raise InputError(
                f"found {time_s:g} s after {steps[-1][0]:g} s, expected times that grow", place="--profile"
            )
        steps.append((time_s, pwm))
    return tuple(steps)
