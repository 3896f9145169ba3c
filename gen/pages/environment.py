"""The environment that HTML pages are rendered in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from jinja2 import Environment

from gen.pages.charts import svg
from gen.templating import environment


def page_environment(**filters: Callable[..., Any]) -> Environment:
    """An environment of ``templates/pages``, with ``svg`` for charts and the page's own filters."""
    made = environment("pages").overlay()
    made.filters = {**made.filters, "svg": svg, **filters}
    return made
