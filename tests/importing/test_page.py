"""docs/import.md shows what the commands print and write."""

from __future__ import annotations

import re
from pathlib import Path

from tests.command import gen
from tests.examples import ROOT

PAGE = (ROOT / "docs" / "import.md").read_text(encoding="utf-8")


def blocks(kind: str) -> list[str]:
    return re.findall(rf"^```{kind}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def shown(text: str) -> str:
    return "\n".join(line.rstrip() for line in text.rstrip().splitlines())


def steps() -> list[tuple[str, str]]:
    """Every command of the page with what it is said to print."""
    return [
        (command, shown(output))
        for block in blocks("console")
        for command, output in re.findall(r"^\$ gen (.+)\n((?:(?!\$ ).*\n)*)", block, re.MULTILINE)
    ]


def test_the_page_s_commands_print_and_write_what_it_shows(tmp_path: Path) -> None:
    log, run = blocks("text")
    (tmp_path / "bench.csv").write_bytes(log.encode("cp1252"))
    rows = "".join(f"{i * 5},{80 if i < 20 else 0},{22 + i / 4}\n" for i in range(40))
    (tmp_path / "doubtful.csv").write_text(f"t [s],PWM,Winding [degC]\n{rows}")
    assert len(steps()) == 3
    for command, output in steps():
        done = gen(*command.split(), cwd=tmp_path)
        assert shown(done.stdout + done.stderr) == output
    assert (tmp_path / "runs" / "bench.csv").read_text(encoding="utf-8") == run
    assert blocks("toml")[0] in (tmp_path / "bench.toml").read_text(encoding="utf-8")


def test_the_page_names_every_option() -> None:
    options = re.findall(r"--[a-z-]+", gen("import", "--help").stdout)
    assert {"--out", "--mapping", "--input", "--unit"} <= set(options)
    assert not [
        name
        for name in set(options) - {"--help", "--overwrite", "--decimal"}
        if f"`{name}" not in PAGE.replace("--out runs --mapping", "`--out` `--mapping")
    ]
