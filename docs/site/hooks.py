"""What turns README.md and docs/ into the site that mkdocs.yml describes.

* README.md is the home page.
* Links are written as the repository needs them. Here those that leave docs/ become links of the site: a folder of
  `gen/` leads to its page of the reference, another folder to its README or a list of its files, a file to itself.
  What they name is published beside the pages, so that no link needs to know where the repository is.
* The reference has a page for each folder of `gen/`, made of its modules' docstrings.
"""

from __future__ import annotations

import ast
import posixpath
import re
from collections.abc import Iterator
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files, InclusionLevel
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[2]
DOCS, HOME, PACKAGE, REFERENCE = "docs", "README.md", "gen", "reference"

_LINK = re.compile(r"(?<=\]\()(?!\w+:|#|/)([^)\s#]+)")
"""The target of a link in Markdown, without its anchor."""
_ROW = re.compile(r"^\|.*$", re.MULTILINE)
_BAR = "\ue000"
"""Stands for an escaped bar in a table, which GitHub shows as a bar, and Python-Markdown in code with its backslash."""


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Put the reference into the navigation."""
    pages = [{f"{PACKAGE}.{room}" if room else PACKAGE: _reference_page(room)} for room in ["", *_rooms()]]
    assert config.nav is not None
    config.nav.append({"Reference": pages})
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the home page, the reference, and what the pages link to."""
    made = {_reference_page(room): _reference(room) for room in ["", *_rooms()]}
    open_paths = [f"{DOCS}/{file.src_uri}" for file in files.documentation_pages()]
    open_paths += [HOME, *_named(config.nav, [file.src_uri for file in files])]
    seen = set(open_paths)
    while open_paths:
        path = open_paths.pop()
        found: list[str] = []
        if (ROOT / path).is_dir():
            found = _shown(path)
            if _on_site(path) not in found:
                made[_on_site(path)] = _list_of_files(path, found)
        else:
            if path.endswith(".md"):
                found = list(_targets(path))
            if not path.startswith(f"{DOCS}/"):
                files.append(_generated(config, _on_site(path), (ROOT / path).read_bytes()))
        new = [target for target in found if target not in seen and not _has_page(target)]
        seen.update(new)
        open_paths += new
    for uri, text in made.items():
        files.append(_generated(config, uri, text))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Turn links that leave docs/ into links of the site, and show escaped bars in tables as bars."""
    uri = page.file.src_uri
    path = HOME if uri == "index.md" else uri if (ROOT / uri).is_file() else f"{DOCS}/{uri}"
    if not (ROOT / path).is_file():
        return markdown

    def on_site(link: re.Match[str]) -> str:
        target = _absolute(path, link[1])
        if not (ROOT / target).exists():
            return link[1]  # MkDocs says what is wrong with it
        return posixpath.relpath(_on_site(target), posixpath.dirname(uri) or ".")

    return _ROW.sub(lambda row: row[0].replace(r"\|", _BAR), _LINK.sub(on_site, markdown))


def on_page_content(html: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Put the bars back."""
    return html.replace(_BAR, "|")


def _generated(config: MkDocsConfig, uri: str, content: str | bytes) -> File:
    return File.generated(config, uri, content=content, inclusion=InclusionLevel.NOT_IN_NAV)


# ---- links ----


def _absolute(path: str, link: str) -> str:
    """A link in a file of the repository, from the repository's root."""
    return posixpath.normpath(posixpath.join(posixpath.dirname(path), link))


def _targets(path: str) -> Iterator[str]:
    """What a Markdown file links to, where that exists."""
    for link in _LINK.findall((ROOT / path).read_text(encoding="utf-8")):
        target = _absolute(path, link)
        if (ROOT / target).exists():
            yield target


def _has_page(target: str) -> bool:
    """Whether the site holds it anyway: docs/, and the folders of the package."""
    return target.startswith(f"{DOCS}/") or _room_of(target) is not None


def _room_of(target: str) -> str | None:
    """The room of `gen/` that a folder belongs to; None for files and other folders."""
    parts = target.split("/")
    return parts[1] if len(parts) > 1 and parts[0] == PACKAGE and (ROOT / target).is_dir() else None


def _on_site(target: str) -> str:
    """Where something of the repository stands on the site."""
    if target == HOME:
        return "index.md"
    room = _room_of(target)
    if room is not None:
        return _reference_page(room)
    if (ROOT / target).is_dir():
        return f"{target}/README.md" if (ROOT / target / "README.md").is_file() else f"{target}/index.md"
    return target.removeprefix(f"{DOCS}/")


def _shown(folder: str) -> list[str]:
    """What a link to a folder shows: its README, or else all its files."""
    files = sorted(f"{folder}/{entry.name}" for entry in (ROOT / folder).iterdir() if entry.is_file())
    return [file for file in files if file == f"{folder}/README.md"] or files


def _list_of_files(folder: str, files: list[str]) -> str:
    names = [posixpath.basename(file) for file in files]
    return f"# {folder}\n\n" + "".join(f"* [{name}]({name})\n" for name in names)


def _named(nav: object, known: list[str]) -> Iterator[str]:
    """Pages that the navigation names and docs/ does not hold: files at the repository's root."""
    if isinstance(nav, str):
        if nav not in known and (ROOT / nav).is_file():
            yield nav
    elif isinstance(nav, dict):
        for entry in nav.values():
            yield from _named(entry, known)
    elif isinstance(nav, list):
        for entry in nav:
            yield from _named(entry, known)


# ---- reference ----


def _rooms() -> list[str]:
    return sorted(path.parent.name for path in (ROOT / PACKAGE).glob("*/__init__.py"))


def _reference_page(room: str) -> str:
    return f"{REFERENCE}/{room or PACKAGE}.md"


def _reference(room: str) -> str:
    """A page's Markdown: the modules of a room; without a name, those beside the rooms."""
    folder = ROOT / PACKAGE / room
    modules = sorted(folder.rglob("*.py") if room else folder.glob("*.py"), key=_module)
    return "\n".join(_entry(path, folder) for path in modules if path.stem != "__main__")


def _module(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(part for part in parts if part != "__init__")


def _entry(path: Path, folder: Path) -> str:
    """The directive for a module; what a package takes from its modules is shown with them only."""
    options = {}
    if path.parent == folder and path.name == "__init__.py":
        options["heading_level"] = "1"
    if path.name == "__init__.py":
        tree = ast.parse(path.read_text(encoding="utf-8"))
        own = [node.name for node in tree.body if isinstance(node, ast.FunctionDef | ast.ClassDef)]
        options["members"] = str([name for name in own if not name.startswith("_")] or "false")
    lines = [f"::: {_module(path)}", *(["    options:"] if options else [])]
    return "\n".join([*lines, *(f"      {key}: {value}" for key, value in options.items())]) + "\n"
