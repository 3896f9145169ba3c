"""The coefficient file: the only place that knows its format."""

from gen.coefficients.document import Document
from gen.coefficients.reader import Coefficients, check_form, load, parse

__all__ = ["Coefficients", "Document", "check_form", "load", "parse"]
