"""Blocks of NULs, as a memory card holds them where power was cut."""

from __future__ import annotations

import tarfile
from pathlib import Path

import pytest

from gen.errors import InputError
from gen.runs import read_run
from tests.importing.logs import TRUE, csv, same, take, write

NULS = bytes(512)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_a_block_of_nuls_is_taken_out_with_the_row_that_it_tears(encoding: str, end: str, tmp_path: Path) -> None:
    """As a card holds it where power was cut: what stood there is lost, and its two halves are of two rows."""
    text = csv().replace("\n", end)
    at = text.index(f"{end}30.0,204") + 9
    log = tmp_path / "log.csv"
    log.write_bytes(f"{text[:at]}{NULS.decode()}{text[at + 1 :]}".encode(encoding))
    found = take(log, tmp_path / "out")
    same(read_run(found.runs[0]), TRUE.drop(index=60))
    said = found.counted()
    assert said["count"]["line torn by a block of NULs, left out"] == 1
    assert said["first"]["line torn by a block of NULs, left out"] == "line 62"


def test_blocks_of_nuls_at_both_ends_tear_no_row(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_bytes(NULS + csv().encode() + NULS * 8)
    found = take(log, tmp_path / "out")
    same(read_run(found.runs[0]), TRUE)
    assert found.counted()["count"].tolist() == [2]


def test_what_is_mostly_torn_by_nuls_is_no_text(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_bytes(b"".join(line.encode() + NULS for line in csv().splitlines()))
    with pytest.raises(InputError, match="is neither text nor a format that is known"):
        take(log, tmp_path / "out")


def test_a_tar_archive_is_told_what_it_is(tmp_path: Path) -> None:
    write(tmp_path, csv())
    with tarfile.open(tmp_path / "log.tar", "w") as archive:
        archive.add(tmp_path / "log.csv")
    with pytest.raises(InputError, match="is a tar archive; unpack it"):
        take(tmp_path / "log.tar", tmp_path / "out")
