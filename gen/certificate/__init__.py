"""Proves an emitted project's error bounds anew, from its C++ and its certificate alone.

Nothing here is shared with what emitted the project: the C++ is read as text and by a compiler, the differential
equation is enclosed in whole numbers, roundings follow from the statements of the C++, and every inequality is decided
with results rounded outward. docs/proof.md has the theorem.
"""
