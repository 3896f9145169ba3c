"""Proves an emitted project's error bounds anew, from its C++ and its certificate alone.

Nothing here is shared with what emitted the project: the C++ is read as text and by a compiler, the differential equation
is solved in intervals, and every inequality is decided in whole numbers. docs/proof.md has the theorem.
"""
