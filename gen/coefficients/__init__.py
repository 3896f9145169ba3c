"""The coefficient file: the only place that knows its format, for reading and for writing."""

from gen.coefficients.document import Document
from gen.coefficients.kinds import transfer_functions_only
from gen.coefficients.reader import Coefficients, check_form, load, parse
from gen.coefficients.writer import as_json, dump, in_place_of_parts, with_effects, with_network, with_rules

__all__ = [
    "Coefficients",
    "Document",
    "as_json",
    "check_form",
    "dump",
    "in_place_of_parts",
    "load",
    "parse",
    "transfer_functions_only",
    "with_effects",
    "with_network",
    "with_rules",
]
