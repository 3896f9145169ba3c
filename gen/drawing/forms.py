"""The forms that a drawing may have, by the name of its file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gen.errors import InputError

if TYPE_CHECKING:
    from gen.drawing.section import Section

_FORMS = (".html", ".svg", ".png")


def form_of(path: Path) -> str:
    """Give the form that a file's name asks for.

    Raises
    ------
    InputError
        If there is no such form.
    """
    form = path.suffix.lower()
    if form not in _FORMS:
        raise InputError(f"expected a name that ends with {', '.join(_FORMS[:-1])} or {_FORMS[-1]}", file=str(path))
    return form


def drawn(sections: Sequence[Section], form: str) -> bytes:
    """Draw runs in a form of :func:`form_of`: a page to zoom into, or a picture."""
    # Slow to import, each of them.
    if form == ".html":
        from gen.drawing.interactive import page_html

        return page_html(sections, ", ".join(section.title for section in sections[:3])).encode()
    from gen.drawing.picture import picture

    return picture(sections, "svg" if form == ".svg" else "png")
