"""The published JSON Schema of the coefficient file, made from the same models that read it.

``python -m gen.coefficients.schema`` writes the stored file anew.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from gen.coefficients.document import Document
from gen.coefficients.versions import FORMAT, VERSION
from gen.model.effects import catalogue_only

_FOLDER = Path(__file__).parent.parent / "schema"


def published(version: int) -> Path:
    """Where the schema of a version is stored; those of versions before the newest are never written anew."""
    return _FOLDER / f"gen-coefficients-{version}.schema.json"


STORED = published(VERSION)
"""That of the newest version."""


def json_schema() -> dict[str, Any]:
    """Give the schema, draft 2020-12.

    It expresses types, keys, limits of single values and the choice of a schedule's kind. What relates one
    part of the file to another (references, ranges within ranges, stability) is left to
    :func:`gen.coefficients.load`.
    """
    made = Document.model_json_schema(mode="validation")
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": f"urn:gen:{FORMAT}:{VERSION}",
        **made,
        "title": f"{FORMAT} {VERSION}",
    }


def schema_text() -> str:
    """Give the schema as the text of the stored file, which knows the catalogue's effects alone."""
    with catalogue_only():
        return json.dumps(json_schema(), indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    STORED.write_text(schema_text(), encoding="utf-8")
