"""The docs as a site: it builds without a warning, its links lead somewhere, and it fetches nothing."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

ROOT = Path(__file__).parents[2]
ROOMS = sorted(path.parent.name for path in (ROOT / "gen").glob("*/__init__.py"))


class Page(HTMLParser):
    """What a page links to and loads, and what can be linked to in it."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.anchors: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        values = {key: value or "" for key, value in attributes}
        self.anchors |= {values[key] for key in ("id", "name") if key in values}
        if tag == "a" and "href" in values:
            self.links.append(values["href"])
        elif tag == "link" and values.get("rel") not in ("canonical", "next", "prev"):
            self.loaded.append(values["href"])
        elif "src" in values:
            self.loaded.append(values["src"])


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    quiet = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    done = subprocess.run(command, cwd=ROOT, env=quiet, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not re.findall(r"^(?:WARNING|ERROR).*", done.stderr, re.MULTILINE)
    return folder


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Page]:
    return {path: Page(path) for path in site.rglob("*.html") if path.name != "404.html"}


def test_every_link_between_pages_leads_to_something_that_is_there(site: Path, pages: dict[Path, Page]) -> None:
    dead = []
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            anchors = pages[target].anchors if target in pages else set()
            if not target.is_file() or (parts.fragment and unquote(parts.fragment) not in anchors):
                dead.append(f"{path.relative_to(site)}: {link}")
    assert not dead


def test_nothing_is_loaded_from_elsewhere(site: Path, pages: dict[Path, Page]) -> None:
    for page in pages.values():
        assert not [address for address in page.loaded if urlsplit(address).netloc]
    for sheet in site.rglob("*.css"):
        assert not re.findall(r"(?:@import|url\()\s*[\"']?(?:https?:)?//", sheet.read_text(encoding="utf-8"))


@pytest.mark.parametrize("room", ROOMS)
def test_the_reference_has_a_page_for_each_room(room: str, site: Path) -> None:
    text = (site / "reference" / f"{room}.html").read_text(encoding="utf-8")
    modules = [path for path in (ROOT / "gen" / room).rglob("*.py") if path.stem not in ("__init__", "__main__")]
    for path in modules:
        assert f'id="{".".join(path.relative_to(ROOT).with_suffix("").parts)}"' in text


def test_the_reference_shows_units_and_shapes_of_a_public_function(site: Path) -> None:
    text = (site / "reference" / "coefficients.html").read_text(encoding="utf-8")
    assert 'id="gen.coefficients.reader.load"' in text
    assert "With the file, the JSON path (or line and column), what was found and what was expected." in text


def test_the_home_page_is_the_readme(site: Path) -> None:
    title = (ROOT / "README.md").read_text(encoding="utf-8").splitlines()[0].removeprefix("# ")
    assert title in (site / "index.html").read_text(encoding="utf-8")


def test_links_out_of_the_docs_lead_to_published_files(site: Path) -> None:
    home = Page(site / "index.html").links
    assert "gen/schema/gen-coefficients-2.schema.json" in home
    for version in (1, 2):
        schema = Path("gen") / "schema" / f"gen-coefficients-{version}.schema.json"
        assert (site / schema).read_bytes() == (ROOT / schema).read_bytes()
