"""Proves the error bounds of an emitted network anew, from its C++ and its certificate alone.

Like the rest of this room it shares nothing with what emitted the project. docs/proof.md has the theorem.
"""
