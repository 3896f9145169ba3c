"""Lists within messages, which are of one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from gen.errors import InputError
from gen.importing.listing import listed
from tests.importing.logs import take, write

ROWS = 30


def test_a_short_list_is_said_in_full_and_a_long_one_by_its_beginning() -> None:
    names = [f"c{i}" for i in range(49)]
    assert listed(names[:12]) == ", ".join(names[:12])
    assert listed(names) == ", ".join(names[:12]) + " and 37 more"
    assert listed(names, " | ").endswith("c11 | and 37 more")


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"time": "nothing"},
        {"input": "nothing", "time": "1"},
        {"input": "1", "time": "1", "columns": {"nothing": "x"}},
        {"input": "1", "time": "1", "units": {"nothing": "degC"}},
        {"input": "1", "time": "1", "runs": "nothing"},
        {"series": "nothing"},
        {"input": "1", "time": "1"},
        {"time": "1"},
    ],
)
def test_a_message_about_a_wide_log_stays_short(options: dict[str, object], tmp_path: Path) -> None:
    heads = ",".join(f"rotor quux {chr(97 + i // 26)}{chr(97 + i % 26)}" for i in range(300))
    rows = "\n".join(",".join(f"{20 + (k * i) % 17:.1f}" for i in range(300)) for k in range(ROWS))
    with pytest.raises(InputError, match=r"and \d{3} more") as found:
        take(write(tmp_path, f"{heads}\n{rows}"), tmp_path / "out", **options)
    assert len(str(found.value)) < 4000
